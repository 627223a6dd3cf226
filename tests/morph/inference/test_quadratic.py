"""The log posterior to second order, against its closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.quadratic import LogPosterior
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.joint.viscous_friction import ViscousFriction


@pytest.fixture(scope="module")
def nominal() -> Hypothesis:
    """Return a pendulum whose mass may be off by a quarter."""
    trust = {"mass": 0.25, "com": 0.0, "inertia": 0.0, "joint": 0.0, "gain": 0.0}
    robot = load("pendulum")
    return Hypothesis(robot=robot, step=0.002, knobs=knobs(robot, trust))


def test_where_no_run_tells_anything_own_figures_go_to_the_nominal(nominal: Hypothesis) -> None:
    own = len(nominal.knobs)
    bare = LogPosterior(
        hypothesis=nominal,
        point=np.full(own, 0.1),
        grams=np.zeros((1, 1 + own, 1 + own)),
        readings=100,
    )
    step, _, gained = bare.step()
    assert step == pytest.approx(-0.1)
    # Half the sum of squares of the prior: 0.5 (0.1 / 0.25)^2 for each figure.
    assert gained == pytest.approx(own * 0.5 * 0.16)


def test_each_parameter_of_an_effect_costs_half_the_logarithm_of_the_readings(
    nominal: Hypothesis,
) -> None:
    viscous = ViscousFriction(joint="hinge", b=0.1)
    whole = replace(nominal, effects=(viscous,))
    count = whole.size
    # The effect's column has length 20, at right angles to the others and to the errors.
    gram = np.zeros((1 + count, 1 + count))
    gram[count, count] = 400.0
    about = LogPosterior(
        hypothesis=whole, point=whole.start, grams=gram[None], readings=round(np.exp(6.0))
    )
    # Without it, 0.1 of its column is left: 0.5 * 400 * 0.01 nats. It costs 3.
    assert about.evidence([0]) - about.evidence([]) == pytest.approx(2.0 - 3.0, abs=1e-3)


def test_an_effect_that_stands_for_figures_pays_for_its_own(nominal: Hypothesis) -> None:
    trust = {"mass": 0.25, "com": 0.0, "inertia": 0.25, "joint": 0.0, "gain": 0.0}
    turned = replace(nominal, knobs=knobs(nominal.robot, trust))
    own = len(turned.knobs)
    link = LinkInertia(body=turned.knobs[0].part, mass=1.2, inertia=1.1)
    whole = replace(turned, effects=(link,))
    assert (turned.free_knobs, whole.free_knobs) == (own, own - 2)
    # Columns of length 20 at right angles to each other and to the errors.
    gram = 400.0 * np.eye(1 + whole.size)
    gram[0, 0] = 0.0
    about = LogPosterior(
        hypothesis=whole, point=whole.start, grams=gram[None], readings=round(np.exp(6.0))
    )
    cost = about.step()[2] - about.evidence([0])
    # Its two parameters cost 3 nats each, though two figures are no more free.
    # The logarithm of 403 readings is 5.999.
    assert cost == pytest.approx(6.0, abs=2e-3)


def test_damping_shortens_a_step_most_where_readings_tell_least(nominal: Hypothesis) -> None:
    whole = replace(nominal, knobs=(), effects=(ViscousFriction(joint="hinge", b=1.0),))
    # One entry: the second derivative is 400 and the prior's is of nothing, the first 40.
    gram = np.array([[10.0, 40.0], [40.0, 400.0]])
    about = LogPosterior(hypothesis=whole, point=whole.start, grams=gram[None], readings=100)
    free, _, promised = about.step()
    damped, _, less = about.step(damping=1.0)
    # 40 / 400, and 40 / (400 + 400); what it gains is that of the undamped second order.
    assert (free[0], damped[0]) == pytest.approx((0.1, 0.05), rel=1e-6)
    assert (promised, less) == pytest.approx((2.0, 2.0 - 0.5), rel=1e-6)
