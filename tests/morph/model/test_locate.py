from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.diagnosis import Located
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.locate import locate
from morph.model.pieces import part
from morph.model.segments import cut
from morph.model.shooting import predict
from morph.physics.effect import Effect
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.quadratic_damping import QuadraticDamping
from morph.record.recording import Recording

Recorded = Callable[..., Recording]


def located(robot: Robot, recorded: Recorded, *effects: Effect, start: float = 1.5) -> Located:
    runs = [
        recorded(robot, *effects, seconds=4.2, start={"hinge": start - 0.2 * k}, name=f"run_{k}")
        for k in range(2)
    ]
    step = step_for(runs, robot)
    model = Hypothesis(robot=robot, step=step, knobs=())
    episodes = [episode(run, robot, step) for run in runs]
    segments = cut(episodes, 1.0)
    predicted = predict(model, segments, [model.start], [segments.start])[0]
    return locate(model, model.start, episodes, segments, predicted)


def test_friction_that_grows_with_speed_is_placed_where_it_is_fast(
    pendulum: Robot, recorded: Recorded
) -> None:
    # Over a swing of v = sin, the mean of v^4 over the fastest quarter is 0.87 of its
    # peak, over all of it 0.375: 2.3 times as much, above the 1.5 that are asked.
    found = located(pendulum, recorded, QuadraticDamping(joint="hinge", b2=0.05))
    assert found.states.startswith("largest where abs(hinge.velocity) > ")
    assert found.states.endswith(" rad/s")


def test_a_spring_that_pulls_to_one_side_is_placed_at_the_other(
    pendulum: Robot, recorded: Recorded
) -> None:
    # k (q - 1) is 2 k at -1 and nothing at +1.
    spring = JointStiffness(joint="hinge", k=0.4, q0=1.0)
    found = located(pendulum, recorded, spring, start=1.0)
    assert found.states.startswith("largest where hinge.position < -")


def test_shares_are_sorted_and_add_up(cartpole: Robot, recorded: Recorded) -> None:
    found = located(cartpole, recorded, QuadraticDamping(joint="hinge", b2=0.02))
    shares = list(found.channels.values())
    assert set(found.channels) == {"slide.position", "hinge.position"}
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    assert shares == sorted(shares, reverse=True)
    of_times = [stretch.share for stretch in found.times]
    assert of_times == sorted(of_times, reverse=True)
    # Eight rollouts of a second, of which the five worst are named.
    assert len(of_times) == 5
    assert 5.0 / 8.0 <= sum(of_times) <= 1.0
    assert {stretch.episode for stretch in found.times} <= {"run_0", "run_1"}
    assert {stretch.recording for stretch in found.times} <= {"run_0", "run_1"}
    for stretch in found.times:
        assert stretch.end - stretch.start == pytest.approx(1.0, abs=1e-9)
        assert np.isfinite(stretch.share)


def test_the_worst_stretches_of_a_part_say_where_it_lies(
    cartpole: Robot, recorded: Recorded
) -> None:
    run = recorded(cartpole, seconds=4.2, start={"hinge": 1.0}, name="run")
    step = step_for([run], cartpole)
    model = Hypothesis(robot=cartpole, step=step, knobs=())
    later = part(episode(run, cartpole, step), 2.0, 4.1)
    segments = cut([later], 1.0)
    predicted = predict(model, segments, [model.start], [segments.start])[0]
    found = locate(model, model.start, [later], segments, predicted)
    # A whole recording begins within half a step of its first reading.
    assert [each.begin for each in found.times] == pytest.approx([2.0, 2.0], abs=step)
    assert {(each.episode, each.recording) for each in found.times} == {("run from 2.0 s", "run")}
