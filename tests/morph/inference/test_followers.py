"""A crank and a rod that follows it, moved by their own equation, without MuJoCo or morph."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.diagnose import diagnose
from morph.inference.observed import observed
from morph.inference.ties import carried
from morph.model.derived_channels import with_followers
from morph.model.episodes import episode
from morph.physics.dynamics import accelerations, jacobians
from morph.record.recording import Channel, Recording

RATIO, OFFSET = -0.8, 0.3
ARM, ROD, GRAVITY, LEVER = (0.8, 0.02), (0.5, 0.008), 9.81, 0.12
"""Mass, kg, and inertia about the joint, kg m2, of each; and how far from it they weigh, m."""
STEP, FINE = 0.005, 20
LINKS = f"""
<mujoco model="press"><worldbody>
 <body><joint name="crank" axis="0 1 0"/><inertial pos="0 0 {-LEVER}" mass="{ARM[0]}"
  diaginertia="0.01 {ARM[1] - ARM[0] * LEVER**2} 0.01"/></body>
 <body pos="1 0 0"><joint name="rod" axis="0 1 0"/><inertial pos="0 0 {-LEVER}" mass="{ROD[0]}"
  diaginertia="0.005 {ROD[1] - ROD[0] * LEVER**2} 0.005"/></body></worldbody>
 <equality><joint joint1="rod" joint2="crank" polycoef="{OFFSET} {RATIO} 0 0 0"/></equality>
 <actuator><motor name="motor" joint="crank" ctrlrange="-4 4"/></actuator></mujoco>
"""


def slope(angle: Array, effort: Array) -> Array:
    """Return the crank's acceleration without friction, rad/s2, by Lagrange's equation."""
    weigh = GRAVITY * LEVER
    load = weigh * (ARM[0] * np.sin(angle) + RATIO * ROD[0] * np.sin(RATIO * angle + OFFSET))
    return np.asarray((effort - load) / (ARM[1] + RATIO**2 * ROD[1]))


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("press") / "press.xml"
    path.write_text(LINKS)
    return load(path)


def recorded(number: int, coulomb: float) -> Recording:
    """Return 8 s of the crank's encoder and its motor, with Coulomb friction at its joint, N m."""
    rng, time = np.random.default_rng(number), STEP * np.arange(1600)
    effort = sum(
        rng.uniform(0.2, 0.5) * np.sin(2.0 * np.pi * hertz * time + rng.uniform(0.0, 6.0))
        for hertz in rng.uniform(0.2, 2.0, 4)
    )
    angle = rate = 0.0
    read, step = [], STEP / FINE
    most = step * coulomb / (ARM[1] + RATIO**2 * ROD[1])
    for now in effort:
        read.append(angle)
        for _ in range(FINE):
            rate += step * float(slope(angle, now))
            rate = np.sign(rate) * max(abs(rate) - most, 0.0)
            angle += step * rate
    channels = {
        "crank.position": Channel(time=time, value=read + 2e-4 * rng.normal(size=len(time))),
        "motor.command": Channel(time=time, value=effort, hold=True),
    }
    return Recording(name=f"run_{number}", channels=channels)


def test_what_follows_moves_as_lagrange_says(robot: Robot) -> None:
    model, rng = spec_of(robot).compile(), np.random.default_rng(0)
    crank, rod = (model.joint(name).dofadr[0] for name in ("crank", "rod"))
    angle, effort = rng.uniform(-2.0, 2.0, (2, 9))
    state = np.zeros((2, 9, 2))
    state[0, :, crank], state[0, :, rod] = angle, RATIO * angle + OFFSET
    found = accelerations(model, *state, effort[:, None])
    # Rounding of accelerations near 100 per s2.
    assert np.allclose(found[:, crank], slope(angle, effort), rtol=1e-12, atol=1e-10)
    assert np.allclose(found[:, rod], RATIO * found[:, crank], rtol=1e-12, atol=1e-10)
    derivatives = jacobians(model, *state, effort[:, None])
    mobility = derivatives[:, :, 4:]
    both = np.array([1.0, RATIO])[[crank, rod]]
    along = np.outer(both, both) / (ARM[1] + RATIO**2 * ROD[1])
    assert np.allclose(mobility, along, rtol=1e-12, atol=1e-10)
    # A move that keeps them together, as the difference of the exact acceleration.
    moved = derivatives[:, :, :2] @ both
    nudge = 1e-5
    exact = (slope(angle + nudge, effort) - slope(angle - nudge, effort)) / (2.0 * nudge)
    assert np.allclose(moved[:, crank], exact, rtol=1e-6, atol=1e-6)


def test_followers_read_what_their_leaders_make_of_them(robot: Robot) -> None:
    alone = recorded(0, 0.0)
    whole = with_followers(alone, robot)
    turned = alone["crank.position"]
    assert np.array_equal(whole["rod.position"], RATIO * turned + OFFSET)
    assert whole.notes == alone.notes
    wrong = Channel(time=alone.channels["crank.position"].time, value=0.0 * turned)
    own = replace(alone, channels={**alone.channels, "rod.position": wrong})
    again = with_followers(own, robot)
    assert np.array_equal(again["rod.position"], whole["rod.position"])
    assert "the joint follows crank" in again.notes[-1].what


def test_a_leader_bears_what_its_follower_needs(robot: Robot) -> None:
    # By virtual work: a motion of 1 rad at the crank is one of `RATIO` at the rod.
    model = spec_of(robot).compile()
    crank, rod = (int(model.joint(name).dofadr[0]) for name in ("crank", "rod"))
    force = np.random.default_rng(0).normal(size=(5, model.nv))
    borne = carried(model, force)
    assert borne[:, crank] == pytest.approx(force[:, crank] + RATIO * force[:, rod], rel=1e-12)
    assert RATIO * borne[:, rod] == pytest.approx(borne[:, crank], rel=1e-12)


def test_a_follower_tells_nothing_that_its_leader_has_not_told(robot: Robot) -> None:
    read = episode(with_followers(recorded(0, 0.0), robot), robot, STEP)
    found = observed(spec_of(robot, timestep=STEP).compile(), robot, read)
    crank, rod = (read.measurement.channels.index(f"{name}.position") for name in ("crank", "rod"))
    assert found.run.valid[:, crank].sum() == len(read.time)
    assert not found.run.valid[:, rod].any()
    turned = found.about.position
    assert np.array_equal(turned[:, rod], RATIO * turned[:, crank] + OFFSET)


@pytest.mark.parametrize("coulomb", [0.0, 0.12])
def test_a_law_at_a_leader_is_named(robot: Robot, coulomb: float) -> None:
    found = diagnose(robot, [recorded(number, coulomb) for number in range(4)], horizon=1.0)
    names = [f"{each.effect.name}@{each.effect.where}" for each in found.findings]
    assert names == (["coulomb_friction@crank"] if coulomb else [])
    if coulomb:
        # Its interval, and 5 % for what the readings' noise and 5 ms between them leave.
        assert found.findings[0].parameters["c"].value == pytest.approx(coulomb, rel=0.05)
    # What follows has no readings that something could be left of.
    assert set(found.unexplained.channels) == {"crank.position"}
    errors = found.held_out_rmse["corrected"]
    # Starts are unsure by 0.2 mrad and, over a tenth of a second, by 2 mrad/s: a second on, 2 mrad.
    assert errors["crank.position"] < 0.002
    # What follows has no readings of its own.
    assert list(errors) == ["crank.position"]
