"""Sets of effects simulated before any is refitted: shares of strengths, and limits of servos."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist
from morph.inference.search import Explanation, Prior
from morph.inference.simulated import likeliest_limit, scaled
from morph.inference.validate import MATERIAL, Validation
from morph.model.deadline import NEVER
from morph.model.episodes import Episode, episode
from morph.model.hypothesis import Hypothesis
from morph.physics.actuator.limit import LimitEffect
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Channel, Recording

INERTIA, STIFFNESS, DAMPING, LIMIT, NOISE = 0.02, 8.0, 0.4, 0.3, 2e-4
SERVO = f"""
<mujoco model="servo"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><position name="servo" joint="axle" kp="{STIFFNESS}" kv="{DAMPING}"/></actuator>
</mujoco>
"""


def weak(seed: int) -> Recording:
    """Return 3 s of a servo that gives at most `LIMIT`, by Euler steps of 0.1 ms."""
    rng = np.random.default_rng(seed)
    goals = np.repeat(rng.uniform(-1.0, 1.0, 5), 120)
    place, speed, read = 0.0, 0.0, []
    for goal in goals:
        read.append(place + NOISE * rng.normal())
        for _ in range(50):
            torque = STIFFNESS * (goal - place) - DAMPING * speed
            speed += 1e-4 * float(np.clip(torque, -LIMIT, LIMIT)) / INERTIA
            place += 1e-4 * speed
    time = 0.005 * np.arange(len(goals))
    return Recording(
        name=f"run_{seed}",
        channels={
            "axle.position": Channel(time=time, value=np.array(read)),
            "servo.command": Channel(time=time, value=goals, hold=True),
        },
    )


@pytest.fixture(scope="module")
def servo(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("servo") / "servo.xml"
    path.write_text(SERVO)
    return load(path)


@pytest.fixture(scope="module")
def runs(servo: Robot) -> list[Episode]:
    return [episode(weak(seed), servo, 0.0025) for seed in range(4)]


@pytest.fixture(scope="module")
def task(servo: Robot, runs: list[Episode]) -> EffectSelection:
    bare = EffectSelection(
        nominal=Hypothesis(robot=servo, step=0.0025, knobs=()),
        episodes=runs,
        known=(),
        validation=Validation.of(runs),
        prior=Prior(alone={}),
        deadline=NEVER,
        by_rollouts=True,
    )
    return replace(bare, prior=bare.search(bare.refitted(bare.nominal, bare.nominal.start)).prior)


@pytest.fixture(scope="module")
def none(task: EffectSelection) -> Finalist:
    return task.refitted(task.nominal, task.nominal.start)


def test_the_limit_of_a_servo_that_cannot_follow_is_found_by_rollouts(
    task: EffectSelection, none: Finalist
) -> None:
    found = likeliest_limit(none, task.validation, none.losses.mean(), ())
    assert found is not None
    assert found[0] < none.losses.mean() - MATERIAL
    (limit,) = found[1].effects
    assert isinstance(limit, LimitEffect)
    # The greatest torque asked for is 8 N m/rad times up to 2 rad: shares of it are 0.16 N m
    # apart, and a line over speed is the constant limit's where the disc is at its fastest.
    _, high = limit.limits(np.array([0.0]))
    assert 0.1 < float(high[0]) < 0.7
    # None is proposed for a set that errs as little.
    assert likeliest_limit(none, task.validation, found[0], ()) is None
    # Beside a limit that is there none is better.
    there = TorqueSaturation(actuator="servo", limit=LIMIT)
    told = task.refitted(task.nominal.adding(there), task.nominal.adding(there).start)
    assert told.losses.mean() < 0.3 * none.losses.mean()
    beside = likeliest_limit(told, task.validation, told.losses.mean(), ())
    assert beside is None


@pytest.mark.parametrize(("force", "gain", "proposed"), [
    (20.0, 0.5, True), (5.0, 0.5, False), (20.0, -10.0, False),
])  # fmt: skip
def test_a_limit_is_proposed_where_much_force_is_missing_and_no_set_errs_less(
    task: EffectSelection, none: Finalist, monkeypatch: pytest.MonkeyPatch,
    force: float, gain: float, proposed: bool,
) -> None:  # fmt: skip
    limit = Explanation(
        effects=(TorqueSaturation(actuator="servo", limit=LIMIT),),
        gain=0.0, own=np.zeros(0), members=(), level=0,
    )  # fmt: skip
    search = task.search(none)
    sets = search.sets(1)
    monkeypatch.setattr("morph.inference.effect_selection.missing", lambda runs: force)
    monkeypatch.setattr(
        "morph.inference.effect_selection.simulated", lambda found, *given, **more: (1.0, found)
    )
    monkeypatch.setattr(
        "morph.inference.effect_selection.likeliest_limit", lambda *given: (1.0 - gain, limit)
    )
    first, _ = task.proposals(search, sets, none)
    assert (limit in first) == proposed


def test_a_share_of_an_effect_is_weaker_and_a_spring_stiffer() -> None:
    given = ViscousFriction(joint="axle", b=0.2), SeriesElasticity(joint="axle", k=30.0)
    wet, spring = scaled(given, 0.3)
    assert isinstance(wet, ViscousFriction)
    assert isinstance(spring, SeriesElasticity)
    assert (wet.b, spring.k) == pytest.approx((0.06, 100.0))
    assert scaled(given, 1.0) == given
