"""Plan under actuation delay: optimise without it, then refine on the delay-augmented state."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.evaluate import evaluate
from morph.search.plan.evaluate_plan import concluded
from morph.search.plan.filtered import Along, along, filtered, gains
from morph.search.plan.initial_trajectories import SeedInputs, led, swung
from morph.search.plan.plan_selection import SURE, Planned, joined, sifted
from morph.search.plan.policy import track_of
from morph.search.plan.terminal_controller import grounded
from morph.search.plan.warm_start import recalled
from morph.search.search import Learned, Problem, Trial
from morph.search.trajectory.backward import backward
from morph.search.trajectory.ddp import DAMPING, LENGTHS, Trajectories
from morph.search.trajectory.delay_augmented_plant import DelayAugmentedPlant, prompt
from morph.sim.simulator import Simulator
from morph.sim.threads import one_thread
from morph.task.task import Task

KINDS = (
    (30.0, math.inf),
    (30.0, 0.1),
    (300.0, 0.1),
    (3000.0, 0.1),
    (300.0, 1.0),
    (300.0, 0.01),
    (3000.0, 0.01),
)
"""What feedback is tried, as in `best`: that on a sample alone knows nothing of what is under way,
and a filter reckons it from what it saw."""

KEEP = 3
"""Guesses of each kind that are improved."""

TRIES = ((256, 0.0), (768, 0.0), (768, 0.1))
"""Fresh swings of each try, and the share of each command's range that is left to the feedback."""

MOST, ENOUGH = 20, 1e-3
"""Most steps by which a led plan is improved, and the share of its cost that counts as none."""

FOLLOWED = (1.0, 10.0, 100.0, 1000.0)
"""What the commands of the feedback may cost that follows a plan first."""

RUNS = 24
"""Noisy runs by which led plans are judged."""


def led_late(ground: SeedInputs, line: DelayAugmentedPlant, plan: Trajectories) -> Trajectories:
    """Return a plan, made as if commands were prompt, led so that they come in time.

    First it is followed with the feedback of the linear-quadratic problem about it, which knows
    what is under way; what that does is then improved by differential dynamic programming.
    """
    given = np.repeat(plan.command[:, :, None], line.substeps, axis=2)
    near = _near(ground, line, plan, given)
    low, high = ground.bounds
    command = replace(plan, command=line.told(plan.command, low, high))
    periods, none = plan.command.shape[1], np.zeros_like(plan.command)
    runs = [
        line.followed(ground.cost, command, gains(near, effort)[:, :periods], none, low, high)
        for effort in FOLLOWED
    ]
    now = joined(runs)
    return improved(ground, line, now.rows(np.array([int(np.argmin(now.cost))])))


def improved(ground: SeedInputs, line: DelayAugmentedPlant, now: Trajectories) -> Trajectories:
    """Return one run of a late body, improved by differential dynamic programming."""
    low, high = ground.bounds
    scale = (0.5 * (line.high - line.low)) ** -2.0
    damping = DAMPING
    lengths = np.array(LENGTHS)
    for _ in range(MOST):
        given = line.arriving(now.command)
        A, B, _ = line.linearised(now.position[:, :-1], now.velocity[:, :-1], given)
        cost = line.widened(ground.cost.quadratic(now.position, now.velocity, now.command))
        law = backward(A, B, cost, low - now.command, high - now.command, damping * scale[None])
        many = now.rows(np.zeros(len(lengths), dtype=np.int64))
        change = lengths[:, None, None] * law.change
        gain = np.repeat(law.gain, len(lengths), axis=0)
        tried = line.followed(ground.cost, many, gain, change, low, high)
        best = tried.rows(np.array([int(np.argmin(tried.cost))]))
        fell = float(now.cost[0] - best.cost[0])
        damping *= 0.3 if fell > 0.0 else 10.0
        if fell > 0.0:
            now = best
        if 0.0 < fell <= ENOUGH * abs(now.cost[0]) or damping > 1e3:
            break
    return now


