from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import jsonschema
import numpy as np
import pytest

import morph.app.report.learn
from morph.app.cli.main import main
from morph.body.load import load
from morph.errors import OutputError, SearchError
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.store import load_policy
from morph.record.load import load as load_recordings
from morph.search import searches
from morph.search.evaluate import attempt, evaluate
from morph.search.search import Learned, Problem, Search, State, Told, Trial, ignore
from morph.task.tasks import task

SCHEMA = json.loads(
    (Path(morph.app.report.learn.__file__).parent / "learned.schema.json").read_text()
)
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")

GAIN = np.array([[-2.7, 27.2, -3.3, 4.3]])
"""Feedback that balances the cart-pole: scipy's Riccati equation on finite differences of
MuJoCo's step, rounded; six tenths of it hold the pole, two tenths do not."""
UPRIGHT = np.array([0.0, np.pi, 0.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class Growing(Search):
    """Feedback that grows by a fifth each trial."""

    name: ClassVar[str] = "growing"
    interrupted: ClassVar[int] = 0
    seen: ClassVar[list[Problem]] = []
    slow: ClassVar[float] = 0.0

    def run(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        told: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        type(self).seen.append(problem)
        simulator = problem.simulator or problem.task.simulator()
        done = [] if state is None else list(state["losses"])
        policy, success = None, 0.0
        for number in range(len(done) + 1, (trials or 5) + 1):
            if number == self.interrupted:
                raise KeyboardInterrupt
            time.sleep(self.slow)
            policy = balancing(problem, number / 5)
            score = evaluate(
                problem.task, policy, simulator, rng=np.random.default_rng([seed, number]), rows=10
            )
            done.append(score.mean)
            success = score.share
            trial = Trial(
                number=number,
                loss=score.mean,
                success=success,
                seconds=0.0,
                experience=5.0 * number if self.from_trials else 0.0,
            )
            told(trial, {"losses": np.array(done)})
        policy = policy or balancing(problem, len(done) / 5)
        return Learned(
            policy=policy,
            trials=(),
            succeeded=success > 0.5,
            why="" if success > 0.5 else "its feedback is too weak",
        )


@dataclass(frozen=True, kw_only=True)
class FromTrials(Growing):
    """The same, as a search from trials."""

    name: ClassVar[str] = "from-trials"
    from_trials: ClassVar[bool] = True


@dataclass(frozen=True, kw_only=True)
class Refusing(Search):
    """Makes nothing of any task."""

    name: ClassVar[str] = "refusing"

    def run(self, problem: Problem, **_: Any) -> Learned:
        raise SearchError("it needs gradients", where="task balance", fix="take cmaes")


def balancing(problem: Problem, share: float) -> Linear:
    robot = problem.task.robot
    gain = share * GAIN
    return Linear(
        weight=-gain,
        bias=gain @ UPRIGHT,
        action=actions_of(robot),
        observation=observations_of(robot),
        period=problem.task.period,
    )


def undrawn(*_: object) -> None:
    raise OutputError("there is no OpenGL", where="--video", fix="install one")


@pytest.fixture(autouse=True)
def registered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("tried_searches")
    for kind in (Growing, FromTrials, Refusing):
        setattr(module, kind.__name__, kind)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    known = {
        "growing": "tried_searches:Growing",
        "from-trials": "tried_searches:FromTrials",
        "refusing": "tried_searches:Refusing",
    }
    monkeypatch.setattr(searches, "SEARCHES", known)
    monkeypatch.setattr(Growing, "interrupted", 0)
    monkeypatch.setattr(Growing, "seen", [])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    # A hundred runs take a second, and pictures another; the tests of the report have both.
    monkeypatch.setattr("morph.app.report.learn.judge.ROWS", 10)
    monkeypatch.setattr("morph.app.report.learn.files.strip", undrawn)


BALANCE = ("balance", "--robot", "cartpole", "--search", "growing", "--out", "out")


def learn(*arguments: str, status: int = 0) -> None:
    assert main(["learn", *arguments]) == status


def record(out: str = "out") -> dict[str, Any]:
    said: dict[str, Any] = json.loads((Path(out) / "record.json").read_text())
    jsonschema.validate(said, SCHEMA)
    return said


def content(out: str = "out") -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path(out).rglob("*") if path.is_file()}


def test_a_search_that_succeeds_leaves_a_policy_a_record_and_a_report(
    capsys: pytest.CaptureFixture[str],
) -> None:
    learn(*BALANCE, "--quiet")
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.startswith("cartpole has learned balance\n")
    assert "see it by: morph simulate cartpole --policy out/policy" in told.out
    said = record()
    assert (said["succeeded"], said["why"], said["judged"]["success"]) == (True, "", 1.0)
    assert [trial["number"] for trial in said["trials"]] == [1, 2, 3, 4, 5]
    # Nothing falls from 11,000, and what balances costs a few.
    assert said["controls"]["nothing"]["loss"]["mean"] > 1e3 > said["judged"]["loss"]["mean"]
    assert said["controls"]["random"]["success"] == 0.0
    assert sum(said["judged"]["terms"].values()) == pytest.approx(said["judged"]["loss"]["mean"])
    assert {path.name for path in Path("out").iterdir()} == {
        *("policy", "record.json", "report.html", "state.npz"),
    }


def test_the_policy_on_disk_is_the_one_that_was_judged() -> None:
    learn(*BALANCE, "--quiet", "--seed", "3")
    robot = load("cartpole")
    policy = load_policy("out/policy", robot)
    seen = np.array([[0.1, 3.0, 0.2, -0.1]])
    assert policy.act(seen, np.zeros(1))[0] == pytest.approx(-GAIN @ (seen[0] - UPRIGHT))
    said = json.loads(Path("out/policy/policy.json").read_text())
    assert said["task"]["name"] == "balance"
    assert said["task"]["sha256"] == record()["task"]["sha256"]
    learned = said["learned"]
    assert (learned["search"], learned["trials"], learned["seed"]) == ("growing", 5, 3)
    assert (learned["cost"], learned["success"]) == (
        pytest.approx(record()["judged"]["loss"]["mean"]),
        1.0,
    )


def test_the_command_that_shows_the_policy_moves_as_the_judged_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "1000")
    learn(*BALANCE, "--quiet")
    line = capsys.readouterr().out.partition("see it by: morph ")[2].strip()
    words = shlex.split(line.removesuffix(" --view"))
    assert main([*words, "--out", "run.npz"]) == 0
    (run,) = load_recordings(Path("run.npz"), robot=load("cartpole"))
    balance = task("balance", load("cartpole"))
    policy = load_policy("out/policy", balance.robot)
    due = attempt(balance, policy, balance.simulator(), rows=1, rng=None)
    every = round(balance.period / balance.step)
    # The start is told to six figures, so an angle of pi is off by 3e-6; feedback does not grow it.
    for joint in ("slide", "hinge"):
        found = run[f"{joint}.position"][::every]
        assert found == pytest.approx(due.joint(joint)[0], abs=1e-4)


def test_each_trial_is_a_line_unless_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    learn(*BALANCE)
    lines = capsys.readouterr().err.splitlines()
    assert [
        re.match(r"trial (\d), loss [\d.e+]+, success \d+ %, [\d.]+ s$", each) for each in lines
    ]
    assert len(lines) == 5


def test_json_is_the_record(capsys: pytest.CaptureFixture[str]) -> None:
    learn(*BALANCE, "--quiet", "--json")
    assert capsys.readouterr().out == Path("out/record.json").read_text()


def test_a_search_that_does_not_succeed_says_so_everywhere(
    capsys: pytest.CaptureFixture[str],
) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    words = capsys.readouterr().out
    assert "has not learned balance" in words
    assert "it did not succeed: its feedback is too weak" in words
    said = record()
    assert (said["succeeded"], said["why"]) == (False, "its feedback is too weak")
    learned = json.loads(Path("out/policy/policy.json").read_text())["learned"]
    assert (learned["success"], learned["succeeded"]) == (0.0, False)
    assert "marked as one that did not succeed" in Path("out/report.html").read_text()


def test_an_interrupted_search_goes_on_to_what_it_would_have_found(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    learn(*BALANCE[:-1], "whole", "--quiet")
    monkeypatch.setattr(Growing, "interrupted", 3)
    learn(*BALANCE, "--quiet", status=130)
    assert "after 2 trials; the same command goes on from there" in capsys.readouterr().err
    assert sorted(content()) == ["out/state.npz"]
    monkeypatch.setattr(Growing, "interrupted", 0)
    learn(*BALANCE)
    lines = capsys.readouterr().err.splitlines()
    assert [each.split(",")[0] for each in lines] == ["trial 3", "trial 4", "trial 5"]
    again, whole = record(), record("whole")
    assert [each["loss"] for each in again["trials"]] == [each["loss"] for each in whole["trials"]]
    assert again["judged"] == whole["judged"]
    seconds = [each["seconds"] for each in again["trials"]]
    assert seconds == sorted(seconds)
    for name in ("policy/weights.safetensors", "policy/policy.onnx"):
        if name.endswith("tensors"):
            assert content()[f"out/{name}"] == content("whole")[f"whole/{name}"]


def test_an_interrupt_before_the_first_trial_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Growing, "interrupted", 1)
    learn(*BALANCE, status=130)
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert not Path("out").exists()


def test_a_killed_search_goes_on(capsys: pytest.CaptureFixture[str]) -> None:
    here = Path(__file__)
    script = f"""
import importlib.util, sys
spec = importlib.util.spec_from_file_location("tried_searches", {str(here)!r})
module = importlib.util.module_from_spec(spec)
sys.modules["tried_searches"] = module
spec.loader.exec_module(module)
module.Growing.slow = 1.0
module.searches.SEARCHES = {{"growing": "tried_searches:Growing"}}
sys.exit(module.main({["learn", *BALANCE, "--trials", "100"]!r}))
"""
    process = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60.0
    while not Path("out/state.npz").exists() and time.monotonic() < until:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    assert sorted(content()) == ["out/state.npz"]
    learn(*BALANCE)
    told = capsys.readouterr().err
    assert "trial 1," not in told
    assert "trial 5," in told
    assert [each["number"] for each in record()["trials"]] == [1, 2, 3, 4, 5]


def test_what_is_done_is_not_done_again(capsys: pytest.CaptureFixture[str]) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    before = content()
    capsys.readouterr()
    learn(*BALANCE, "--trials", "1", status=3)
    told = capsys.readouterr()
    assert "out holds this search already, and it did not succeed" in told.out
    assert told.err == ""
    assert len(Growing.seen) == 1
    assert content() == before
    learn(*BALANCE, "--trials", "1", "--json", status=3)
    assert capsys.readouterr().out == Path("out/record.json").read_text()


def test_more_trials_go_on_from_those_that_were_made(capsys: pytest.CaptureFixture[str]) -> None:
    learn(*BALANCE, "--quiet", "--trials", "2", status=3)
    learn(*BALANCE, "--trials", "4")
    lines = capsys.readouterr().err.splitlines()
    assert [each.split(",")[0] for each in lines] == ["trial 3", "trial 4"]
    assert [each["number"] for each in record()["trials"]] == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("others", "what"),
    [
        (("--seed", "1"), "another seed"),
        (("--search", "from-trials"), "another search"),
        (("--effect", "viscous_friction@hinge:b=0.1"), "another task"),
    ],
)
def test_a_folder_is_kept_for_its_own_search(
    others: tuple[str, ...], what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    capsys.readouterr()
    found = refused(capsys, *BALANCE, "--trials", "1", *others)
    assert what in found["what"]
    assert "--fresh" in found["fix"]
    learn(*BALANCE, "--quiet", "--trials", "1", "--fresh", *others, status=3)
    assert [each["number"] for each in record()["trials"]] == [1]


def test_a_search_from_trials_is_given_no_simulator() -> None:
    learn("balance", "--robot", "cartpole", "--search", "from-trials", "--out", "out", "--quiet")
    (problem,) = Growing.seen
    assert problem.simulator is None
    assert problem.target is not None
    assert record()["spent"]["experience_s"] == 25.0
    assert "s of experience" in Path("out/report.html").read_text()


def test_what_is_asked_to_act_acts_on_the_target_and_is_recorded() -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", "--effect", "viscous_friction@hinge:b=5", status=3)
    (problem,) = Growing.seen
    assert problem.model.model.dof_damping[1] == 5.0
    assert record()["effects"] == ["viscous_friction@hinge"]


def test_where_nothing_draws_the_report_says_so() -> None:
    learn(*BALANCE, "--quiet")
    assert record()["notes"] == ["there are no pictures: there is no OpenGL"]
    assert "there are no pictures: there is no OpenGL" in Path("out/report.html").read_text()


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> re.Match[str]:
    """Return the one message of a command that must be refused and write nothing."""
    before = content(".")
    assert main(["learn", *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    found = MESSAGE.fullmatch(told.err)
    assert found, told.err
    assert content(".") == before
    return found


@pytest.mark.parametrize(
    ("changed", "what", "fix"),
    [
        ({0: "balanse"}, "there is no task 'balanse'", "'balance'"),
        ({2: "cartpol"}, "no robot is called", "morph list robots"),
        ({4: "growin"}, "there is no search 'growin'", "'growing'"),
        ({2: "hexapod_swimmer"}, "not held to the world", "cartpole"),
        ({4: "refusing"}, "it needs gradients", "cmaes"),
        ({6: " "}, "no folder is named", "name a new"),
    ],
)
def test_what_cannot_be_done_is_one_message(
    changed: dict[int, str], what: str, fix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [changed.get(at, word) for at, word in enumerate(BALANCE)]
    found = refused(capsys, *words)
    assert what in f"{found['where']}: {found['what']}"
    assert fix in found["fix"]


@pytest.mark.parametrize(
    ("more", "what"),
    [
        (("--trials", "0"), "a search of 0 trials learns nothing"),
        (("--seed", "-1"), "-1 is no seed"),
        (("--world", "wate"), "there is no world 'wate'"),
        (("--effect", "coulomb@hinge"), "there is no effect 'coulomb'"),
        (("--effects", "none.toml"), "none.toml"),
    ],
)
def test_what_no_option_can_hold_is_one_message(
    more: tuple[str, ...], what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found = refused(capsys, *BALANCE, *more)
    assert what in f"{found['where']}: {found['what']}"


def test_a_body_without_actuators_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("bare.xml").write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
    found = refused(capsys, *[{"cartpole": "bare.xml"}.get(word, word) for word in BALANCE])
    assert found["what"] == "the body has no actuator"


def test_goals_that_a_body_cannot_reach_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("held.xml").write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0" limited="true" '
        'range="28.65 57.3"/><geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/>'
        '</body></worldbody><actuator><motor name="motor" joint="hinge"/></actuator></mujoco>'
    )
    found = refused(capsys, *[{"cartpole": "held.xml"}.get(word, word) for word in BALANCE])
    # It hangs at 0 and stands at pi; 28.65 degrees are 0.5 rad.
    assert "would have to stand at 3.14 rad, and its range is 0.5 to 1" in found["what"]


def test_a_cost_that_is_no_number_is_one_message(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        "morph.task.term.Term.error",
        lambda self, moved: np.full((*moved.position.shape[:-1], 1), np.nan),
    )
    assert "is no number in" in refused(capsys, *BALANCE, "--quiet")["what"]


def test_a_place_that_is_not_ours_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    Path("file").write_text("mine")
    Path("folder").mkdir()
    Path("folder/mine.txt").write_text("mine")
    assert "this is a file" in refused(capsys, *BALANCE[:-1], "file")["what"]
    assert "not empty" in refused(capsys, *BALANCE[:-1], "folder")["what"]
    assert "nothing can be written" in refused(capsys, *BALANCE[:-1], "/proc/morph/out")["what"]


@pytest.mark.parametrize("name", ["state.npz", "record.json"])
def test_a_spoilt_file_is_refused_and_begun_anew_when_asked(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    Path("out", name).write_bytes(b"PK\x03\x04 no more")
    capsys.readouterr()
    found = refused(capsys, *BALANCE, "--trials", "1")
    assert name in found["where"]
    assert "--fresh" in found["fix"]
    learn(*BALANCE, "--quiet", "--trials", "1", "--fresh", status=3)
    assert record()["why"]


def test_a_finished_search_without_its_state_is_not_begun_over_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    Path("out/state.npz").unlink()
    capsys.readouterr()
    assert "without its state" in refused(capsys, *BALANCE, "--trials", "2")["what"]


def test_a_killed_search_leaves_no_record_of_the_one_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    monkeypatch.setattr(Growing, "interrupted", 3)
    learn(*BALANCE, "--quiet", "--trials", "4", status=130)
    assert sorted(content()) == ["out/state.npz"]


def test_a_search_whose_policy_fails_when_judged_did_not_succeed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = Growing.run

    def boasting(self: Growing, problem: Problem, **how: Any) -> Learned:
        return replace(run(self, problem, **how), succeeded=True, why="")

    monkeypatch.setattr(Growing, "run", boasting)
    learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    assert record()["why"] == "0 of 10 runs reach every goal"


def test_tasks_and_searches_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "tasks", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["tasks"]}
    assert rows["swing-up"]["search"] == "ddp"
    assert "cartpole" in rows["balance"]["robots"]
    assert rows["balance"]["what"].startswith("Keep a chain upright")
    assert main(["list", "tasks"]) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80
