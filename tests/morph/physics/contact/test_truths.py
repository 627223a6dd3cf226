"""Contacts against what mechanics says in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.restitution import Restitution
from morph.physics.contact.spring import ratio_of
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.world.ground import Ground
from morph.physics.world.ground_slope import GroundSlope
from morph.record.recording import Recording
from morph.sim.simulator import Simulator

FLOOR = "any+floor"
G = 9.81
STEP = 0.002


def friction(mu: float, pyramid: float = 0.0) -> tuple[Effect, ...]:
    return (Ground(), ContactFriction(contact=FLOOR, mu=mu, pyramid=pyramid))


def sliding(block: Robot, effects: tuple[Effect, ...], x: float, y: float) -> Recording:
    speed = {"block.linear_velocity.x": x, "block.linear_velocity.y": y}
    return Simulator(block, effects, step=STEP).run(seconds=1.2, speed=speed)


@pytest.mark.parametrize("pyramid", [0.0, 1.0])
@pytest.mark.parametrize("mu", [0.2, 0.8])
def test_a_block_slides_v2_over_2_mu_g(block: Robot, mu: float, pyramid: float) -> None:
    went = sliding(block, friction(mu, pyramid), 1.0, 0.0)["block.position.x"][-1]
    # A step moves by the speed at its end: v h / 2 too short in all, mu g h / v of the way.
    # At the end friction fades below v_c = mu g (1 - d) / (d b), with MuJoCo's d = 0.9 and
    # b = 2 / (0.95 * 0.02) = 105 / s: v_c / b = 0.08 mm too far at mu = 0.8, 0.2 %.
    ratio = went / (1.0 / (2.0 * mu * G))
    assert 1.0 - mu * G * STEP <= ratio <= 1.002


@pytest.mark.parametrize(("pyramid", "longer"), [(0.0, 1.0), (1.0, math.sqrt(2.0))])
def test_along_a_diagonal_the_cone_holds_and_the_pyramid_is_weaker(
    block: Robot, pyramid: float, longer: float
) -> None:
    # |f_x| + |f_y| <= mu f_n leaves mu / sqrt(2) along the diagonal. Tolerances as above,
    # and where friction is weaker the loss of v h / 2 is a smaller share.
    run = sliding(block, friction(0.5, pyramid), math.sqrt(0.5), math.sqrt(0.5))
    went = math.hypot(run["block.position.x"][-1], run["block.position.y"][-1])
    ratio = went / (longer / (2.0 * 0.5 * G))
    assert 1.0 - 0.5 * G * STEP <= ratio <= 1.002


@pytest.mark.parametrize("pyramid", [0.0, 1.0])
@pytest.mark.parametrize("share", [0.9, 0.97, 1.03, 1.1])
def test_a_block_sticks_on_a_slope_exactly_if_its_tangent_is_below_mu(
    block: Robot, pyramid: float, share: float
) -> None:
    mu, seconds = 0.4, 2.0
    slope = math.atan(mu * share)
    start = {
        "block.position.x": 0.05 * math.sin(slope),
        "block.position.z": 0.05 * math.cos(slope),
        "block.orientation.w": math.cos(0.5 * slope),
        "block.orientation.y": math.sin(0.5 * slope),
    }
    effects = (*friction(mu, pyramid), GroundSlope(pitch=slope))
    run = Simulator(block, effects, step=STEP).run(seconds=seconds, start=start)
    moved = math.hypot(
        *(run[f"block.position.{axis}"][-1] - start[f"block.position.{axis}"] for axis in "xz")
    )
    free = 0.5 * max(G * (math.sin(slope) - mu * math.cos(slope)), 0.0) * seconds**2
    # MuJoCo's friction yields at g sin(slope) (1 - d) / (d b), d = 0.9 and b = 105 / s: at
    # most 4 mm/s, however long. At 3 % below and above mu that is 8 mm against 218 mm.
    creep = G * math.sin(slope) * (0.1 / 0.9) / 105.0
    assert abs(moved - free) <= creep * seconds


def bounced(ball: Robot, effects: tuple[Effect, ...], height: float) -> Array:
    """Return the heights of a ball dropped from a height, from the drop to the second landing."""
    run = Simulator(ball, (Ground(), *effects), step=STEP).run(
        seconds=3.0 * math.sqrt(2.0 * height / G),
        start={"ball.position.z": 0.05 + height, "ball.orientation.w": 1.0},
    )
    return np.asarray(run["ball.position.z"] - 0.05)


@pytest.mark.parametrize("e", [0.3, 0.5, 0.8, 0.95, 1.0])
def test_a_ball_rises_to_e_squared_of_where_it_fell_from(ball: Robot, e: float) -> None:
    height = bounced(ball, (Restitution(contact=FLOOR, e=e),), 0.5)
    landed = int(np.argmin(height))
    measured = math.sqrt(height[landed:].max() / 0.5)
    # The contact is seen up to one step late, in the middle half a step: a damper b takes
    # b h / 2 of the speed in that time, and b h = 2 z pi / 10 with ten steps a bounce; the
    # spring alone leaves (w h)^2 / 24 = 0.4 % of the speed to where in a step it began.
    assert abs(measured - e) <= e * (ratio_of(e) * math.pi / 10.0 + 0.004)


@pytest.mark.parametrize("e", [0.0, 0.05])
def test_a_ball_that_does_not_bounce_stays_down(ball: Robot, e: float) -> None:
    height = bounced(ball, (Restitution(contact=FLOOR, e=e),), 0.5)
    # e = 0.05 is e^2 = 0.25 % of the height, 1.3 mm; one step at the landing's 3.1 m/s is
    # 6 mm, so all that can be told is that it does not come up by more than that.
    assert height[int(np.argmin(height)) :].max() < 0.006


@pytest.mark.parametrize("mass", [0.2, 1.0])
def test_a_stiff_contact_is_as_deep_as_a_spring_of_that_stiffness(
    mass: float, made: Callable[..., Robot]
) -> None:
    thing = made(
        f'<body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05" mass="{mass}"/></body>'
    )
    stiffness, height = 2500.0 * mass, 0.05
    softness = ContactSoftness(contact=FLOOR, stiffness=stiffness, damping=0.0)
    depth = -bounced(thing, (softness,), height).min()
    # Energy: m v^2 / 2 + (1 - d) m g x = K x^2 / 2, with v^2 = 2 g h and d = 0.5, the share of
    # the weight that the contact bears at once. Near the bottom, half a step of 2 ms aside,
    # x falls short by x (w h / 2)^2 / 2 = 0.03 mm; the landing is seen up to a step late, which
    # adds up to v h (w h) / 2 = 0.1 mm.
    rate = stiffness / mass
    lean = 0.5 * G / rate
    assert depth == pytest.approx(lean + math.sqrt(lean**2 + 2.0 * G * height / rate), abs=0.2e-3)


def test_a_rolling_ball_keeps_five_sevenths_of_its_speed(ball: Robot) -> None:
    mu = 0.1
    run = Simulator(ball, friction(mu), step=STEP).run(
        seconds=0.6, speed={"ball.linear_velocity.x": 1.0}
    )
    speed, spin = run["ball.linear_velocity.x"], run["ball.angular_velocity.y"]
    # It rolls from 2 v / (7 mu g) = 0.291 s on. The contact acts at half the depth at rest,
    # (1 - d) g T^2 / 2 = 0.1 mm of the lever of 50 mm: 0.2 % of it, and the speed is
    # v / (1 + 0.4 (r / r')^2), 0.0008 less.
    assert speed[-1] == pytest.approx(5.0 / 7.0, abs=0.002)
    assert spin[-1] * 0.05 == pytest.approx(speed[-1], rel=0.004)
    # Before, friction is mu m g whatever the speed; MuJoCo lays a step's change at its end.
    half = round(0.145 / STEP)
    assert speed[half] == pytest.approx(1.0 - mu * G * 0.145, abs=mu * G * STEP)


def test_a_stack_stays_where_it_was_put(made: Callable[..., Robot]) -> None:
    heights = [0.05, 0.15, 0.25, 0.35]
    stack = made(
        "".join(
            f'<body name="box{n}" pos="{0.01 * n} 0 {z}"><freejoint/>'
            '<geom type="box" size="0.05 0.05 0.05" mass="1"/></body>'
            for n, z in enumerate(heights)
        )
    )
    run = Simulator(stack, friction(0.5), step=STEP).run(seconds=3.0)
    for n, z in enumerate(heights):
        moved = [run[f"box{n}.position.{axis}"][-1] for axis in "xyz"] - np.array([0.01 * n, 0, z])
        # Each of n + 1 contacts below bears at most 4 kg: (1 - d) g T^2 times 4 is 0.8 mm
        # with MuJoCo's d = 0.95 and T = 0.02 s; leaning, it gives as much again sideways.
        assert np.abs(moved).max() < 0.8e-3 * (n + 1)
        still = [run[f"box{n}.linear_velocity.{axis}"][-1] for axis in "xyz"]
        # Pressed 0.8 mm more at one edge than at the other, 0.1 m off, a face leans 0.008 rad:
        # each below creeps at g 0.008 (1 - d) / (d b) = 0.08 mm/s, as on the slope above.
        assert np.abs(still).max() < 0.083e-3 * (n + 1)


def test_twisting_friction_slows_a_top_whose_sliding_friction_is_as_described(ball: Robot) -> None:
    lever, spin, at = 0.002, 50.0, 30
    effects = (Ground(), ContactFriction(contact=FLOOR, torsional=lever))
    run = Simulator(ball, effects, step=STEP).run(
        seconds=0.4, speed={"ball.angular_velocity.z": spin}
    )
    turning, sinking = run["ball.angular_velocity.z"], run["ball.linear_velocity.z"]
    # The floor's impulse until then is m (g t + v); times the lever, over 2/5 m r^2. A step's
    # change is laid at its end: 2 / m * 9.81 m/s2 * 2 ms = 0.04 rad/s.
    slowed = lever / (0.4 * 0.05**2) * (G * at * STEP + sinking[at])
    # It yields up to (1 - d) / (d b) mu^2 g / lever = 5 rad/s, with mu = 1, and is whole above.
    assert slowed > 1.0
    assert turning[at] == pytest.approx(spin - slowed, abs=0.04)
    plain = Simulator(ball, (Ground(),), step=STEP).run(
        seconds=0.4, speed={"ball.angular_velocity.z": spin}
    )
    assert plain["ball.angular_velocity.z"][-1] == pytest.approx(spin, abs=1e-9)


def test_a_soft_floor_under_water_is_as_soft_as_it_is_told(ball: Robot) -> None:
    # At rest the added mass says nothing: (1 - d) m g / K, d = 0.5. With 3 kg to
    # stop the swing about it dies at C / 2 m = 10 / s: e^-60 is left after 6 s. By 1 kg it would
    # be a third as deep; the rest is round-off of a depth of 10 mm in a height of 50.
    soft = ContactSoftness(contact=FLOOR, stiffness=500.0, damping=60.0)
    water = AddedMass(body="ball", x=2.0, y=2.0, z=2.0)
    for effects in ((Ground(), soft, water), (water, soft, Ground())):
        run = Simulator(ball, effects, step=STEP, integrator="implicitfast").run(seconds=6.0)
        assert 0.05 - run["ball.position.z"][-1] == pytest.approx(0.5 * G / 500.0, rel=1e-4)
