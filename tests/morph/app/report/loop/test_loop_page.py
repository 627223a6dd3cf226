from __future__ import annotations

from dataclasses import replace
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest

from morph.app.report.loop.drawn import predicted, true_states
from morph.app.report.loop.outcome import LoopOutcome
from morph.app.report.loop.page import loop_page
from morph.body.load import load
from morph.model.latent.parameter_attribution import Difference, Explained
from morph.model.latent.unknowns import turned
from morph.policy_transfer.repair import Repair, TaskModel
from morph.policy_transfer.retask import task_for
from morph.search.target import Experience, Simulated
from morph.task.tasks import task

HOSTILE = "</svg><script>alert(1)</script>\" onload='x' {{ 7 * 7 }}"
LOADING = {"href", "src", "srcset", "data", "action", "poster", "background", "xlink:href"}
HEAVY = {"weight:cart": 3.0}


def run_of(factors: dict[str, float]) -> Experience:
    """Return a noiseless swing of a changed cart-pole under a known command."""
    here = task("swing-up", load("cartpole"))
    there = replace(task_for(here, turned(here.robot, factors)) if factors else here, noise=0.0)
    told = 8.0 * np.sin(np.arange(there.samples - 1) / 5.0)[:, None]
    target = Simulated(task=there, simulator=there.simulator())
    return target.trial(told, np.random.default_rng(100))


@pytest.fixture(scope="module")
def outcome() -> LoopOutcome:
    here = task("swing-up", load("cartpole"))
    robot = turned(here.robot, HEAVY)
    explained = Explained(
        inferred=SimpleNamespace(robot=robot, effects=(), unsaid=0.001, states=()),  # type: ignore[arg-type]
        differences=(Difference(name="weight:cart", value=3.0, low90=2.9, high90=3.1),),
        rivals=(("weight:cart", 0.8), (HOSTILE, 0.2)),
        evidence=9.0,
    )
    repair = Repair(
        model=TaskModel(task=task_for(here, robot), effects=()), explained=explained, task=here
    )
    return LoopOutcome(
        task=here,
        target=HOSTILE,
        runs=(run_of(HEAVY),),
        transferred=None,
        repair=repair,
        concealed={"weight:cart": 3.0, "length:pole": 0.9},
        seed=0,
        command=f"morph loop {HOSTILE}",
        notes=(HOSTILE,),
    )


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))


def test_the_page_loads_nothing_and_runs_nothing_whatever_it_is_told(outcome: LoopOutcome) -> None:
    page = Page(loop_page(outcome))
    assert "script" not in {tag for tag, _ in page.elements}
    assert not [named for _, names in page.elements for named in names if named in LOADING]
    assert not [name for _, names in page.elements for name in names if name.startswith("on")]
    (policy,) = (names["content"] for tag, names in page.elements if "http-equiv" in names)
    assert policy is not None
    assert "default-src 'none'" in policy


def test_what_differs_comes_in_words_before_every_picture(outcome: LoopOutcome) -> None:
    text = loop_page(outcome)
    body = text[text.index("<body>") :]
    first = min(body.index(tag) for tag in ("<svg", "<table", '<div class="rows"'))
    assert body.index("cartpole differs from its description in one thing") < first
    assert body.index("cart is 3.0 times as heavy (2.9 to 3.1)") < first


def test_the_seal_says_what_was_found_and_what_was_missed(outcome: LoopOutcome) -> None:
    opened = outcome.opened()
    assert opened is not None
    assert [(each["name"], each["found"]) for each in opened["concealed"]] == [
        ("weight:cart", 3.0),
        ("length:pole", None),
    ]
    assert "not named" in loop_page(outcome)


def test_the_true_model_foretells_a_run_and_another_does_not(outcome: LoopOutcome) -> None:
    assert outcome.repair is not None
    (run,) = outcome.runs
    states = true_states(outcome, 0)
    right = predicted(outcome.repair.model.simulator, run, states)
    wrong = predicted(outcome.task.simulator(), run, states)
    assert right is not None
    assert wrong is not None
    length = right.shape[1] - 1
    # Windows of half a second, ten periods of 0.05 s; three seconds hold six.
    assert (len(right), length) == (6, 10)
    for row in range(6):
        seen = run.position[row * length : (row + 1) * length + 1]
        assert right[row] == pytest.approx(seen, abs=1e-9)
    seen = run.position[length]
    assert np.abs(wrong[0, -1] - seen).max() > 0.05


def test_a_run_that_ends_within_a_window_is_foretold_to_its_end(outcome: LoopOutcome) -> None:
    (run,) = outcome.runs
    short = replace(
        run, position=run.position[:15], velocity=run.velocity[:15], command=run.command[:14]
    )
    assert outcome.repair is not None
    states = true_states(replace(outcome, runs=(short,)), 0)
    found = predicted(outcome.repair.model.simulator, short, states)
    assert found is not None
    assert found[1, :5] == pytest.approx(short.position[10:15], abs=1e-9)
    loop_page(replace(outcome, runs=(short,)))
