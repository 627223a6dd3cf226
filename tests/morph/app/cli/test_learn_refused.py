from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.search.cmaes import CmaEs
from morph.search.ddp import Plan
from morph.search.pddp import Pddp
from morph.search.pilco import Pilco
from morph.search.search import Search

BALANCE = ("balance", "--robot", "cartpole", "--search", "growing", "--out", "out")


@pytest.mark.parametrize(
    ("others", "what"),
    [
        (("--seed", "1"), "another seed"),
        (("--search", "from-trials"), "another search"),
        (("--effect", "viscous_friction@hinge:b=0.1"), "another task"),
    ],
)
def test_a_folder_is_kept_for_its_own_search(
    others: tuple[str, ...], what: str, capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    capsys.readouterr()
    found = bench.refused(*BALANCE, "--trials", "1", *others)
    assert what in found["what"]
    assert "--fresh" in found["fix"]
    bench.learn(*BALANCE, "--quiet", "--trials", "1", "--fresh", *others, status=3)
    assert [each["number"] for each in bench.record()["trials"]] == [1]


@pytest.mark.parametrize(
    ("changed", "what", "fix"),
    [
        ({0: "balanse"}, "there is no task 'balanse'", "'balance'"),
        ({2: "cartpol"}, "no robot is called", "morph list robots"),
        ({4: "growin"}, "there is no search 'growin'", "'growing'"),
        ({0: "walk"}, "task walk of cartpole", "give a body"),
        ({4: "refusing"}, "it needs gradients", "cmaes"),
        ({6: " "}, "no folder is named", "name a new"),
    ],
)
def test_what_cannot_be_done_is_one_message(
    changed: dict[int, str], what: str, fix: str, bench: Any
) -> None:
    words = [changed.get(at, word) for at, word in enumerate(BALANCE)]
    found = bench.refused(*words)
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
    more: tuple[str, ...], what: str, bench: Any
) -> None:
    found = bench.refused(*BALANCE, *more)
    assert what in f"{found['where']}: {found['what']}"


def test_a_body_without_actuators_is_refused(bench: Any) -> None:
    Path("bare.xml").write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/></body>'
        "</worldbody></mujoco>"
    )
    found = bench.refused(*[{"cartpole": "bare.xml"}.get(word, word) for word in BALANCE])
    assert found["what"] == "the body has no actuator"


def test_goals_that_a_body_cannot_reach_are_refused(bench: Any) -> None:
    Path("held.xml").write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0" limited="true" '
        'range="28.65 57.3"/><geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/>'
        '</body></worldbody><actuator><motor name="motor" joint="hinge"/></actuator></mujoco>'
    )
    found = bench.refused(*[{"cartpole": "held.xml"}.get(word, word) for word in BALANCE])
    # It hangs at 0 and stands at pi; 28.65 degrees are 0.5 rad.
    assert "would have to stand at 3.14 rad, and its range is 0.5 to 1" in found["what"]


def test_a_cost_that_is_no_number_is_one_message(
    monkeypatch: pytest.MonkeyPatch, bench: Any
) -> None:
    monkeypatch.setattr(
        "morph.task.term.Term.error",
        lambda self, moved: np.full((*moved.position.shape[:-1], 1), np.nan),
    )
    assert "is no number in" in bench.refused(*BALANCE, "--quiet")["what"]


def test_a_place_that_is_not_ours_is_refused(bench: Any) -> None:
    Path("file").write_text("mine")
    Path("folder").mkdir()
    Path("folder/mine.txt").write_text("mine")
    assert "this is a file" in bench.refused(*BALANCE[:-1], "file")["what"]
    assert "not empty" in bench.refused(*BALANCE[:-1], "folder")["what"]
    assert "nothing can be written" in bench.refused(*BALANCE[:-1], "/proc/morph/out")["what"]


