"""Many environments on one batch, held against as many that are stepped one by one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from morph.body.load import load
from morph.errors import TaskError
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.effect import Effect
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.worlds import world
from morph.task.gym import environments
from morph.task.gym.env import Environment
from morph.task.gym.vector import Environments
from morph.task.quantity import Direction, Point
from morph.task.task import UNSTABLE, Task
from morph.task.tasks import task
from morph.task.term import Goal, Term

NAME = "morph.task.gym:morph/CartPole-SwingUp-v0"


@pytest.fixture(scope="module")
def short() -> Task:
    """A swing-up of 7 control periods."""
    return replace(task("swing-up", load("cartpole")), horizon=0.35)


def one_by_one(made: Task, count: int, effects: tuple[Effect, ...] = ()) -> SyncVectorEnv:
    return SyncVectorEnv([lambda: Environment(made, effects=effects)] * count)


def same(one: Any, other: Any) -> bool:
    return bool(data_equivalence(one, other, exact=True))


DELAY = ActuatorDelay(actuator="slide", T=0.013)
FRICTION = StribeckFriction(joint="hinge", c=0.01, s=0.02, vs=0.3)


@pytest.mark.parametrize("effects", [(), (DELAY, FRICTION)])
@pytest.mark.parametrize("seed", [100, [7, 3, 9]])
def test_a_batch_does_what_environments_do_one_by_one_through_the_ends_of_their_runs(
    short: Task, effects: tuple[Effect, ...], seed: int | list[int]
) -> None:
    batch = Environments(short, num_envs=3, effects=effects)
    single = one_by_one(short, 3, effects)
    assert same(batch.reset(seed=seed), single.reset(seed=seed))
    batch.action_space.seed(100)
    ends = 0
    for _ in range(20):
        action = batch.action_space.sample()
        mine, its = batch.step(action), single.step(action)
        assert same(mine, its)
        ends += int(mine[3].sum())
    # 20 steps hold two runs of 7 and the step after each that starts the next.
    assert ends == 2 * 3
    assert same(batch.reset(), single.reset())


def test_a_body_that_floats_on_a_floor_does_the_same_in_a_batch() -> None:
    robot = load("quadruped_printed")
    trunk = next(joint.link for joint in robot.joints if joint.kind == "free")
    level = Point(link=trunk, axes="z")
    stand = Task(
        name="stand",
        robot=robot,
        terms=(Term(name="height", quantity=level, target=(0.1,), width=0.1),),
        goals=(Goal(name="up", quantity=Direction(link=trunk), target=(0, 0, 1), within=0.5),),
        horizon=0.1,
        period=0.02,
        step=0.002,
        effects=world("hard_floor", robot).effects,
    )
    batch, single = Environments(stand, num_envs=2), one_by_one(stand, 2)
    assert same(batch.reset(seed=100), single.reset(seed=100))
    batch.action_space.seed(100)
    for _ in range(7):
        action = batch.action_space.sample()
        assert same(batch.step(action), single.step(action))


def test_a_run_that_fails_is_started_anew_and_the_others_go_on_as_if_alone(short: Task) -> None:
    batch, single = Environments(short, num_envs=3), one_by_one(short, 3)
    batch.reset(seed=100)
    single.reset(seed=100)
    batch.action_space.seed(100)
    returned = np.zeros(3)
    ended: list[tuple[int, int]] = []
    for at in range(16):
        if at == 3:
            batch._runs._plant.velocity[1] = 1e11
            single.envs[1].unwrapped._runs._plant.velocity[0] = 1e11  # type: ignore[attr-defined]
        action = batch.action_space.sample()
        seen, reward, terminated, truncated, info = batch.step(action)
        assert same((seen, reward, terminated, truncated, info), single.step(action))
        assert terminated.tolist() == [False, at == 3, False]
        returned += reward
        if at == 3:
            assert returned[1] == pytest.approx(-UNSTABLE)
        ended += [(at, int(row)) for row in np.flatnonzero(truncated)]
    # Runs take 7 steps and one more to start anew: 0 and 2 end with steps 6 and 6 + 8, and 1,
    # which failed at 3, with 3 + 8.
    assert ended == [(6, 0), (6, 2), (11, 1), (14, 0), (14, 2)]


def test_make_vec_gives_the_batch_and_says_how_it_starts_anew() -> None:
    made = gymnasium.make_vec(NAME, num_envs=5, vectorization_mode="vector_entry_point")
    assert isinstance(made, Environments)
    assert made.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert made.action_space.shape == (5, 1)
    seen, _ = made.reset(seed=100)
    assert seen in made.observation_space
    made.close()


def test_the_first_of_many_with_a_seed_is_one_with_that_seed(short: Task) -> None:
    alone = Environment(short)
    np.testing.assert_array_equal(
        environments(short, num_envs=4).reset(seed=100)[0][2], alone.reset(seed=102)[0]
    )


def test_what_is_returned_is_not_changed_by_the_next_step(short: Task) -> None:
    batch = Environments(short, num_envs=2)
    batch.reset(seed=100)
    kept = batch.step(np.ones((2, 1)))
    before = [np.copy(each) for each in kept[:4]], np.copy(kept[4]["costs"]["tip"])
    batch.step(-np.ones((2, 1)))
    assert same(before, (list(kept[:4]), kept[4]["costs"]["tip"]))


def test_noise_is_of_the_size_that_the_task_says_and_new_at_each_sample(short: Task) -> None:
    rows = 400
    quiet = Environments(replace(short, noise=0.0), num_envs=rows)
    noisy = Environments(replace(short, horizon=2.0, noise=0.1), num_envs=rows)
    quiet.reset(seed=100)
    noisy.reset(seed=100)
    off = []
    for _ in range(7):
        action = np.zeros((rows, 1))
        off.append(noisy.step(action)[0] - quiet.step(action)[0])
    drawn = np.array(off)
    # 7 * 400 * 4 = 11200 draws: their deviation is known to 1 / sqrt(2 * 11200) = 0.7 %, and
    # the mean product of two samples, 0 if they are independent, to 0.01 / sqrt(9600) = 1e-4.
    assert drawn.std() == pytest.approx(0.1, rel=0.03)
    assert abs((drawn[1:] * drawn[:-1]).mean()) < 5e-4


def test_what_cannot_be_done_is_refused_with_a_reason(short: Task) -> None:
    with pytest.raises(TaskError, match="0 environments are asked for"):
        Environments(short, num_envs=0)
    batch = Environments(short, num_envs=2)
    with pytest.raises(TaskError, match="they were never started"):
        batch.step(np.zeros((2, 1)))
    with pytest.raises(TaskError, match="3 seeds are given for 2 environments"):
        batch.reset(seed=[1, 2, 3])
