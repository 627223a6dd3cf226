"""Bodies put into water by their mass, a density and a scale."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import morph
from morph.body.robot import Robot
from morph.errors import EffectError, RobotError
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.water import Immersed, immersed
from morph.sim.simulator import Simulator

RADIUS = 0.1
VOLUME = 4.0 / 3.0 * math.pi * RADIUS**3


def one(held: Immersed, kind: type[Effect], body: str) -> Effect:
    (found,) = (e for e in held.effects if isinstance(e, kind) and e.body == body)  # type: ignore[attr-defined]
    return found


def ball(written: Callable[[str], Robot], mass: float) -> Robot:
    return written(
        f'<worldbody><body name="ball"><freejoint/><geom type="sphere" size="{RADIUS}" '
        f'mass="{mass!r}"/></body></worldbody>'
    )


def test_the_swimmer_floats_in_the_water_and_stays_level() -> None:
    robot = morph.load("hexapod_swimmer")
    held = immersed(robot)
    lifted = sum(e.volume * e.density for e in held.effects if isinstance(e, Buoyancy))
    # Neutral: what it displaces weighs what it weighs, as its card says, to nine decimals.
    assert lifted == pytest.approx(robot.mass, rel=1e-7)
    run = Simulator(robot, held.effects).run(seconds=10.0)
    # The centre of mass rests. The paddles, denser than water, sag by up to 0.088 m: 6 * 0.065 kg
    # of 17 raise the rest by 2 mm at most.
    assert np.abs(run["hull.position.z"]).max() < 2e-3
    # Lift passes through the weight; paddles on all sides tip nothing: 1 - (0.002 / 2)^2 / 2.
    assert run["hull.orientation.w"].min() > 1.0 - 5e-7


def test_a_ball_of_half_the_density_rises_with_half_of_g(
    written: Callable[[str], Robot],
) -> None:
    held = immersed(ball(written, 500.0 * VOLUME))
    run = Simulator(ball(written, 500.0 * VOLUME), held.effects, step=1e-3).run(seconds=0.01)
    speed = run.channel("ball.linear_velocity.z")
    # (1000 - 500) g / (500 + 1000 / 2): half of g (Lamb 1932, art. 92). Of the 20.5 N, drag takes
    # rho C/4 pi r^2 v^2 = 8.6 v^2, by 0.05 m/s 0.1 %, and a third of that on the way there.
    due = 0.5 * 9.81 * speed.time[-1]
    assert speed.value[-1] == pytest.approx(due * (1.0 - 3.5e-4), rel=5e-5)


def test_volumes_grow_as_the_cube_and_moments_as_the_fifth_power_of_the_scale() -> None:
    robot = morph.load("hexapod_swimmer")
    small, large = (immersed(robot, scale=s, wetted_as="mesh") for s in (1.0, 1.5))
    for link in ("hull", "left_front_paddle"):
        lift = [one(held, Buoyancy, link) for held in (small, large)]
        added = [one(held, AddedMass, link) for held in (small, large)]
        drag = [one(held, QuadraticDrag, link) for held in (small, large)]
        assert lift[1].volume == pytest.approx(1.5**3 * lift[0].volume, rel=1e-9)  # type: ignore[attr-defined]
        for axis, power in (("x", 3), ("z", 3), ("ry", 5), ("rz", 5), ("z_ry", 4)):
            first, second = (getattr(effect, axis) for effect in added)
            assert second == pytest.approx(1.5**power * first, rel=1e-9, abs=1e-12)
        assert drag[1].z == pytest.approx(1.5**2 * drag[0].z, rel=1e-6)  # type: ignore[attr-defined]
        assert drag[1].ry == pytest.approx(1.5**5 * drag[0].ry, rel=1e-6)  # type: ignore[attr-defined]


def test_everything_but_the_volume_grows_with_the_density() -> None:
    robot = morph.load("hexapod_swimmer")
    fresh, salt = immersed(robot), immersed(robot, density=1025.0)
    for kind, what in ((AddedMass, "z"), (QuadraticDrag, "ry"), (Buoyancy, "density")):
        first, second = (getattr(one(held, kind, "hull"), what) for held in (fresh, salt))
        assert second == pytest.approx(1.025 * first, rel=1e-12)
    assert fresh.notes == salt.notes


def test_what_floats_or_sinks_is_said_with_its_figures(written: Callable[[str], Robot]) -> None:
    (note,) = immersed(ball(written, 1.0)).notes
    assert "displaces 4.189 kg of the fluid" in note
    assert "floats" in note
    (note,) = immersed(ball(written, 10.0)).notes
    assert "sinks" in note
    assert immersed(ball(written, 1000.0 * VOLUME)).notes == ()


def test_buoyancy_follows_a_volume_that_is_given_and_the_rest_its_shapes(
    written: Callable[[str], Robot],
) -> None:
    robot = ball(written, 2.0)
    held = immersed(robot, volume=2e-3)
    assert one(held, Buoyancy, "ball").volume == pytest.approx(2e-3)  # type: ignore[attr-defined]
    assert one(held, AddedMass, "ball").x == pytest.approx(500.0 * VOLUME)  # type: ignore[attr-defined]
    assert "the shapes enclose 4.189 litres where the robot displaces 2" in held.notes[0]


@pytest.mark.parametrize("name", ["hopper", "sea_snake", "hexapod_swimmer", "swimmer_three_links"])
def test_bodies_of_the_shelf_meet_water_in_every_direction(name: str) -> None:
    robot = morph.load(name)
    held = immersed(robot, wetted_as="mesh")
    assert {e.body for e in held.effects} == {link.name for link in robot.links}  # type: ignore[attr-defined]
    for effect in held.effects:
        if isinstance(effect, AddedMass):
            assert np.linalg.eigvalsh(effect.tensor).min() > 0
        if isinstance(effect, QuadraticDrag):
            assert min(effect.x, effect.y, effect.z) > 0
    run = Simulator(robot, held.effects).run(seconds=0.2)
    assert all(np.isfinite(run[name]).all() for name in run.channels)


def test_aqua_displaces_what_it_weighs_and_its_shell_is_wrapped(real_robots: Path) -> None:
    robot = morph.load(real_robots / "aqua" / "aqua_description" / "urdf" / "aqua.urdf")
    held = immersed(robot)
    lifted = sum(e.volume for e in held.effects if isinstance(e, Buoyancy))
    # A swimmer is trimmed: 17.04 kg of robot, and its shapes hold 17.2 litres.
    assert lifted == pytest.approx(robot.mass / 1000.0, rel=0.05)
    (note,) = held.notes
    assert "link aqua_base: 22 open of its 90 pieces: wrapped watertight" in note
    assert "added mass differs by up to" in note
    shell = one(held, AddedMass, "aqua_base")
    # Published: 32.41 kg; the hull with the hips moves 58, an ellipse's plate of the shell 22.
    assert 20.0 < shell.z < 58.0  # type: ignore[attr-defined]
    # The wrap is no better known than its openings: published 6.98 and 14.5 kg.
    assert 1.0 < shell.x < shell.y < shell.z  # type: ignore[attr-defined]


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_a_density_scale_or_volume_that_is_none_is_refused(
    written: Callable[[str], Robot], bad: float
) -> None:
    robot = ball(written, 1.0)
    with pytest.raises(EffectError, match="the density of the fluid is"):
        immersed(robot, density=bad)
    with pytest.raises(RobotError, match="its scale is"):
        immersed(robot, scale=bad)
    with pytest.raises(RobotError, match="its volume is"):
        immersed(robot, volume=bad)


def test_a_body_lighter_than_the_air_it_displaces_is_refused(
    written: Callable[[str], Robot],
) -> None:
    # Millimetres taken for metres: a ball of 100 m that weighs 4 kg.
    with pytest.raises(RobotError, match="of air alone weigh"):
        immersed(ball(written, 4.0), scale=1000.0)


def test_a_body_without_shapes_and_a_way_that_is_none_are_refused(
    written: Callable[[str], Robot],
) -> None:
    bare = written(
        '<worldbody><body name="b"><freejoint/><inertial pos="0 0 0" mass="1" '
        'diaginertia="1 1 1"/></body></worldbody>'
    )
    with pytest.raises(RobotError, match="none of its links has a shape"):
        immersed(bare)
    with pytest.raises(RobotError, match="link ball: its wetted surface is to be 'skin'"):
        immersed(ball(written, 1.0), wetted_as="skin")
