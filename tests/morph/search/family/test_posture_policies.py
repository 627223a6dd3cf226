"""Holding: what servos and motors are told, and that a body on its feet stays there."""

import numpy as np
import pytest

from morph.body.load import load
from morph.policy.linear import Linear
from morph.policy.pattern import Pattern
from morph.search.family.posture_policies import hold
from morph.search.generations.population import tried
from morph.task.stand import stand


def test_servos_are_told_their_posture_and_what_gravity_takes() -> None:
    robot = load("so101")
    family = hold(robot, {"Elbow": 0.5}, carried={"Elbow": 0.89})
    made = family.policy(family.start)
    assert isinstance(made, Pattern)
    told = dict(zip((a.actuator for a in made.action), made.swings, strict=True))
    # Its servos have 17.8 N m/rad: 0.89 N m bend one by 0.05 rad.
    assert told["Elbow"].offset == pytest.approx(0.5 + 0.05)
    assert told["Pitch"].offset == 0.0


def test_motors_are_told_what_springs_and_dampers_would_do() -> None:
    robot = load("hopper")
    family = hold(robot, {"knee": -0.3}, carried={"knee": 7.0})
    values = {number.name: number.start for number in family.numbers}
    values |= {"knee stiffness": 2.5, "knee damping": -2.0, "knee offset": 0.02}
    made = family.make(np.array([values[number.name] for number in family.numbers]))
    assert isinstance(made, Linear)
    channels = [each.channel for each in made.observation]
    seen = np.zeros(len(channels))
    seen[channels.index("knee.position")] = -0.25
    seen[channels.index("knee.velocity")] = 0.4
    k = 10.0**2.5
    told = made.act(seen, np.zeros(()))[[a.actuator for a in made.action].index("knee")]
    # Its axis points to the right, and an offset turns to the left.
    assert told == pytest.approx(7.0 + k * (-0.3 - 0.02 + 0.25) - 0.01 * k * 0.4)


@pytest.mark.parametrize("body", ["hopper", "biped"])
def test_motors_that_hold_keep_a_walker_on_its_feet_and_without_them_it_falls(body: str) -> None:
    task = stand(load(body), horizon=5.0)
    family = hold(task.robot, task.start.position, period=task.period)
    limp = Linear(
        weight=np.zeros((len(family.action), len(family.observation))),
        bias=np.zeros(len(family.action)),
        action=family.action,
        observation=family.observation,
        period=family.period,
    )
    rng = np.random.default_rng(3)
    policies = [family.policy(family.start), limp]
    score = tried(task, policies, task.simulator(), runs=4, rng=rng)
    assert score.success.all(axis=1).tolist() == [True, False]
    assert not score.success[1].any()
