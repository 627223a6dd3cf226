"""A policy adjusted after one run: what is added, and what it is worth."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TransferError
from morph.model.latent.unknowns import turned
from morph.policy.policy import Policy
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.adjustment.adjust import (
    AdjustedPolicy,
    AdjustSettings,
    adjusted,
    applied,
)
from morph.policy_transfer.adjustment.adjusted_rollout import Pretended, foreseen, most_promising
from morph.policy_transfer.adjustment.beyond import beyond
from morph.policy_transfer.adjustment.source import SimulatedTask, states_of
from morph.search.evaluate import evaluate
from morph.search.lqr import Lqr
from morph.search.search import Problem
from morph.search.target import Experience, Simulated
from morph.task.balance import balance


@pytest.fixture(scope="module")
def made(source: SimulatedTask, plan: Policy, run: Experience) -> AdjustedPolicy:
    return adjusted(source, plan, [run], rng=np.random.default_rng(1))


def shares(task_of: Simulated, *policies: Policy) -> list[float]:
    return [
        evaluate(task_of.task, each, task_of.simulator, rng=np.random.default_rng(3), rows=20).share
        for each in policies
    ]


def test_inverse_dynamics_of_the_source_undo_what_it_does(source: SimulatedTask) -> None:
    rng = np.random.default_rng(0)
    x, u = rng.normal(size=(30, 4)), rng.uniform(-10.0, 10.0, (30, 1))
    # Of what is not affine, a few percent of 10 N, the second step leaves a few percent.
    assert source.inverse(x, source.after(x, u)) == pytest.approx(u, abs=0.1)


def test_what_a_policy_saw_is_what_its_commands_followed_from(
    source: SimulatedTask, plan: Policy, run: Experience
) -> None:
    seen, time = source.seen(plan, run)
    assert plan.act(seen, time) == pytest.approx(run.command, abs=1e-12)


def test_friction_is_named_by_one_run_and_the_next_succeeds(
    made: AdjustedPolicy, plan: Policy, rough: Simulated
) -> None:
    # The slide's speed is the second feature that is no angle; 1 N s/m more are to be added.
    assert made.adjustment.law[0, 1] == pytest.approx(1.0, abs=0.15)
    before, after = shares(rough, plan, made.policy)
    assert before < 0.2
    assert after > 0.9


def test_the_sign_and_the_commands_of_the_run_matter(
    source: SimulatedTask, made: AdjustedPolicy, plan: Policy, rough: Simulated, run: Experience
) -> None:
    flipped = applied(made.adjustment.times(-1.0), plan)
    mixed = replace(run, command=np.random.default_rng(5).permutation(run.command))
    shuffled = adjusted(source, plan, [mixed], rng=np.random.default_rng(1)).policy
    assert shares(rough, flipped, shuffled) == [0.0, 0.0]


def test_a_target_that_is_the_source_asks_for_little(source: SimulatedTask, plan: Policy) -> None:
    runs = [source.run(plan, np.random.default_rng(2))]
    found = adjusted(source, plan, runs, rng=np.random.default_rng(1))
    seen, time = source.seen(plan, runs[0])
    added = found.policy.added(seen, plan.act(seen, time))
    # One step tells the command to 0.01 * 0.5 kg / 0.05 s * sqrt(2) = 0.14 N or more; what is
    # smooth over several is told better.
    assert np.sqrt(np.square(added).mean()) < 0.2
    assert min(found.followed.share.values()) > 0.9


@pytest.mark.parametrize("starts", ["source", "target"])
def test_either_body_may_say_where_to_adjust(
    source: SimulatedTask, plan: Policy, run: Experience, rough: Simulated, starts: str
) -> None:
    how = AdjustSettings(starts=starts)
    found = adjusted(source, plan, [run], rng=np.random.default_rng(1), settings=how)
    assert shares(rough, found.policy)[0] > 0.8


def test_locally_weighted_regression_adjusts_too(
    source: SimulatedTask, plan: Policy, run: Experience, rough: Simulated
) -> None:
    how = AdjustSettings(inverse="local")
    found = adjusted(source, plan, [run], rng=np.random.default_rng(1), settings=how)
    assert shares(rough, found.policy)[0] > 0.8


def test_an_adjusted_policy_is_stored_and_commands_within_bounds(
    made: AdjustedPolicy, run: Experience, source: SimulatedTask, tmp_path
) -> None:
    robot = source.task.robot
    folder = write_policy(made.policy, tmp_path / "policy", robot)
    assert load_policy(folder, robot) == made.policy
    said = json.loads((folder / "policy.json").read_text())
    assert said["kind"] == "adjusted"
    assert said["parts"] == {"adjusted": {"source": "track"}}
    seen, time = source.seen(made.policy, run)
    told = made.policy.act(50.0 * seen, time)
    assert np.abs(told).max() <= 10.0


def test_what_was_adjusted_is_adjusted_anew(
    source: SimulatedTask, made: AdjustedPolicy, plan: Policy, run: Experience
) -> None:
    again = adjusted(source, made.policy, [run], rng=np.random.default_rng(1))
    assert again.policy == made.policy
    assert applied(made.adjustment, made.policy) == made.policy


def test_another_task_on_the_same_pair_uses_the_same_adjustment(made: AdjustedPolicy) -> None:
    robot = load("cartpole")
    mine, its = balance(robot), balance(turned(robot, {"damping:slide": 11.0}))
    law = Lqr().run(Problem(task=mine, simulator=mine.simulator()), seed=0).policy
    target = its.simulator()
    losses = [
        evaluate(its, each, target, rng=np.random.default_rng(0), rows=40).mean
        for each in (law, applied(made.adjustment, law))
    ]
    source_loss = evaluate(mine, law, mine.simulator(), rng=np.random.default_rng(0), rows=40).mean
    # The adjustment was made of a swing-up, and comes nearer to what the law costs at home.
    assert abs(losses[1] - source_loss) < abs(losses[0] - source_loss)


def test_a_longer_pole_is_beyond_every_command_and_friction_is_not(
    source: SimulatedTask, plan: Policy, run: Experience, changed
) -> None:
    long = changed("length:pole", 1.5).trial(plan, np.random.default_rng(0))
    # 60 steps of 3 dimensions: 1 within 1 / sqrt(2 * 180) = 0.05, and the bounds of the source,
    # beyond which its inverse cannot look, add some.
    assert 0.8 < beyond(source, [run]) < 1.4
    assert beyond(source, [long]) > 2.0


def test_pretending_does_what_the_target_does(
    source: SimulatedTask, made: AdjustedPolicy, plan: Policy, rough: Simulated, run: Experience
) -> None:
    stepped = Pretended(source, made.adjustment, plan.observation)
    x = states_of(run)[:-1]
    u = stepped.felt(x, run.command)
    assert u + made.adjustment(x, u) == pytest.approx(run.command, abs=0.02)
    target = SimulatedTask(task=rough.task, simulator=rough.simulator)
    truly = target.after(x, run.command)
    q, v = stepped.advance(x[:, :2], x[:, 2:], run.command)
    untold = source.after(x, run.command)
    error = np.abs(np.concatenate([q, v], axis=1) - truly).mean()
    assert error < 0.2 * np.abs(untold - truly).mean()
    # What is foreseen holds.
    policy, (promised,) = most_promising(
        source, made.adjustment, [plan], rng=np.random.default_rng(0)
    )
    assert policy == made.policy
    assert promised.share > 0.9
    assert foreseen(source, source.plant, plan, rows=8, rng=np.random.default_rng(0)).share > 0.8


def test_what_is_no_run_of_the_body_is_refused(
    source: SimulatedTask, plan: Policy, run: Experience
) -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(TransferError, match="there is no run"):
        adjusted(source, plan, [], rng=rng)
    with pytest.raises(TransferError, match=r"every 0\.1 s; the source"):
        adjusted(source, plan, [replace(run, period=0.1)], rng=rng)
    with pytest.raises(TransferError, match="starts is 'nowhere'"):
        AdjustSettings(starts="nowhere")
