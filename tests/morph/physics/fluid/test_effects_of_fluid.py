"""What the effects of the fluid write into a body, whatever their order, and what they refuse."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics.body_motion import body_motions
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.numbers import CURRENT
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.thrust import Thrust
from morph.physics.motion import Motion
from morph.sim.simulator import Simulator

BALL = (
    '<worldbody><body name="ball"><freejoint/>'
    '<inertial pos="0 0 0" mass="2" diaginertia="0.1 0.2 0.3"/></body></worldbody>'
)
MASS = AddedMass(body="ball", x=1.0, y=2.0, z=3.0, rx=0.1, ry=0.2, rz=0.3, y_rz=0.2, cy=0.1)
LINEAR = LinearDrag(body="ball", x=1.0, rz=0.5, cx=0.5)
QUADRATIC = QuadraticDrag(body="ball", y=2.0, cx=0.5)
LIFT = Buoyancy(body="ball", volume=1e-3, cz=0.02)
STREAM = FluidCurrent(x=0.3, y=-0.2)
WAKE = Thrust(body="ball", C=0.5, span=0.1, x=-0.2, nz=1.0)


def forward(robot: Robot, effects: tuple[Effect, ...]) -> tuple[Array, Array]:
    """Return the inertia of a moving robot and the fluid's force on it."""
    model = Simulator(robot, effects).model
    data = mujoco.MjData(model)
    data.qvel[:] = 0.3, -0.5, 0.2, 1.0, -2.0, 0.7
    mujoco.mj_forward(model, data)
    whole = np.zeros((6, 6))
    mujoco.mj_fullM(model, data, whole)
    return whole, data.qfrc_passive.copy()


def seen(robot: Robot) -> Motion:
    """Return that one state as a motion."""
    model = Simulator(robot, ()).model
    state = np.zeros((1, model.nq)), np.array([[0.3, -0.5, 0.2, 1.0, -2.0, 0.7]]), np.zeros((1, 6))
    state[0][0, 3] = 1.0
    empty = np.zeros((1, 0, 6))
    return Motion(
        position=state[0], velocity=state[1], acceleration=state[2], drive=empty, drive_rate=empty,
        stiffness=np.zeros((1, 6, 6)), joints={}, actuators={},
        bodies=body_motions(model, ["ball"], *state),
    )  # fmt: skip


def test_the_order_of_effects_does_not_matter(written: Callable[[str], Robot]) -> None:
    robot = written(BALL)
    inertia, force = forward(robot, (MASS, LINEAR, QUADRATIC, LIFT, STREAM, WAKE))
    for some in list(permutations((MASS, LINEAR, QUADRATIC, LIFT, STREAM, WAKE)))[::37]:
        again, push = forward(robot, some)
        # Sums of a few numbers near 1, in another order.
        assert again == pytest.approx(inertia, abs=1e-14)
        assert push == pytest.approx(force, abs=1e-13)


def test_effects_of_one_link_add_up(written: Callable[[str], Robot]) -> None:
    robot = written(BALL)
    dry, _ = forward(robot, ())
    every = (MASS, LINEAR, QUADRATIC, LIFT, WAKE)
    alone = [forward(robot, (effect,)) for effect in every]
    inertia, force = forward(robot, every)
    assert inertia - dry == pytest.approx(sum(one - dry for one, _ in alone), abs=1e-14)
    assert force == pytest.approx(sum(push for _, push in alone), abs=1e-13)


@pytest.mark.parametrize("drag", [LINEAR, QUADRATIC])
def test_where_drag_acts_does_not_move_the_added_mass(
    written: Callable[[str], Robot], drag: Effect
) -> None:
    robot = written(BALL)
    alone, _ = forward(robot, (MASS,))
    for both in ((MASS, drag), (drag, MASS)):
        inertia, _ = forward(robot, both)
        assert inertia == pytest.approx(alone, abs=1e-14)


def test_added_mass_beside_the_origin_turns_with_it(written: Callable[[str], Robot]) -> None:
    # 3 kg of water along z, 0.1 m out along y: 3 * 0.01 kg m2 about x, and 3 * 0.1 kg m between.
    inertia, _ = forward(written(BALL), (AddedMass(body="ball", z=3.0, cy=0.1),))
    expected = np.diag([2.0, 2.0, 5.0, 0.13, 0.2, 0.3])
    expected[2, 3] = expected[3, 2] = 0.3
    assert inertia == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("first", [0, 1])
def test_two_drags_of_a_link_may_act_at_two_points(
    written: Callable[[str], Robot], first: int
) -> None:
    robot = written(BALL)
    pair = (LinearDrag(body="ball", x=1.0, cy=-0.2), QuadraticDrag(body="ball", x=2.0, cz=0.1))
    _, both = forward(robot, (pair[first], pair[1 - first]))
    alone = [forward(robot, (each,))[1] for each in pair]
    assert both == pytest.approx(sum(alone), abs=1e-14)
    inertia, _ = forward(robot, (MASS, *pair))
    assert inertia == pytest.approx(forward(robot, (MASS,))[0], abs=1e-14)


@pytest.mark.parametrize("kind", [LinearDrag, QuadraticDrag])
def test_two_drags_of_one_kind_about_two_points_are_refused(
    written: Callable[[str], Robot], kind: Any
) -> None:
    pair = (kind(body="ball", x=1.0, cx=0.5), kind(body="ball", x=1.0, cx=-0.5))
    with pytest.raises(EffectError, match="such a drag of ball to"):
        Simulator(written(BALL), pair)


