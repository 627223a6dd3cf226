"""What a notebook shows of a robot, a recording and a diagnosis: one line each."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np

import morph
from morph.body.load import load
from morph.body.spec import spec_of
from morph.model.diagnosis import Diagnosis


def test_a_robot_is_shown_by_its_counts_and_mass() -> None:
    robot = load("humanoid")
    model: Any = spec_of(robot).compile()
    hinges = int(np.sum(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE))
    free = model.njnt - hinges
    assert repr(robot) == (
        f"Robot(humanoid: {model.nbody - 1} links, {hinges + free} joints, {model.nu} actuators, "
        f"{model.body_mass.sum():.4g} kg)"
    )


def test_a_recording_is_shown_by_its_channels_and_length() -> None:
    time = np.linspace(0.0, 2.5, 6)
    channel = morph.Channel(time=time, value=time)
    run = morph.Recording(name="run", channels={"hinge.position": channel})
    assert repr(run) == "Recording(run: 1 channels, 2.5 s)"
    assert repr(morph.Recording(name="empty", channels={})) == "Recording(empty: 0 channels)"


def test_a_diagnosis_is_shown_by_its_verdict_and_findings() -> None:
    finding = SimpleNamespace(effect=SimpleNamespace(label="payload@tip"), probability=0.75)
    found = SimpleNamespace(
        robot="arm", verdict="mismatch", findings=[finding], stopped_short=False
    )
    shown = "Diagnosis(arm: mismatch, payload@tip 0.75"
    assert Diagnosis.__repr__(found) == f"{shown})"  # type: ignore[arg-type]
    found.stopped_short = True
    assert Diagnosis.__repr__(found) == f"{shown}, stopped short)"  # type: ignore[arg-type]
