"""Runs of a wheel with dry friction, and sets of effects refitted to them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from morph.body.load import load
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist
from morph.inference.search import Prior
from morph.inference.validate import Validation
from morph.model.deadline import NEVER
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.record.recording import Channel, Recording
from tests.morph.inference.dry_disc import INERTIA, STEP, turned

SAMPLES, COULOMB, NOISE = 1000, 0.05, 2e-4
FADED = 0.5
"""rad/s: speed at which friction that is greater at rest has fallen to 1/e of what it adds."""
WHEEL = f"""
<mujoco model="wheel"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><motor name="motor" joint="axle"/></actuator></mujoco>
"""


def posed(folder: Path, fades: float) -> EffectSelection:
    """Return four runs of a wheel with dry friction, greater by `fades` at rest."""
    path = folder / "wheel.xml"
    path.write_text(WHEEL)
    robot, rng, runs = load(path), np.random.default_rng(0), []

    def driven(u: float, q: float, v: float) -> float:
        return float(u + fades * (1.0 - np.exp(-((v / FADED) ** 2))) * np.sign(v))

    for number in range(4):
        time = STEP * np.arange(SAMPLES)
        torque = 0.2 * np.cos((3.0 + number) * time) + 0.1 * np.cos(11.0 * time)
        read = turned(torque.tolist(), driven, coulomb=COULOMB + fades)
        channels = {
            "axle.position": Channel(time=time, value=read + NOISE * rng.normal(size=SAMPLES)),
            "motor.command": Channel(time=time, value=torque, hold=True),
        }
        runs.append(episode(Recording(name=f"run_{number}", channels=channels), robot, STEP))
    nominal = Hypothesis(robot=robot, step=STEP, knobs=())
    bare = EffectSelection(
        nominal=nominal, episodes=runs, known=(), validation=Validation.of(runs),
        prior=Prior(alone={}), deadline=NEVER,
    )  # fmt: skip
    return replace(bare, prior=bare.search(found(bare, nominal)).prior)


def found(task: EffectSelection, hypothesis: Hypothesis) -> Finalist:
    """Return a hypothesis refitted to the runs."""
    return task.refitted(hypothesis, hypothesis.start)
