"""The study of adjusting, small."""

from __future__ import annotations

import json

import numpy as np
import pytest

from experiments import transfer_adjust
from experiments.transfer.changed import changed, target_of
from experiments.transfer_adjust import Known, main, measured, report
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.ddp import Plan
from morph.search.search import Problem


def cheap(source: SimulatedTask, *, seed: int) -> tuple[Policy, ...]:
    """Return one plan twice, of which a fifth of the command's range is left free."""
    problem = Problem(task=source.task, simulator=source.simulator)
    search = Plan(margin=0.2, rows=512, keep=2, rounds=1, runs=8)
    return (search.run(problem, seed=seed).policy,) * 2


def test_one_case_is_measured_with_its_controls(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(transfer_adjust, "sources", cheap)
    monkeypatch.setattr(transfer_adjust, "ROWS", 8)
    found = measured((("b", 11.0),), range(100, 101), controls=True)
    (row,) = found["cases"]
    assert row["ways"]["none"]["success"] == 0.0
    assert row["ways"]["adjusted"]["success"] == 1.0
    assert row["ways"]["oracle"]["share"] > 0.8
    assert row["ways"]["shuffled"]["share"] < 0.5
    assert row["ways"]["flipped"]["share"] == 0.0
    assert row["seconds"]["worst"] < 10.0
    assert json.loads(json.dumps(found)) == found
    report({"friction": found})
    assert "b x11" in capsys.readouterr().out


def test_the_oracle_knows_the_target() -> None:
    target = target_of(changed("b", 11.0))
    source = SimulatedTask(task=target.task, simulator=target.simulator)
    rng = np.random.default_rng(0)
    x, u = rng.normal(size=(10, 4)), rng.uniform(-9.0, 9.0, (10, 1))
    told, doubt = Known(target).predict(x, source.after(x, u))
    # Of what is not affine in a command, the second step leaves a few percent of a newton.
    assert told == pytest.approx(u, abs=0.1)
    assert not doubt.any()


def test_it_shows_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    assert "example:" in capsys.readouterr().out
