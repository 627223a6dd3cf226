from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from morph.app.cli.main import main
from morph.app.cli.target_options import limits
from morph.body.load import load
from morph.errors import TransferError
from morph.task.tasks import task

SERVE = shlex.join([sys.executable, "-m", "morph.policy_transfer.live.serve", "--task", "balance"])
WEAK = ("--policy", "weak")


@pytest.mark.parametrize(
    ("more", "what", "fix"),
    [
        ((), "no target is named", "--sealed"),
        (("--change", "length:pole=2", "--sealed", "1"), "2 targets are named", "one of"),
        (("--change", "length:pol=2"), "no figure 'length:pol'", "one of these"),
        (("--change", "length:pole"), "'length:pole' is no FIGURE=FACTOR", "length:pole=2"),
        (("--change", "length:pole=-1"), "is no FIGURE=FACTOR", "length:pole=2"),
        (("--effect", "coulomb_friction@slid:c=1"), "no joint 'slid'", "'slide'"),
        (("--sealed", "-1"), "-1 is no seed", "0 or more"),
        (("--sealed", "1", "--limit", "speed:slide=1"), "of live targets", "--live"),
        (("--sealed", "1", "--trials", "0"), "a loop of 0 trials", "1 or more"),
        (("--sealed", "1", "--seed", "-1"), "-1 is no seed", "0 or more"),
        (("--live", "no-such-program"), "cannot be started", "program that exists"),
        (("--live", "'open"), "cannot be taken apart", "quotes"),
        (("--live", SERVE, "--limit", "command:slid=-1..1"), "no actuator 'slid'", "'slide'"),
        (("--live", SERVE, "--limit", "speed=3"), "'speed=3' is no limit", "speed:NAME=2"),
        (("--live", f"{SERVE} --unit hinge.position=deg"), "is in deg", "rad"),
        (("--recorded", "weak"), "no recording.toml", "recording"),
    ],
)
def test_what_cannot_be_used_is_one_message_and_leaves_nothing(
    more: tuple[str, ...], what: str, fix: str, bench: Any
) -> None:
    found = bench.refused(*bench.words(*WEAK, *more))
    assert what in f"{found['where']}: {found['what']}"
    assert fix in found["fix"]


def test_a_policy_of_another_body_or_period_is_refused(bench: Any) -> None:
    words = ["loop", "swing-up", "--robot", "pendulum", *WEAK, "--sealed", "1", "--out", "out"]
    assert "it was made for 'cartpole'" in bench.refused(*words)["what"]
    words[1:4] = ["swing-up", "--robot", "cartpole"]
    # Balance commands every 0.02 s and the swing-up every 0.05 s.
    periods = [task(name, load("cartpole")).period for name in ("balance", "swing-up")]
    assert periods[0] != periods[1]
    assert "the policy commands every" in bench.refused(*words)["what"]


def test_a_body_that_floats_is_refused_before_anything_is_tried(bench: Any) -> None:
    words = ["loop", "swim", "--robot", "sea_snake", "--sealed", "1", "--out", "out"]
    assert "neither a hinge nor a slide" in bench.refused(*words)["what"]


def test_a_folder_of_something_else_is_refused(bench: Any) -> None:
    Path("out").mkdir()
    Path("out/notes.txt").write_text("mine")
    found = bench.refused(*bench.words(*WEAK, "--sealed", "1"))
    assert "holds nothing of morph loop" in found["what"]


def test_a_live_target_that_dies_in_its_first_trial_is_one_message_and_its_states_are_kept(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.loop("--live", f"{SERVE} --dies 0.4", status=2)
    told = capsys.readouterr()
    assert "it closed its output" in told.err
    assert "Traceback" not in told.err
    assert sorted(bench.content()) == ["out/recorded/trial_0001.npz"]


def test_a_live_target_is_tried_and_its_scores_are_not_made_up(bench: Any) -> None:
    bench.loop("--live", SERVE, "--limit", "command:slide=-9..9", "--trials", "1", status=3)
    (hop,) = bench.record()["hops"]
    assert set(hop["score"].values()) == {None}
    assert bench.record()["sealed"] is None
    assert Path("out/recorded/trial_0001.npz").is_file()


def test_limits_are_read_as_they_are_written() -> None:
    found = limits(["command:slide=-9..9", "position:slide=-1..1.5", "rate:slide=50", "speed:a=2"])
    assert found.command == {"slide": (-9.0, 9.0)}
    assert found.position == {"slide": (-1.0, 1.5)}
    assert (found.rate, found.speed) == ({"slide": 50.0}, {"a": 2.0})
    with pytest.raises(TransferError, match=r"is no limit"):
        limits(["command:slide=1..nan"])


def test_recordings_are_diagnosed_and_nothing_is_tried_or_learned(
    capsys: pytest.CaptureFixture[str], bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.loop("--live", SERVE, "--trials", "1", "--quiet", status=3)
    monkeypatch.setattr("morph.policy_transfer.repair.explain", explained_without_effects)
    capsys.readouterr()
    assert main(bench.words("--recorded", "out/recorded", out="said")) == 0
    told = capsys.readouterr()
    # It was served as described: the gate says that nothing is amiss, and nothing is named.
    assert "good enough here" in told.err
    assert told.out.startswith("The recordings agree with the description of cartpole\n")
    said = bench.record("said")
    (hop,) = said["hops"]
    assert (said["policy"], hop["differences"]) == (None, [])
    assert hop["gate"]["verdict"] in {"good", "cannot say"}
    assert [trial["origin"] for trial in hop["trials"]] == ["recorded"]
    assert {path.name for path in Path("said").iterdir()} == {
        ".morph.files",
        *("transfer.json", "report.html", "corrected.xml", "corrected.toml", "loop.json"),
    }
    # A loop's own folder is not for what recordings say, and its policy stays.
    found = bench.refused(*bench.words("--recorded", "out/recorded"))
    assert "another target" in found["what"]
    assert Path("out/policy/policy.json").is_file()


def explained_without_effects(*given: Any, **how: Any) -> Any:
    """Explain with figures alone; the whole library takes seconds."""
    from morph.model.latent.parameter_attribution import explain

    return explain(*given, **{**how, "candidates": ()})
