from __future__ import annotations

import json
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, ClassVar

import jsonschema
import numpy as np
import pytest

import morph.app.report.learn
from morph.app.report.learn.drawn import commands, joints, learning
from morph.app.report.learn.files import write_learned
from morph.app.report.learn.judge import judge
from morph.app.report.learn.outcome import LearnOutcome, record_text
from morph.app.report.learn.page import learned_page
from morph.app.report.learn.words import headline, number, summary
from morph.body.load import load
from morph.errors import OutputError
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.search.search import Learned, Problem, Search, Trial
from morph.task.tasks import task

HOSTILE = "</svg><script>alert(1)</script>\" onload='x' {{ 7 * 7 }}"
LOADING = {"href", "srcset", "data", "action", "poster", "background", "xlink:href"}


@dataclass(frozen=True, kw_only=True)
class Named(Search):
    name: ClassVar[str] = "named"

    step: float = 0.5
    """A setting."""

    def solve(self, problem: Problem, **how: Any) -> Learned:
        raise NotImplementedError


@pytest.fixture(scope="module")
def outcome() -> LearnOutcome:
    robot = load("cartpole")
    balance = task("balance", robot)
    # Feedback that balances; where it is from stands in `tests/morph/app/cli/test_learn.py`.
    gain = np.array([[-2.7, 27.2, -3.3, 4.3]])
    policy = Linear(
        weight=-gain,
        bias=gain @ np.array([0.0, np.pi, 0.0, 0.0]),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=balance.period,
    )
    trials = tuple(
        Trial(
            number=at, loss=100.0 / at, success=float(at > 2), seconds=2.0 * at, experience=5.0 * at
        )
        for at in range(1, 5)
    )
    return LearnOutcome(
        task=balance,
        search=Named(),
        policy=policy,
        judged=judge(balance, policy, balance.simulator(), 7),
        trials=trials,
        claimed=True,
        why_not="",
        seed=7,
        asked=4,
        experience=20.0,
        seconds=8.0,
        command="morph learn balance --robot cartpole --out DIR",
    )


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._within = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._within = tag

    def handle_data(self, data: str) -> None:
        if self._within != "style" and data.strip():
            self.words.append(data.strip())


def test_the_verdict_in_words_comes_before_every_picture_and_figure(outcome: LearnOutcome) -> None:
    text = learned_page(outcome, (), "morph simulate")
    body = text[text.index("<body>") :]
    first = min(body.index(tag) for tag in ("<svg", "<table", '<div class="rows"'))
    assert body.index("<h1>cartpole has learned balance</h1>") < first
    assert body.index("All of 100 noisy runs") < first


def test_the_page_loads_nothing_and_runs_nothing(outcome: LearnOutcome) -> None:
    page = Page(learned_page(outcome, (), "morph simulate"))
    assert "script" not in {tag for tag, _ in page.elements}
    assert not [named for _, names in page.elements for named in names if named in LOADING]
    assert not [name for _, names in page.elements for name in names if name.startswith("on")]
    (policy,) = (names["content"] for tag, names in page.elements if "http-equiv" in names)
    assert policy is not None
    assert "default-src 'none'" in policy
    assert "script-src 'none'" in policy


def test_words_from_elsewhere_stay_words(outcome: LearnOutcome) -> None:
    trials = (replace(outcome.trials[0], note=HOSTILE),)
    spoilt = replace(
        outcome,
        trials=trials,
        claimed=False,
        why_not=HOSTILE,
        notes=(HOSTILE,),
        command=HOSTILE,
        task=replace(
            outcome.task,
            name=HOSTILE,
            terms=tuple(
                replace(term, name=f"{HOSTILE}{at}") for at, term in enumerate(outcome.task.terms)
            ),
        ),
        judged=replace(outcome.judged, terms={HOSTILE: 1.0}, goals={HOSTILE: 1.0}),
    )
    page = Page(learned_page(spoilt, (), HOSTILE))
    assert "script" not in {tag for tag, _ in page.elements}
    assert not [name for _, names in page.elements for name in names if name.startswith("on")]
    assert " ".join(page.words).count("{{ 7 * 7 }}") >= 8


def test_the_learning_curve_runs_over_trials_experience_and_seconds(outcome: LearnOutcome) -> None:
    plots = learning(outcome)
    assert [plot.x_title for plot in plots] == ["trial", "experience, s", "seconds"]
    for plot, x in zip(plots, ([1, 2, 3, 4], [5, 10, 15, 20], [2, 4, 6, 8]), strict=True):
        assert list(plot.lines[0].x) == x
        assert list(plot.lines[0].y) == [100.0, 50.0, 100.0 / 3, 25.0]
    inside = replace(outcome, experience=0.0)
    assert [plot.x_title for plot in learning(inside)] == ["round", "seconds"]
    assert learning(replace(outcome, trials=())) == ()


