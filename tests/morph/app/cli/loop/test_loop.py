from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.cli.concealed_target import LEAST, MOST, Concealed, changes, drawn
from morph.app.cli.main import main
from morph.body.load import load
from morph.errors import TransferError
from morph.policy.pattern import pattern
from morph.policy.store import load_policy
from morph.task.tasks import task

LONG = ("--change", "length:pole=1.2")


def test_a_loop_that_succeeds_leaves_a_policy_a_model_a_record_and_a_report(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.loop(*LONG)
    told = capsys.readouterr()
    assert told.out.startswith("cartpole does balance on the target in the second trial\n")
    assert "  pole is 1.20 times as long (1.19 to 1.21)\n" in told.out
    assert re.search(r"pole is 1.2 times as long, found as 1.20 \(1.19 to 1.21\): found", told.out)
    assert "trial 1: the source's policy: loss" in told.err
    assert (
        "what differs from the description: pole is 1.20 times as long (1.19 to 1.21)" in told.err
    )
    assert {path.name for path in Path("out").iterdir()} == {
        ".morph.files",
        *("policy", "transfer.json", "report.html", "corrected.xml", "corrected.toml"),
        *("trials", "loop.json"),
    }
    said = bench.record()
    (hop,) = said["hops"]
    assert said["chain"] == ["cartpole", hop["target"]]
    assert hop["succeeded"]
    assert [trial["origin"] for trial in hop["trials"]] == ["source", "searched again"]
    assert [trial["success"] for trial in hop["trials"]] == [False, True]
    assert hop["guard"] == {"verdict": "safe", "probability": 1.0}
    assert hop["gate"] == {"verdict": "not good", "probability": 0.01}
    # Two runs of 3 s, with a command each 0.02 s.
    periods = 150
    assert (hop["samples"], said["samples_total"]) == (2 * periods, 2 * periods)


def test_scores_are_0_for_holding_still_and_1_for_the_oracle(bench: Any) -> None:
    bench.loop(*LONG, "--quiet")
    score = bench.record()["hops"][0]["score"]
    assert (score["hold_still"], score["oracle"]) == (0.0, 1.0)
    success = bench.record()["hops"][0]["success"]
    # The weak policy never balances, and the regulator on the true pole always does.
    assert (success["zero_shot"], success["oracle"], success["scratch"]) == (0.0, 1.0, None)
    assert (score["no_source"], score["scratch"]) == (None, None)
    # Both losses lie between a regulator's few and some 11,000 of a pole that falls.
    assert 0.0 <= score["zero_shot"] < 0.9 < score["final"] <= 1.0


def test_the_policy_that_is_kept_is_the_one_that_succeeded(bench: Any) -> None:
    bench.loop(*LONG, "--quiet")
    robot = load("cartpole")
    kept, tried = (
        load_policy(Path("out") / name, robot) for name in ("policy", "trials/01/policy")
    )
    seen = np.array([[0.1, 3.0, 0.2, -0.1]])
    assert kept.act(seen, np.zeros(1)) == pytest.approx(tried.act(seen, np.zeros(1)))
    said = json.loads(Path("out/policy/policy.json").read_text())["learned"]
    assert (said["trials"], said["succeeded"]) == (2, True)


def test_the_corrected_model_has_the_longer_pole(bench: Any) -> None:
    bench.loop(*LONG, "--quiet")
    here = task("balance", load("cartpole")).simulator().model
    there = task("balance", load("out/corrected.xml")).simulator().model
    centre = [float(np.linalg.norm(each.body("pole").ipos)) for each in (here, there)]
    assert centre[1] == pytest.approx(1.2 * centre[0])


def test_json_is_the_record(capsys: pytest.CaptureFixture[str], bench: Any) -> None:
    bench.loop(*LONG, "--quiet", "--json")
    assert capsys.readouterr().out == Path("out/transfer.json").read_text()


def test_a_loop_that_does_not_succeed_says_so_everywhere(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.loop(*LONG, "--quiet", "--trials", "1", status=3)
    assert "it did not succeed: " in capsys.readouterr().out
    (hop,) = bench.record()["hops"]
    assert not hop["succeeded"]
    assert hop["why"]
    assert "marked as one that did not succeed" in Path("out/report.html").read_text()


def test_a_policy_that_promises_little_is_judged_unsafe_though_its_trial_went_well(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.knowing.promised = 0.4
    bench.loop(*LONG, "--quiet", status=3)
    assert "promises that in 40% of runs alone" in " ".join(capsys.readouterr().out.split())
    assert bench.record()["hops"][0]["guard"] == {"verdict": "unsafe", "probability": 0.4}


def test_the_seal_is_opened_at_the_end_and_not_before(
    capsys: pytest.CaptureFixture[str], bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Under a heavier cart the oracle stays the best: no plan is searched there from the policy.
    truth = Concealed(factors={"length:pole": 1.15, "weight:cart": 1.4})
    monkeypatch.setattr("morph.app.cli.target_options.drawn", lambda *_: truth)
    bench.loop("--sealed", "7")
    told = capsys.readouterr()
    assert "as heavy" not in told.err
    opened = " ".join(told.out.partition("the seal, opened:")[2].split())
    assert "found as 1.20 (1.19 to 1.21): found, outside the interval" in opened
    assert "cart is 1.4 times as heavy: not named" in opened
    sealed = bench.record()["sealed"]
    assert sealed["seed"] == 7
    assert [each["found"] for each in sealed["concealed"]] == [1.2, None]
    assert sealed["more"] == []


def test_a_seed_conceals_the_same_again_and_keeps_within_what_is_said() -> None:
    robot = load("cartpole")
    balance = task("balance", robot)
    still = pattern(robot, {}, period=balance.period)
    all_drawn = [drawn(balance, still, seed) for seed in range(100, 112)]
    assert drawn(balance, still, 100) == all_drawn[0]
    assert {len(each.factors) + len(each.effects) for each in all_drawn} == {1, 2}
    sizes = [abs(np.log(factor)) for each in all_drawn for factor in each.factors.values()]
    # Factors are rounded to three figures, half a percent.
    assert min(sizes) > np.log(LEAST) - 0.005
    assert max(sizes) < np.log(MOST) + 0.005
    effects = [effect for each in all_drawn for effect in each.effects]
    assert {effect.kind for effect in effects} <= {"joint", "actuator"}
    # Though the policy holds still, what is concealed is felt: a friction of 5 % of what moves a
    # joint at least, where 10 N move a slide of some kilograms.
    strengths = [abs(getattr(each, each.strengths[0])) for each in effects]
    assert min(strengths) > 1e-4


def test_changes_are_read_or_refused() -> None:
    assert changes(["length:pole=2", "gravity:world=0.5"]) == {
        "length:pole": 2.0,
        "gravity:world": 0.5,
    }
    with pytest.raises(TransferError, match=r"length:pole is given twice"):
        changes(["length:pole=2", "length:pole=3"])


def test_without_a_policy_one_is_learned_first_and_said(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    assert main(bench.words(*LONG)) == 0
    told = capsys.readouterr()
    assert told.err.startswith("no policy was given: learning balance of cartpole by lqr\n")
    assert "the source's policy was learned first, by lqr" in bench.record()["notes"]
    assert Path("out/source/policy.json").is_file()