def _near(ground: SeedInputs, line: DelayAugmentedPlant, plan: Trajectories, given: Array) -> Along:
    """Return what a late body does near a plan, and then at rest."""
    plain = along(ground, plan)
    A, B, push = line.linearised(plan.position[:, :-1], plan.velocity[:, :-1], given)
    still = plain.A.shape[1] - A.shape[1]
    rest = ground.still
    # Far from the start nothing of it is under way: the last period stands for all of rest.
    whole = np.broadcast_to(rest.command, (1, line.periods, line.substeps, line.model.nu))
    q = np.broadcast_to(rest.position, (1, line.periods, line.model.nq))
    v = np.broadcast_to(rest.velocity, (1, line.periods, line.model.nv))
    at_rest = [each[:, -1:] for each in line.linearised(q, v, whole)]
    size = (len(plan.cost), still)
    A, B, push = (
        np.concatenate([one, np.broadcast_to(end, (*size, *end.shape[2:]))], axis=1)
        for one, end in zip((A, B, push), at_rest, strict=True)
    )
    return Along(A=A, B=B, push=push, cost=line.widened(plain.cost), passed=plain.passed)


def late(
    task: Task,
    simulator: Simulator,
    old: Policy | None,
    *,
    seed: int,
    others: Sequence[Simulator] = (),
    tries: Sequence[tuple[int, float]] = TRIES,
) -> Learned:
    """Return a plan with feedback for a body that delays or lags.

    Args:
        task: The task.
        simulator: The body; what changes commands on their way is among its effects.
        old: What did the task before, to begin from; None to begin with fresh swings.
        seed: Chance begins from it.
        others: Further simulators of the same body, in which plans are judged too.
        tries: Fresh swings of each try and its margin; the next is made while a plan fails.

    Raises:
        SearchError: The body cannot rest where its goals are met, or nothing holds it there.
        SimulationFailed: The task's control period does not fit the simulator.
    """
    began = time.monotonic()
    bodies = (simulator, *others)
    best: tuple[SeedInputs, Planned] | None = None
    record: list[Trial] = []
    plain = prompt(simulator)
    with one_thread():
        line = DelayAugmentedPlant(simulator, task.period, task.samples - 1)
        for number, (rows, margin) in enumerate(tries, start=1):
            rng = np.random.default_rng([seed, number])
            ground = grounded(task, plain, margin=margin, rng=rng)
            guesses = [swung(ground, rows, KEEP, rng)]
            if ground.plant.model.nu >= ground.plant.model.nv:
                guesses.append(led(ground, KEEP))
            if old is not None:
                guesses.append(recalled(ground, plain, old, rows=32, keep=KEEP, rng=rng))
            plan = sifted(ground, joined(guesses), keep=KEEP, most=MOST).rows(np.zeros(1, int))
            result = _fed(ground, line, led_late(ground, line, plan), bodies, [seed, number])
            best = (ground, result) if best is None or result.score < best[1].score else best
            loss, success = best[1].loss, best[1].success
            spent = time.monotonic() - began
            record.append(Trial(number=number, loss=loss, success=success, seconds=spent))
            if success >= SURE:
                break
        if best is None:
            raise SearchError(
                "it was given no try to search in",
                where=f"a late plan for {task.robot.name}",
                fix="give one try or more",
            )
        return concluded(
            Problem(task=task, simulator=simulator),
            track_of(*best),
            tuple(record),
            seed=seed,
            what="the best led plan",
            hint="its commands may come too late for what it is to hold",
        )


def _fed(
    ground: SeedInputs,
    line: DelayAugmentedPlant,
    plan: Trajectories,
    bodies: Sequence[Simulator],
    seed: list[int],
) -> Planned:
    """Return a led plan with the feedback that does best in noisy runs of late bodies."""
    near = _near(ground, line, plan, line.arriving(plan.command))
    best: Planned | None = None
    for kind in KINDS:
        trial = Planned(plan=plan, gain=filtered(ground, near, *kind)[0], loss=0.0, success=0.0)
        policy = track_of(ground, trial)
        scores = [
            evaluate(
                ground.cost.task,
                policy,
                body,
                rng=np.random.default_rng([*seed, at]),
                rows=-(-RUNS // len(bodies)),
            )
            for at, body in enumerate(bodies)
        ]
        trial = replace(
            trial,
            loss=float(np.mean([each.mean for each in scores])),
            success=float(np.mean([each.share for each in scores])),
        )
        if best is None or trial.score < best.score:
            best = trial
    if best is None:
        raise SearchError("no feedback", where="a late plan", fix="give kinds of feedback")
    return best