def test_joints_and_commands_are_drawn_with_what_bounds_them(outcome: LearnOutcome) -> None:
    slide, hinge = joints(outcome)
    assert (slide.title, hinge.title) == ("slide, m", "hinge, rad")
    # The goals of the task: ten degrees and 0.15 m, through the last 4.5 of 5 s.
    assert slide.bands[0].y == pytest.approx((-0.15, 0.15))
    assert hinge.bands[0].x == pytest.approx((0.5, 5.0))
    assert hinge.bands[0].y == pytest.approx((np.pi - 0.17, np.pi + 0.17))
    (told,) = commands(outcome)
    assert told.bounds == (-10.0, 10.0)
    # A command is held: it changes at one time from one level to the next.
    x, y = told.lines[-1].x, told.lines[-1].y
    assert len(x) == len(y) == 2 * 251 - 1
    assert set(np.flatnonzero(np.diff(y))) <= set(np.flatnonzero(np.diff(x) == 0.0))


def test_controls_start_where_the_policy_started(outcome: LearnOutcome) -> None:
    judged = outcome.judged
    assert set(judged.controls) == {"nothing", "random"}
    assert {len(score.loss) for score in judged.controls.values()} == {judged.rows} == {100}
    # Loss of the first sample is that of the start alone; here it is drawn about the top.
    again = judge(outcome.task, outcome.policy, outcome.task.simulator(), 7)
    assert np.array_equal(again.loss, judged.loss)
    assert np.array_equal(again.controls["random"].loss, judged.controls["random"].loss)
    other = judge(outcome.task, outcome.policy, outcome.task.simulator(), 8)
    assert not np.array_equal(other.loss, judged.loss)


def test_how_many_runs_judge_follows_from_the_task_alone(
    outcome: LearnOutcome, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Work of a run: 2 coordinates x 5 s / 10 ms = 1000, so 25 runs fit into 25000.
    monkeypatch.setattr("morph.app.report.learn.judge.MOST_WORK", 25000.0)
    fewer = judge(outcome.task, outcome.policy, outcome.task.simulator(), 7)
    assert fewer.rows == 25
    assert {len(score.loss) for score in fewer.controls.values()} == {25}
    monkeypatch.setattr("morph.app.report.learn.judge.CONTROL_WORK", 12000.0)
    heavy = judge(outcome.task, outcome.policy, outcome.task.simulator(), 7)
    # The same starts: doing nothing draws no other chance.
    assert np.array_equal(heavy.controls["nothing"].loss, fewer.controls["nothing"].loss[:12])


def test_the_typical_run_is_in_the_middle(outcome: LearnOutcome) -> None:
    loss = outcome.judged.loss
    assert abs((loss < loss[outcome.judged.typical]).sum() - 49.5) <= 0.5


def test_a_failure_names_its_reason_and_success_is_not_claimed_for_the_search_alone(
    outcome: LearnOutcome,
) -> None:
    missed = replace(outcome.judged, success=np.arange(100) < 49)
    half = replace(outcome, judged=missed)
    assert not half.succeeded
    assert half.why == "49 of 100 runs reach every goal"
    assert headline(half) == "cartpole does balance at times, and not reliably"
    assert replace(outcome, judged=replace(missed, success=np.arange(100) < 50)).succeeded
    modest = replace(outcome, claimed=False, why_not="it was stopped")
    assert (modest.succeeded, modest.why) == (False, "it was stopped")
    assert "All of 100 noisy runs" in summary(modest)[0]


def test_the_trial_by_chance_is_experience_and_no_trial(outcome: LearnOutcome) -> None:
    first = Trial(number=0, loss=300.0, success=0.0, seconds=0.5, experience=5.0)
    begun = replace(outcome, trials=(first, *outcome.trials))
    assert begun.count == 4
    assert "took 8 s, four trials and 20 s of experience." in summary(begun)[1]


def test_a_loss_that_is_no_number_is_null(outcome: LearnOutcome) -> None:
    lost = replace(outcome, trials=(replace(outcome.trials[0], loss=float("inf")),))
    said = json.loads(record_text(lost))
    assert said["trials"][0]["loss"] is None
    folder = Path(morph.app.report.learn.__file__).parent
    jsonschema.validate(said, json.loads((folder / "learned.schema.json").read_text()))
    learned_page(lost, (), "")


def test_what_is_written_holds_pictures_where_it_can_be_drawn(
    outcome: LearnOutcome, tmp_path: Path
) -> None:
    written = write_learned(outcome, tmp_path / "out", see="morph simulate")
    text = (tmp_path / "out/report.html").read_text()
    if written.notes:
        pytest.skip(written.notes[0])
    pictures = [names for tag, names in Page(text).elements if tag == "img"]
    assert len(pictures) == 8
    assert all((names["src"] or "").startswith("data:image/jpeg;base64,") for names in pictures)
    assert (tmp_path / "out/strip.jpg").read_bytes()[:2] == b"\xff\xd8"
    assert len(text) < 1_000_000


def test_a_folder_that_cannot_be_written_to_is_said(outcome: LearnOutcome, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    with pytest.raises(OutputError, match="Not a directory"):
        write_learned(outcome, tmp_path / "out", see="")


@pytest.mark.parametrize(
    ("value", "words"),
    [(15.25, "15.2"), (0.001234, "0.00123"), (11049.4, "11049"), (2e7, "2e+07"), (np.inf, "none")],
)
def test_numbers_are_told_as_people_read_them(value: float, words: str) -> None:
    assert number(value) == words
