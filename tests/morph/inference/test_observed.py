"""The model that runs are linearised by knows how stiff effects are."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.inference.observed import observed
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.physics.joint.end_stop import EndStop
from morph.record.recording import Recording


def test_a_stop_is_as_stiff_in_the_linearised_model(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, seed=0, name="run", start={"hinge": 0.5})
    step = step_for([run], pendulum)
    read = episode(run, pendulum, step)
    nominal = Hypothesis(robot=pendulum, step=step, knobs=())
    model = nominal.at(nominal.start).model
    k, d, edge = 5.0, 0.3, 0.1
    stop = EndStop(joint="hinge", q_stop=edge, k=k, d=d)
    first = observed(model, pendulum, read)
    about = observed(model, pendulum, read, effects=[stop], before=first).about
    # The slope is that along the motion before.
    place, speed = first.motion.position[:, 0], first.motion.velocity[:, 0]
    inside = (place > edge + 1e-6) & (k * (place - edge) + d * speed > 1e-6)
    outside = place < edge - 1e-6
    assert min(inside.sum(), outside.sum()) > 100
    mobility, local = about.mobility[:, 0, 0], about.local[:, 0]
    # By the trapezoidal rule damping divides all by 1 - h / 2 times the slope of the acceleration.
    bare, stopped = (1.0 - 0.5 * step * (local[:, 1] - each * mobility) for each in (0.0, d))
    found = about.tangent.jacobian[:, 0, 0]
    # Central differences of a force that is linear err by rounding, 1e-16 / 1e-7.
    due = (local[:, 0] - k * mobility) / stopped
    assert found[inside] == pytest.approx(due[inside], rel=1e-6)
    assert found[outside] == pytest.approx((local[:, 0] / bare)[outside], rel=1e-9)
    assert np.isfinite(found).all()