@pytest.mark.parametrize("name", ["state.npz", "record.json"])
def test_a_spoilt_file_is_refused_and_begun_anew_when_asked(
    name: str, capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    Path("out", name).write_bytes(b"PK\x03\x04 no more")
    capsys.readouterr()
    found = bench.refused(*BALANCE, "--trials", "1")
    assert name in found["where"]
    assert "--fresh" in found["fix"]
    bench.learn(*BALANCE, "--quiet", "--trials", "1", "--fresh", status=3)
    assert bench.record()["why"]


def test_a_finished_search_without_its_state_is_not_begun_over_it(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    Path("out/state.npz").unlink()
    capsys.readouterr()
    assert "without its state" in bench.refused(*BALANCE, "--trials", "2")["what"]


SEARCHED: tuple[tuple[str, str, Search], ...] = (
    ("reach", "so101", CmaEs(population=6, runs=1, checks=2)),
    ("swing-up", "pendulum", Plan(rows=16, keep=1, most=1, runs=2)),
    ("swing-up", "pendulum", Pilco(units=5, steps=2, short=1, starts=1)),
    ("swing-up", "pendulum", Pddp(steps=1, samples=20, starts=1, widths=(1.0,))),
)


@pytest.mark.parametrize(("task", "robot", "search"), SEARCHED, ids=lambda each: str(each)[:5])
def test_a_state_of_spoilt_arrays_is_one_message(
    task: str,
    robot: str,
    search: Search,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    bench: Any,
) -> None:
    monkeypatch.setattr("morph.app.cli.learn._search", lambda *_: search)
    asked = (task, "--robot", robot, "--out", "out", "--quiet")
    main(["learn", *asked, "--trials", "1"])
    capsys.readouterr()
    with np.load("out/state.npz") as file:
        kept = {name: np.array(file[name]) for name in file.files}
    own = {name: value for name, value in kept.items() if name.startswith("state.")}
    for spoilt in (
        {name: value for name, value in own.items() if name == min(own)},
        {name: np.full(value.shape, "text") for name, value in own.items()},
        {name: value[..., None, None] for name, value in own.items()},
    ):
        others = {name: value for name, value in kept.items() if name not in own}
        np.savez("out/state.npz", **others, **spoilt)
        found = bench.refused(*asked, "--trials", "2")
        assert found["where"] == "out/state.npz"
        assert "--fresh" in found["fix"]


@pytest.mark.parametrize("name", ["report.html", "strip.jpg", "record.json", "policy/policy.json"])
def test_a_user_s_file_under_the_name_of_a_result_is_never_replaced(
    name: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    bench: Any,
    growing: Any,
) -> None:
    # Interrupted after its second trial, a search leaves its state alone.
    monkeypatch.setattr(growing, "interrupted", 2)
    bench.learn(*BALANCE, "--quiet", status=130)
    monkeypatch.setattr(growing, "interrupted", 0)
    assert {each.name for each in Path("out").iterdir()} == {"state.npz", ".morph.files"}
    mine = Path("out", name)
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("mine")
    capsys.readouterr()
    for options in ((), ("--fresh",)):
        refusal = bench.refused(*BALANCE, "--trials", "1", *options)
        assert refusal["where"] == f"out/{name}"
        assert "move it elsewhere" in refusal["fix"]
        assert mine.read_text() == "mine"


def test_results_whose_writing_was_interrupted_are_replaced(
    monkeypatch: pytest.MonkeyPatch, bench: Any
) -> None:
    def interrupt(outcome: object) -> str:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("morph.app.report.learn.files.record_text", interrupt)
        bench.learn(*BALANCE, "--quiet", "--trials", "1", status=130)
    assert Path("out/report.html").is_file()
    assert not Path("out/record.json").exists()
    bench.learn(*BALANCE, "--quiet", "--trials", "1", "--fresh", status=3)
    assert bench.record()["trials"]


def test_a_policy_that_is_a_file_is_refused_before_the_search(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.learn(*BALANCE, "--quiet", "--trials", "1", status=3)
    for each in sorted(Path("out/policy").iterdir()):
        each.unlink()
    Path("out/policy").rmdir()
    Path("out/policy").write_text("mine")
    capsys.readouterr()
    assert bench.refused(*BALANCE, "--trials", "2", "--fresh")["where"] == "out/policy"
