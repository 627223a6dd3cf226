"""The page on what a simulator misses says what holds."""

from __future__ import annotations

import re
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.search.target import Simulated
from morph.task.swing_up import swing_up

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "residual.md").read_text(encoding="utf-8")


def test_its_block_learns_from_runs_and_foresees_one(monkeypatch: pytest.MonkeyPatch) -> None:
    # What is fitted is shown elsewhere; here fewer steps will do, and a run of two blocks.
    monkeypatch.setattr(import_module("morph.model.missing_force.fit"), "ROUNDS", 1)
    monkeypatch.setattr(import_module("morph.model.missing_force.fit"), "STEPS", 2)
    task = replace(swing_up(load("cartpole")), horizon=2.1)
    rng = np.random.default_rng(100)
    target = Simulated(
        task=task, simulator=task.simulator((CoulombFriction(joint="slide", c=0.8),))
    )
    runs = [target.trial(np.repeat(rng.uniform(-8, 8, (14, 1)), 3, axis=0), rng).run]
    known: dict[str, object] = {
        "runs": runs,
        "noise": np.full(4, 0.01),
        "start": runs[0].state[:1],
        "command": runs[0].command[None, :20],
        "rng": rng,
    }
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    assert TEXT.count("```python") == 1
    exec(compile(code, "docs/residual.md", "exec"), known)
    model = known["model"]
    seen = model.foresee(known["start"], known["command"], rng)  # type: ignore[attr-defined]
    # (runs, periods + 1, n), as the page says.
    assert seen.mean.shape == seen.variance.shape == (1, 21, 4)
    assert seen.states.shape[1:] == (1, 21, 4)
    assert np.isfinite(seen.mean).all()
    assert set(model.factors) >= {"length:pole"}  # type: ignore[attr-defined]


def test_every_function_that_it_names_is_there() -> None:
    named = re.findall(r"`(morph(?:\.\w+)+)`", TEXT)
    assert named
    for each in named:
        module, _, name = each.rpartition(".")
        assert callable(getattr(import_module(module), name)), each
