from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.model.episodes import episode, step_for
from morph.model.fit import Fit, PointBounds, fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.model.segments import cut
from morph.model.shooting import predict
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.series_elasticity import SeriesElasticity
from morph.record.recording import Recording

Recorded = Callable[..., Recording]


@pytest.fixture(scope="module")
def heavy(cartpole: Robot, recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Fit:
    """A cart-pole's masses, fitted to one whose pole weighs 7 % more and pulls the cart."""
    path = tmp_path_factory.mktemp("heavy") / "heavy.xml"
    assert cartpole.source is not None
    text = cartpole.source.read_text()
    # The pole's shape stays: its inertia about its own centre too, for what is asked is mass.
    assert text.count('pos="0 0 -0.25" mass="0.5"') == 1
    path.write_text(text.replace('pos="0 0 -0.25" mass="0.5"', 'pos="0 0 -0.25" mass="0.535"'))
    run = recorded(
        load(Path(path)),
        seconds=8.2,
        start={"hinge": 1.0},
        command=lambda times: 1.5 * np.sin(4.0 * times),
    )
    step = step_for([run], cartpole)
    trusted = {"com": 0.0, "inertia": 0.0, "gain": 0.0, "joint": 0.0}
    model = Hypothesis(robot=cartpole, step=step, knobs=knobs(cartpole, trusted))
    segments = cut([episode(run, cartpole, step)], 1.0)
    read = predict(model, segments, [model.start], [segments.start])[0]
    first = fit(model, segments, *measure(segments, read))
    read = predict(model, segments, [first.point], [first.start])[0]
    return fit(model, segments, *measure(segments, read), point=first.point, start=first.start)


def test_a_pole_that_weighs_more_is_found(heavy: Fit) -> None:
    factors = dict(zip(heavy.hypothesis.names, np.exp(heavy.point), strict=True))
    # Commands are centred half a simulated step, 0.25 ms, off: at 4 rad/s 0.1 % of them.
    # Encoders are good to 2e-4 rad of swings of 1 rad, a thousand times over. 1 % is ample.
    assert factors == pytest.approx({"mass:cart": 1.0, "mass:pole": 1.07}, abs=0.01)


def test_a_change_is_the_least_of_its_quadratic_within_its_bounds() -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    hessian, slope = root @ root.T + 0.1 * np.eye(3), 3.0 * rng.normal(size=3)
    room = PointBounds(
        low=np.full(3, -0.5), high=np.full(3, 0.5), trust=np.full(3, 0.2), centre=np.zeros(3)
    )
    point = np.array([0.1, -0.2, 0.3])
    change = room.best_change(hessian, slope, point)
    assert ((room.low <= point + change) & (point + change <= room.high)).all()

    def cost(d: np.ndarray) -> float:
        return float(d @ hessian @ d - 2.0 * slope @ d) + room.price(point + d)

    # No point of a fine grid of the box is better: the quadratic bends by at most the
    # largest eigenvalue, so the nearest of 41 points a side loses no more than it gains.
    axes = [np.linspace(room.low[k], room.high[k], 41) - point[k] for k in range(3)]
    least = min(cost(np.array(d)) for d in np.stack(np.meshgrid(*axes), -1).reshape(-1, 3))
    assert cost(change) <= least + 1e-9


def test_a_points_entries_are_named_bounded_and_read_back(cartpole: Robot) -> None:
    model = Hypothesis(
        robot=cartpole,
        step=0.002,
        knobs=knobs(cartpole, {"com": 0.0, "inertia": 0.0, "gain": 0.0, "joint": 0.0}),
        effects=(
            CoulombFriction(joint="slide", c=0.3),
            JointStiffness(joint="hinge", k=2.0, q0=-0.4),
        ),
    )
    assert model.names == (
        "mass:cart",
        "mass:pole",
        "coulomb_friction@slide:c",
        "joint_stiffness@hinge:k",
        "joint_stiffness@hinge:q0",
    )
    assert model.start.tolist() == [0.0, 0.0, 0.3, 2.0, -0.4]
    assert ((model.low <= model.start) & (model.start <= model.high)).all()
    point = np.array([np.log(1.1), 0.0, 0.1, 1.0, 0.2])
    assert model.effects_at(point) == (
        CoulombFriction(joint="slide", c=0.1),
        JointStiffness(joint="hinge", k=1.0, q0=0.2),
    )
    compiled = model.at(point).model
    assert compiled.body("cart").mass[0] == pytest.approx(0.55, rel=1e-12)
    assert compiled.joint("slide").frictionloss[0] == pytest.approx(0.1, rel=1e-12)


def test_a_stiffness_and_a_limit_are_entered_as_one_over_them(cartpole: Robot) -> None:
    effects = (SeriesElasticity(joint="slide", k=200.0, d=0.5), TorqueSaturation(actuator="slide"))
    model = Hypothesis(robot=cartpole, step=0.002, knobs=(), effects=effects)
    # Without a limit its entry is that of the greatest value, 1e9.
    assert model.start == pytest.approx([0.005, 0.5, 1e-9])
    assert model.effects_at(model.start) == effects
    softer, _, limited = np.eye(3)
    spring, limit = model.effects_at(model.start + 0.005 * softer + 0.25 * limited)
    # 1 / 0.01 = 100 N/m, and 1 / 0.25 = 4 N but for the entry of no limit, 4e-9 of it.
    assert spring.coefficients[0] == pytest.approx(0.01)
    assert limit.limits(np.zeros(1))[1] == pytest.approx(4.0, rel=1e-8)
    rigid, _ = model.effects_at(model.start - 0.01 * softer)
    assert rigid == replace(effects[0], k=1e9)
