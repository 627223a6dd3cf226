"""Made-up diagnoses of a double pendulum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.model.diagnosis import Diagnosis, Located, Stretch, Trace
from morph.model.finding import Estimate, Finding, Rival
from morph.physics import CoulombFriction
from morph.physics.actuator.actuator_delay import ActuatorDelay


def trace(episode: str, channel: str, samples: int = 5000) -> Trace:
    time = np.linspace(0.0, 10.0, samples)
    measured = np.exp(-0.2 * time) * np.cos(4.0 * time + len(channel))
    late = np.exp(-0.05 * time) * np.cos(4.3 * time + len(channel))
    models = {"nominal": late, "refitted": 0.5 * (late + measured), "corrected": 0.98 * measured}
    # Two rollouts of 5 s with a gap between them.
    time[samples // 2] = np.nan
    return Trace(
        episode=episode, channel=channel, unit="rad", time=time, measured=measured, models=models
    )


def friction(joint: str) -> Finding:
    return Finding(
        effect=CoulombFriction(joint=joint, c=0.081),
        probability=0.97,
        episodes=("run_00", "run_01"),
        parameters={"c": Estimate(value=0.081, low90=0.077, high90=0.085, unit="N m")},
        rivals=(
            Rival(effect="viscous_friction", kind="joint", where=joint, probability=0.02),
            Rival(effect="stribeck_friction", kind="joint", where=joint, probability=0.01),
        ),
        separate_by="Two constant speeds at least five times apart, and one stop and start.",
        gain=0.71,
    )


def delay() -> Finding:
    return Finding(
        effect=ActuatorDelay(actuator="elbow", T=0.014),
        probability=0.88,
        episodes=tuple(f"run_{n:02}" for n in range(12)),
        parameters={"T": Estimate(value=0.014, low90=0.011, high90=0.018, unit="s")},
        rivals=(),
        separate_by="Single large steps of the command.",
        gain=0.12,
    )


@pytest.fixture
def mismatch() -> Diagnosis:
    """Two findings, three held-out runs, plots."""
    channels = ("shoulder.position", "elbow.position")
    runs = ("run_03", "run_05", "run_06")
    rmse = {"nominal": (0.264, 0.476), "refitted": (0.17, 0.301), "corrected": (0.031, 0.052)}
    rmse["noise_floor"] = (0.0011, 0.0012)
    return Diagnosis(
        robot="double_pendulum",
        verdict="mismatch",
        findings=(friction("shoulder"), delay()),
        located=Located(
            channels={"elbow.position": 0.71, "shoulder.position": 0.29},
            times=(
                Stretch(episode="run_03", recording="run_03", start=2.1, end=2.9, share=0.2),
                Stretch(episode="run_06", recording="run_06", start=6.0, end=8.5, share=0.11),
                Stretch(episode="run_03", recording="run_03", start=8.0, end=8.4, share=0.04),
            ),
            states="largest where abs(shoulder.velocity) < 0.3 rad/s",
        ),
        probabilities={
            "none": 0.0,
            "unknown": 0.012,
            "coulomb_friction@shoulder": 0.97,
            "actuator_delay@elbow": 0.88,
        },
        horizon=1.0,
        train=("run_00", "run_01", "run_02", "run_04"),
        held_out=runs,
        split="as named",
        held_out_rmse={
            model: dict(zip(channels, values, strict=True)) for model, values in rmse.items()
        },
        improvement_low90=0.962,
        refit={
            "mass of upper": Estimate(value=1.04, low90=1.02, high90=1.06, unit="-"),
            "inertia of lower": Estimate(value=0.93, low90=0.88, high90=0.99, unit="-"),
            "gain of elbow": Estimate(value=1.0, low90=0.98, high90=1.02, unit="-"),
        },
        traces=tuple(trace(run, channel) for run in runs for channel in channels),
        data={"samples": 51234, "dropped": 12, "repaired": 3, "duplicates": ["run_07"]},
        notes=("run_02: 12 readings between 4.1 and 4.2 s were dropped: elbow.position is NaN.",),
        provenance={
            "morph": "0.1.0",
            "mujoco": "4.0.0",
            "robot_sha256": "ab" * 32,
            "recordings_sha256": dict.fromkeys(runs, "cd" * 32),
            "command": "morph diagnose double_pendulum runs --out diagnosis --seed 0",
        },
        seconds=34.2,
        seed=0,
        candidates_tried=214,
        corrected="<mujoco/>",
        corrected_effects=(ActuatorDelay(actuator="elbow", T=0.014),),
        residual={"weights": np.arange(6.0)},
    )


@pytest.fixture
def consistent(mismatch: Diagnosis) -> Diagnosis:
    """Nothing was left out, and nothing is corrected."""
    keep = ("nominal", "refitted", "noise_floor")
    return replace(
        mismatch,
        verdict="consistent",
        findings=(),
        probabilities={"none": 0.98, "unknown": 0.02},
        held_out_rmse={model: mismatch.held_out_rmse[model] for model in keep},
        refit={},
        traces=(),
        notes=(),
        corrected="",
        corrected_effects=(),
        residual={},
    )


@pytest.fixture
def unknown(consistent: Diagnosis) -> Diagnosis:
    """Something is wrong that no effect explains, and time ran out."""
    located = Located(channels={"elbow.position": 1.0}, times=(), states="")
    return replace(
        consistent,
        verdict="unknown",
        located=located,
        probabilities={"none": 0.0, "unknown": 1.0},
        horizon=None,
        stopped_short=True,
    )


@pytest.fixture
def renamed(mismatch: Diagnosis) -> Callable[[str], Diagnosis]:
    """The mismatch with one name in every place that a file can name."""

    def with_name(name: str) -> Diagnosis:
        values = mismatch.held_out_rmse
        return replace(
            mismatch,
            robot=name,
            findings=(replace(friction(name), episodes=(name,)),),
            located=replace(
                mismatch.located,
                channels={name: 1.0},
                times=(Stretch(episode=name, recording=name, start=0.0, end=1.0, share=1.0),),
                states=name,
            ),
            probabilities={name: 1.0},
            train=(name,),
            held_out=(name,),
            split=name,
            held_out_rmse={model: {name: 0.1} for model in values},
            refit={name: mismatch.refit["gain of elbow"]},
            traces=(replace(trace(name, name), unit=name),),
            data={name: [name]},
            notes=(name,),
            provenance={"command": name, name: {name: name}},
        )

    return with_name
