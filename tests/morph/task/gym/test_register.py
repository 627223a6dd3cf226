"""One environment: Gymnasium's own check, and what a run of it must agree with."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.shelf import builtin_shelf
from morph.errors import MorphError, SimulationFailed, TaskError
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.effect import Effect
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.search.evaluate import attempt
from morph.task.gym import environment, environment_id, pairs
from morph.task.gym.env import Environment
from morph.task.gym.spaces import command_range
from morph.task.moved import Moved
from morph.task.task import UNSTABLE
from morph.task.tasks import TASKS, task

SWING_UP = "morph.task.gym:morph/CartPole-SwingUp-v0"

QUICK = {"swing-up": "cartpole", "swim": "swimmer_three_links", "walk": "biped"}
"""Bodies that are quick to make, of tasks whose first body is not."""


def sampled() -> list[tuple[str, str]]:
    """Return one body for each task; `experiments/environments.py` tries them all."""
    first: dict[str, str] = {}
    for robot, asked in pairs():
        first.setdefault(asked, QUICK.get(asked, robot))
    return [(robot, asked) for asked, robot in first.items()]


@pytest.fixture(scope="module")
def cartpole() -> Robot:
    return load("cartpole")


@pytest.mark.parametrize(("robot", "asked"), sampled())
def test_gymnasiums_own_check_finds_nothing(robot: str, asked: str) -> None:
    # Its findings are warnings, and here a warning is an error.
    check_env(gymnasium.make(environment_id(robot, asked)).unwrapped)


@pytest.mark.parametrize(("robot", "asked"), sampled())
def test_the_rewards_of_a_run_add_up_to_less_its_loss(robot: str, asked: str) -> None:
    made = gymnasium.make(environment_id(robot, asked)).unwrapped
    assert isinstance(made, Environment)
    # A second is enough for terms and goals at the end to be asked for.
    made = Environment(replace(made.task, horizon=1.0))
    plant = made._runs._plant
    made.reset(seed=100)
    states, told, returned, ended = [], [], 0.0, False
    low, high = command_range(made.task.robot)
    while not ended:
        states.append((plant.position[0].copy(), plant.velocity[0].copy()))
        # A tenth of the range keeps bodies from becoming unstable.
        action = 0.1 * made.action_space.sample().astype(float)
        told.append((low + high) / 2.0 + action * (high - low) / 2.0)
        _, reward, terminated, ended, info = made.step(action)
        assert not terminated
        returned += reward
    states.append((plant.position[0].copy(), plant.velocity[0].copy()))
    moved = Moved(
        robot=made.task.robot,
        model=plant.model,
        time=made.task.period * np.arange(len(states)),
        position=np.array([q for q, _ in states])[None],
        velocity=np.array([v for _, v in states])[None],
        command=np.array([*told, told[-1]])[None],
    )
    assert returned == pytest.approx(-float(made.task.loss(moved)[0]), rel=1e-9)
    assert info["success"] == bool(made.task.succeeded(moved)[0])


def test_an_environment_of_a_robot_that_is_on_no_shelf_passes_that_check_too(
    cartpole: Robot,
) -> None:
    made = environment("balance", cartpole)
    check_env(made.unwrapped)
    assert made.spec is not None
    assert made.spec.id == "morph/CartPole-Balance-v0"


@pytest.mark.parametrize(
    ("robot", "asked", "name"),
    [
        ("cartpole", "swing-up", "morph/CartPole-SwingUp-v0"),
        ("so101", "reach", "morph/SO101-Reach-v0"),
        ("double_pendulum_a0", "balance", "morph/DoublePendulumA0-Balance-v0"),
        ("my.old-robot 2", "walk", "morph/MyOldRobot2-Walk-v0"),
    ],
)
def test_a_name_is_that_of_robot_and_task_with_capital_letters(
    robot: str, asked: str, name: str
) -> None:
    assert environment_id(robot, asked) == name


def test_every_pair_of_a_card_and_a_task_is_known_by_a_name_of_its_own() -> None:
    found = list(pairs())
    names = {environment_id(*pair) for pair in found}
    assert len(names) == len(found)
    assert names <= gymnasium.registry.keys()
    assert {pair for pair in found if pair[1] not in TASKS} == set()
    assert ("cartpole", "swing-up") in found


def test_bodies_on_a_shelf_of_ones_own_are_known_and_a_broken_card_harms_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MORPH_SHELF", str(tmp_path))
    shutil.copytree(builtin_shelf() / "pendulum", tmp_path / "mine")
    card = tmp_path / "mine" / "card.toml"
    card.write_text(card.read_text().replace('name = "pendulum"', 'name = "mine"'))
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "card.toml").write_text("tasks = [")
    found = list(pairs())
    assert ("mine", "swing-up") in found
    assert ("cartpole", "swing-up") in found
    assert "broken" not in {robot for robot, _ in found}


def linear(robot: Robot, seed: int) -> Linear:
    """Return a feedback that means nothing, strong enough to move the body."""
    rng = np.random.default_rng(seed)
    seen, told = observations_of(robot), actions_of(robot)
    return Linear(
        action=told,
        observation=seen,
        period=0.05,
        weight=rng.normal(size=(len(told), len(seen))),
        bias=np.zeros(len(told)),
    )


DELAY = ActuatorDelay(actuator="slide", T=0.013)
FRICTION = StribeckFriction(joint="hinge", c=0.01, s=0.02, vs=0.3)


@pytest.mark.parametrize("effects", [(), (DELAY,), (FRICTION,), (DELAY, FRICTION)])
def test_a_policy_does_in_an_environment_what_it_does_when_it_is_judged(
    cartpole: Robot, effects: tuple[Effect, ...]
) -> None:
    swing_up = task("swing-up", cartpole)
    policy = linear(cartpole, seed=100)
    moved = attempt(
        swing_up, policy, swing_up.simulator(effects), rows=1, rng=np.random.default_rng(7)
    )
    made = environment(swing_up, effects=effects)
    low, high = command_range(cartpole)
    seen, _ = made.reset(seed=7)
    rewards, told = [], []
    ended = False
    while not ended:
        told.append(policy.act(seen[None], np.array([0.05 * len(told)]))[0])
        # The same chance draws start and noise in both, so states agree to the rounding of
        # commands, 1e-16 of 10 N, that a run of 3 s lets grow by exp(3 s * 5 /s) = 3e6.
        action = (told[-1] - (low + high) / 2.0) / ((high - low) / 2.0)
        seen, reward, _, ended, info = made.step(action)
        rewards.append(reward)
    assert len(rewards) == swing_up.samples - 1
    np.testing.assert_allclose(told, moved.command[0, :-1], rtol=0.0, atol=1e-7)
    assert sum(rewards) == pytest.approx(-float(swing_up.loss(moved)[0]), abs=1e-7)
    assert info["success"] == bool(swing_up.succeeded(moved)[0])


def test_what_the_terms_cost_adds_up_to_what_the_run_cost_with_terms_of_the_end_only_at_the_end(
    cartpole: Robot,
) -> None:
    balance = task("balance", cartpole)
    assert len(balance.terms) > 2
    last = replace(balance.terms[0], name="at the end", last_only=True)
    made = environment(replace(balance, terms=(*balance.terms, last), horizon=1.0))
    made.reset(seed=100)
    total: dict[str, float] = {}
    returned, ended = 0.0, False
    while not ended:
        _, reward, _, ended, info = made.step(made.action_space.sample())
        returned += reward
        for name, cost in info["costs"].items():
            assert name != "at the end" or (cost > 0.0) == ended
            total[name] = total.get(name, 0.0) + cost
    assert returned == pytest.approx(-sum(total.values()), rel=1e-12)


def test_success_is_to_reach_every_goal_through_to_the_end(cartpole: Robot) -> None:
    # With next to no spread and noise the pole stands by itself for a second: it leaves the
    # top as exp(5 /s * 1 s) = 150 times 1e-6 rad, far from the 0.17 rad that are allowed.
    balance = task("balance", cartpole)
    still = replace(balance, horizon=1.0, noise=0.0, start=replace(balance.start, spread=1e-6))
    for push, stands in ((0.0, True), (1.0, False)):
        made = environment(still)
        made.reset(seed=100)
        ended = False
        while not ended:
            _, _, _, ended, info = made.step(np.array([push], dtype=np.float32))
        assert info["success"] is stands


def test_an_unstable_run_is_terminated_and_costs_what_a_task_says_that_it_costs(
    cartpole: Robot,
) -> None:
    made = environment("swing-up", cartpole)
    inner = made.unwrapped
    made.reset(seed=100)
    action = np.zeros(1, dtype=np.float32)
    returned = sum(float(made.step(action)[1]) for _ in range(5))
    inner._runs._plant.velocity[0] = 1e11  # type: ignore[attr-defined]
    seen, reward, terminated, truncated, info = made.step(action)
    assert (terminated, truncated, info["success"]) == (True, False, False)
    assert returned + float(reward) == pytest.approx(-UNSTABLE)
    assert seen in made.observation_space
    with pytest.raises(TaskError, match="its run is over"):
        inner.step(action)
    made.reset()
    assert not made.step(action)[2]


def test_an_action_beyond_one_is_taken_as_one(cartpole: Robot) -> None:
    def after(action: float) -> Array:
        made = environment("swing-up", cartpole)
        made.reset(seed=100)
        return np.asarray(made.step(np.array([action]))[0])

    np.testing.assert_array_equal(after(1.0), after(7.0))
    assert (after(1.0) != after(0.5)).any()


def no_robot() -> None:
    environment("swing-up")


def no_such_task() -> None:
    environment("swing-upp", "cartpole")


def no_such_channel() -> None:
    environment(replace(task("swing-up", load("cartpole")), observes=("hinge.posture",)))


def no_number() -> None:
    made = environment("swing-up", "cartpole")
    made.reset(seed=100)
    made.step(np.array([np.nan]))


def wrong_size() -> None:
    made = environment("swing-up", "cartpole")
    made.reset(seed=100)
    made.step(np.zeros(2))


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (no_robot, TaskError, "no robot is given"),
        (no_such_task, TaskError, "there is no task 'swing-upp'"),
        (no_such_channel, TaskError, "nearest channels are .*hinge.position"),
        (no_number, SimulationFailed, "not a finite number for each of 1 actuators"),
        (wrong_size, SimulationFailed, "not a finite number for each of 1 actuators"),
    ],
)
def test_what_cannot_be_done_is_refused_with_a_reason(
    wrong: object, error: type[MorphError], message: str
) -> None:
    assert callable(wrong)
    with pytest.raises(error, match=message):
        wrong()
