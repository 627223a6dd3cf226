"""What a policy sees is what recordings name, as old and as noisy as it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.linear import Linear
from morph.policy.observing import Observer, observations_of, units
from morph.policy.policy import Observation, actions_of
from morph.sim.observe import observed
from morph.sim.simulator import Simulator

CART = load("cartpole")


def seeing(robot: Robot, observation: tuple[Observation, ...], period: float = 0.05) -> Linear:
    """Return a policy that sees something, and does nothing."""
    size, action = sum(each.history for each in observation), actions_of(robot)
    return Linear(
        weight=np.zeros((len(action), size)),
        bias=np.zeros(len(action)),
        action=action,
        observation=observation,
        period=period,
    )


def states(robot: Robot, rows: int) -> tuple[Simulator, Array, Array]:
    """Return the simulator of a robot, and states drawn at random."""
    simulator, rng = Simulator(robot), np.random.default_rng(0)
    model = simulator.model
    return simulator, rng.normal(size=(rows, model.nq)), rng.normal(size=(rows, model.nv))


@pytest.mark.parametrize("name", ["cartpole", "hexapod_swimmer", "quadruped_four_bar", "so101"])
def test_it_sees_what_a_recording_of_the_same_motion_holds(name: str) -> None:
    robot = load(name)
    simulator, q, v = states(robot, 5)
    observation = observations_of(robot)
    seen = Observer(seeing(robot, observation), robot, simulator.model, 5).see(q, v)
    recorded = observed(robot, simulator.model, np.linspace(0.0, 0.004, 5), q, v)
    assert seen.shape == (5, len(observation))
    for column, each in zip(seen.T, observation, strict=True):
        assert column.tolist() == recorded[each.channel].value.tolist()


def test_by_default_a_state_is_seen_as_it_is() -> None:
    simulator, q, v = states(CART, 3)
    seen = Observer(seeing(CART, observations_of(CART)), CART, simulator.model, 3).see(q, v)
    assert np.array_equal(seen, np.concatenate([q, v], axis=1))
    # The batch's own memory, which `q` and `v` may be, is not what was seen.
    assert not np.shares_memory(seen, q)


def test_units_are_those_of_joints_and_of_floating_bodies() -> None:
    assert units(CART) == {
        "slide.position": "m",
        "hinge.position": "rad",
        "slide.velocity": "m/s",
        "hinge.velocity": "rad/s",
    }
    hull = units(load("hexapod_swimmer"))
    assert hull["hull.position.z"] == "m"
    assert hull["hull.orientation.w"] == "1"
    assert hull["hull.angular_velocity.x"] == "rad/s"


def test_a_ball_joint_is_seen_by_its_own_name() -> None:
    robot = load("humanoid_skateboard")
    simulator, q, v = states(robot, 2)
    observation = observations_of(robot)
    seen = Observer(seeing(robot, observation), robot, simulator.model, 2).see(q, v)
    ball = simulator.model.joint("root")
    at = [each.channel for each in observation].index("root.orientation.w")
    first = ball.qposadr[0]
    assert np.array_equal(seen[:, at : at + 4], q[:, first : first + 4])
    # Nothing of the state is left out.
    assert np.array_equal(seen, np.concatenate([q, v], axis=1))


def test_a_chosen_few_are_seen_in_the_order_that_was_chosen() -> None:
    simulator, q, v = states(CART, 3)
    some = observations_of(CART, ("hinge.velocity", "slide.position"))
    seen = Observer(seeing(CART, some), CART, simulator.model, 3).see(q, v)
    assert np.array_equal(seen, np.stack([v[:, 1], q[:, 0]], axis=1))


def test_offset_is_subtracted_and_scale_divided_by() -> None:
    simulator, q, v = states(CART, 3)
    (one,) = observations_of(CART, ("hinge.position",))
    seen = Observer(
        seeing(CART, (replace(one, offset=3.0, scale=2.0),)), CART, simulator.model, 3
    ).see(q, v)
    assert seen[:, 0] == pytest.approx((q[:, 1] - 3.0) / 2.0, abs=1e-15)


def test_the_past_comes_newest_first_and_begins_with_the_first_reading() -> None:
    model = Simulator(CART).model
    position, speed = observations_of(CART, ("slide.position", "slide.velocity"))
    late = (replace(position, history=3), replace(speed, delay_s=0.1, history=2))
    observer = Observer(seeing(CART, late), CART, model, 1)
    # At step k the cart is at k and moves at 10 k; the speed is seen two periods later.
    found = [
        observer.see(np.array([[k, 0.0]]), np.array([[10.0 * k, 0.0]]))[0].tolist()
        for k in range(5)
    ]
    assert found == [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 0.0],
        [2.0, 1.0, 0.0, 0.0, 0.0],
        [3.0, 2.0, 1.0, 10.0, 0.0],
        [4.0, 3.0, 2.0, 20.0, 10.0],
    ]


def test_noise_has_its_deviation_in_the_channels_unit_and_ages_with_its_reading() -> None:
    model, rows = Simulator(CART).model, 20_000
    (one,) = observations_of(CART, ("slide.position",))
    policy = seeing(CART, (replace(one, scale=0.5, history=2),))
    observer = Observer(policy, CART, model, rows, np.random.default_rng(1), noise=0.1)
    still = np.zeros((rows, 2))
    first, second = observer.see(still, still), observer.see(still, still)
    # 0.1 m divided by 0.5; of 20000 the deviation is known to 1 / sqrt(40000) = 0.5 %.
    assert second.std(axis=0) == pytest.approx([0.2, 0.2], rel=0.02)
    assert np.array_equal(second[:, 1], first[:, 0])
    assert abs(np.corrcoef(second.T)[0, 1]) < 0.03


def test_a_channel_seen_twice_has_one_noise() -> None:
    model = Simulator(CART).model
    twice = observations_of(CART, ("slide.position", "slide.position"))
    observer = Observer(seeing(CART, twice), CART, model, 9, np.random.default_rng(1), noise=0.1)
    seen = observer.see(np.zeros((9, 2)), np.zeros((9, 2)))
    assert seen[:, 0].all()
    assert np.array_equal(seen[:, 0], seen[:, 1])


def test_without_chance_there_is_no_noise() -> None:
    simulator, q, v = states(CART, 2)
    observer = Observer(
        seeing(CART, observations_of(CART)), CART, simulator.model, 2, None, noise=1.0
    )
    assert np.array_equal(observer.see(q, v), np.concatenate([q, v], axis=1))


@pytest.mark.parametrize(
    ("channel", "near"),
    [
        ("hinge.positoin", "'hinge.position'"),
        ("hinge.acceleration", "'hinge.velocity'"),
        ("slide.command", "'slide.position'"),
        ("hull.position.z", "'slide.position'"),
    ],
)
def test_a_channel_that_the_body_lacks_is_refused_with_the_nearest(channel: str, near: str) -> None:
    with pytest.raises(PolicyError, match=channel) as caught:
        observations_of(CART, (channel,))
    assert near in caught.value.fix


def test_an_observer_of_another_body_is_refused() -> None:
    arm = load("so101")
    with pytest.raises(PolicyError, match="which the state of so101 does not hold"):
        Observer(seeing(CART, observations_of(CART)), arm, Simulator(arm).model, 1)


def test_a_delay_between_two_control_times_is_refused() -> None:
    (one,) = observations_of(CART, ("slide.position",))
    policy = seeing(CART, (replace(one, delay_s=0.06),))
    with pytest.raises(PolicyError, match=r"0.06 s late, and the control period is 0.05 s"):
        Observer(policy, CART, Simulator(CART).model, 1)


def test_runs_that_it_was_not_made_for_are_refused() -> None:
    simulator, q, v = states(CART, 3)
    observer = Observer(seeing(CART, observations_of(CART)), CART, simulator.model, 2)
    with pytest.raises(PolicyError, match="sees 3 runs, and was made for 2"):
        observer.see(q, v)
    with pytest.raises(PolicyError, match="noise of -1"):
        Observer(seeing(CART, observations_of(CART)), CART, simulator.model, 2, noise=-1.0)