def test_a_drag_that_does_nothing_has_no_point_to_quarrel_about(
    written: Callable[[str], Robot],
) -> None:
    robot = written(BALL)
    _, force = forward(robot, (LINEAR,))
    for idle in ((LINEAR, LinearDrag(body="ball")), (QuadraticDrag(body="ball", cz=1.0), LINEAR)):
        _, again = forward(robot, idle)
        assert np.array_equal(again, force)


@pytest.mark.parametrize(
    ("pair", "told"),
    [((LIFT, LIFT), "lifted by buoyancy already"), ((WAKE, WAKE), "has a thrust already")],
)
def test_what_a_link_can_have_once_is_refused_twice(
    written: Callable[[str], Robot], pair: tuple[Effect, ...], told: str
) -> None:
    with pytest.raises(EffectError, match=told):
        Simulator(written(BALL), pair)


@pytest.mark.parametrize(
    "wrong",
    [
        {"x": 1.0, "y": 1.0, "x_y": 1.1},  # Its determinant is 1 - 1.21.
        {"x": 1.0, "x_rz": 0.1},  # Turning about z alone has no energy, so it cannot couple.
        {"x": 4.0, "rz": 1e-3, "x_rz": 0.064},  # 4e-3 is less than 0.064^2 = 4.1e-3.
    ],
)
def test_an_added_mass_that_would_give_energy_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(EffectError, match="negative energy along some motion"):
        AddedMass(body="ball", **wrong)


def test_an_added_mass_at_the_edge_of_giving_energy_is_taken() -> None:
    assert AddedMass(body="ball", x=1.0, y=1.0, x_y=1.0).tensor[0, 1] == 1.0
    assert AddedMass(body="ball", x=4.0, rz=1e-3, x_rz=0.063).rz == 1e-3


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Buoyancy(body="ball", volume=-1e-3), "volume = -0.001 m3 is outside"),
        (lambda: Buoyancy(body="ball", volume=1.0, density=-1.0), "density = -1 kg/m3 is outside"),
        (lambda: Buoyancy(body="ball", volume=1.0, density=0.0), "density = 0 kg/m3 is outside"),
        (lambda: AddedMass(body="ball", x=-1.0), "x = -1 kg is outside"),
        (lambda: AddedMass(body="ball", x_y=float("nan")), "x_y = nan kg is outside"),
        (lambda: AddedMass.of("ball", np.full((6, 6), np.nan)), "nan kg is outside"),
        (lambda: LinearDrag(body="ball", z=-0.1), "z = -0.1 N s/m is outside"),
        (lambda: QuadraticDrag(body="ball", rz=-0.1), "rz = -0.1 N m s2/rad2 is outside"),
        (lambda: QuadraticDrag(body="ball", cx=float("inf")), "cx = inf m is outside"),
        (lambda: FluidCurrent(z=float("nan")), "z = nan m/s is outside"),
    ],
)
def test_a_parameter_that_is_no_such_thing_is_refused(make: Callable[[], Any], told: str) -> None:
    with pytest.raises(EffectError, match=told):
        make()


def test_a_tensor_that_is_not_symmetric_is_refused() -> None:
    tensor = np.eye(6)
    tensor[1, 0] = 0.5
    with pytest.raises(EffectError, match="symmetric"):
        AddedMass.of("ball", tensor)


def test_a_current_reaches_every_body_with_or_without_a_name(
    written: Callable[[str], Robot],
) -> None:
    ball = "<body pos='{} 0 0' {}><freejoint/><geom size='0.1'/></body>"
    text = "".join(ball.format(place, name) for place, name in enumerate(("", "", "name='c'")))
    model = Simulator(written(f"<worldbody>{text}</worldbody>"), (STREAM,)).model
    assert model.body_user[1:, CURRENT].tolist() == [[0.3, -0.2, 0.0]] * 3


def test_a_current_acts_through_the_drag_of_links(written: Callable[[str], Robot]) -> None:
    robot, current = written(BALL), (0.02, -0.03, 0.05)
    drag = LinearDrag(body="ball", x=0.7, y=1.1, z=0.4, rx=0.1, cx=0.1, cz=-0.2)
    still, moving = (
        forward(robot, (drag, *more))[1]
        for more in ((), (FluidCurrent(**dict(zip("xyz", current, strict=True))),))
    )
    motion = seen(robot)
    felt = FluidCurrent.through((drag,), motion)[0] @ np.array(current)
    # Linear drag is linear in the current: a difference over 1e-4 m/s rounds to 1e-12.
    assert felt == pytest.approx(moving - still, abs=1e-10)


def test_a_point_that_is_not_told_is_looked_for_out_on_the_link(
    written: Callable[[str], Robot],
) -> None:
    motion = seen(written(BALL.replace('pos="0 0 0"', 'pos="0.1 0 -0.2"')))
    com = motion.bodies["ball"].com
    assert com.any()
    centres = [each.centre for each in LinearDrag(body="ball").shapes(motion)]
    assert np.allclose(centres, np.outer([1.0, 1.5, 2.0], com))
    known = LinearDrag(body="ball", cy=0.3)
    assert known.shapes(motion) == (known,)
    one, other = LinearDrag(body="ball", cy=0.3), QuadraticDrag(body="ball", cy=0.3)
    # Refits move the point: of two drags each moves its own.
    assert {"cx", "cy", "cz"} <= {known.name for known in one.free()}
    assert one.beside(other)
