"""Recordings with something hidden, and a diagnosis written by hand."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.corrected import split
from morph.physics.effect import Effect
from morph.physics.store import effects_text
from morph.record.recording import Recording
from morph.sim.simulator import Simulator

FRICTION = 0.2
"""N m, of the hidden friction."""


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    """One link on one hinge with a motor."""
    return load("pendulum")


@pytest.fixture(scope="session")
def swung(pendulum: Robot) -> Callable[..., Recording]:
    """Makes a recording of the pendulum under effects, driven to and fro."""

    def made(*effects: Effect, name: str = "run", seconds: float = 6.0) -> Recording:
        def command(t: np.ndarray) -> np.ndarray:
            return 1.5 * np.sin(2 * np.pi * 0.3 * t) + 1.0 * np.sin(2 * np.pi * 0.9 * t)

        return Simulator(pendulum, effects).run(
            seconds=seconds, start={"hinge": 0.3}, command={"hinge": command}, name=name
        )

    return made


@pytest.fixture
def diagnosis_of(tmp_path: Path) -> Callable[..., Path]:
    """Writes a diagnosis that finds effects, as `morph diagnose` lays it out."""

    def written(robot: Robot, *effects: Effect, **changes: Any) -> Path:
        folder = tmp_path / "diagnosis"
        folder.mkdir(exist_ok=True)
        beside, mjcf = split(spec_of(robot), effects)
        (folder / "corrected.xml").write_text(mjcf)
        (folder / "corrected.toml").write_text(effects_text(beside))
        content = {
            "schema": "morph.diagnosis/1",
            "robot": robot.name,
            "verdict": "mismatch",
            "findings": [finding(effect) for effect in effects],
            "located": {"channels": [], "times": [], "states": ""},
            "fit": {
                "horizon_s": 1.0,
                "train": ["train"],
                "held_out": ["run"],
                "split": "as named",
            },
            "provenance": {
                "robot_sha256": robot.sha256,
                "recordings_sha256": {},
                "command": "morph diagnose pendulum runs/train.npz --out DIR",
            },
        }
        (folder / "diagnosis.json").write_text(json.dumps(content | changes))
        return folder

    return written


def finding(effect: Effect) -> dict[str, Any]:
    """Return an effect as diagnosis.json tells it."""
    return {
        "effect": effect.name,
        "where": {"kind": effect.kind, "name": effect.where},
        "probability": 0.97,
        "parameters": {
            each.name: {
                "value": getattr(effect, each.name),
                "low90": getattr(effect, each.name),
                "high90": getattr(effect, each.name),
                "unit": each.unit,
            }
            for each in effect.parameters()
        },
        "statement": effect.statement(),
    }
