"""AQUA's shell and paddle from the 15 numbers that are published for each."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from morph.body.robot import Robot
from morph.errors import EffectError, RobotError
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.box import boxed
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.sim.simulator import Simulator

# Georgiades 2005, Simulation and control of an underwater hexapod robot, McGill University.
SHELL: dict[str, Any] = {
    "sides": (0.64, 0.21, 0.12),
    "added": (6.98, 14.5, 32.41, 0.4, 1.19, 0.55),
    "drag": (0.9, 1.08, 1.28),
    "density": 999.97,
}
PADDLE: dict[str, Any] = {
    "sides": (0.16, 0.05, 0.003),
    "added": (0.0, 0.0, 0.264, 1e-5, 5e-4, 0.0),
    "drag": (0.0, 0.0, 1.12),
    "density": 999.97,
    "centre": (-0.088, 0.0, 0.0),
}


def test_the_shells_numbers_arrive_where_they_belong() -> None:
    added, lift, drag = boxed("hull", **SHELL)
    assert isinstance(added, AddedMass)
    assert (added.x, added.y, added.z) == (6.98, 14.5, 32.41)
    assert (added.rx, added.ry, added.rz) == (0.4, 1.19, 0.55)
    assert isinstance(lift, Buoyancy)
    assert lift.volume == pytest.approx(0.64 * 0.21 * 0.12)
    assert isinstance(drag, QuadraticDrag)
    # 1/2 rho C A of each face, by hand; about z two pairs of faces, rho c (Cx b^4 + Cy a^4) / 64.
    assert drag.x == pytest.approx(0.5 * 999.97 * 0.9 * 0.21 * 0.12)
    assert drag.y == pytest.approx(0.5 * 999.97 * 1.08 * 0.64 * 0.12)
    assert drag.z == pytest.approx(0.5 * 999.97 * 1.28 * 0.64 * 0.21)
    assert drag.rz == pytest.approx(999.97 * 0.12 * (0.9 * 0.21**4 + 1.08 * 0.64**4) / 64)


def test_the_shell_that_sinks_ends_at_the_speed_at_which_its_drag_carries_it(
    written: Callable[[str], Robot],
) -> None:
    robot = written(
        '<worldbody><body name="hull"><freejoint/><inertial pos="0 0 0" mass="16.4" '
        'diaginertia="0.1 0.5 0.6"/></body></worldbody>'
    )
    lost = 1e-3
    effects = boxed("hull", **SHELL, volume=16.4 / 999.97 - lost)
    run = Simulator(robot, effects, step=0.01).run(seconds=12.0)
    # rho g lost = 1/2 rho C A v^2; on the way there v goes as tanh(t / T), with
    # T = (16.4 + 32.41) / sqrt(9.81 * 86.0) = 1.7 s, and 1 - tanh(12 / 1.7) is 1.5e-6.
    due = math.sqrt(2.0 * 9.81 * lost / (1.28 * 0.64 * 0.21))
    assert -run.channel("hull.linear_velocity.z").value[-1] == pytest.approx(due, rel=2e-6)


def test_a_paddle_beside_its_hinge_refers_to_its_own_centre() -> None:
    for effect in boxed("left_front_paddle", **PADDLE):
        assert (effect.cx, effect.cy, effect.cz) == PADDLE["centre"]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sides": (0.64, 0.21, 0.0)}, "its sides are"),
        ({"sides": (0.64, 0.21)}, "give 3 finite numbers"),
        ({"added": (1.0, 1.0, 1.0)}, "give 6 finite numbers"),
        ({"added": (-1.0, 1.0, 1.0, 0.1, 0.1, 0.1)}, "0 or more"),
        ({"drag": (0.9, -1.0, 1.2)}, "the coefficient is -1"),
        ({"drag": (0.9, math.nan, 1.2)}, "its drag are"),
        ({"centre": (0.0, math.inf, 0.0)}, "its centre are"),
        ({"volume": 0.0}, "it displaces 0 m3"),
    ],
)
def test_numbers_that_make_no_box_are_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(RobotError, match=said):
        boxed("hull", **(SHELL | change))


@pytest.mark.parametrize("density", [0.0, -1.0, math.nan])
def test_a_density_that_is_none_is_refused(density: float) -> None:
    with pytest.raises(EffectError, match="the density of the fluid is"):
        boxed("hull", **(SHELL | {"density": density}))
