"""Rollouts of an adjusted policy in the simulator, with the commands that the target would need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.alignment.adjust import Adjustment
from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.adjusted import Adjusted
from morph.policy.observing import Observer
from morph.policy.policy import Observation, Policy
from morph.policy_transfer.adjustment.adjust import applied
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.evaluate import Score, check_period
from morph.search.plan.policy import columns
from morph.search.trajectory.plant import Stepped
from morph.task.moved import Moved

STEPS = 6
"""Most steps of Newton's method by which a command is solved for."""

ENOUGH = 1e-3
"""Error of the command at which they end, in halves of its range."""

FLAT = 0.05
"""Determinant of the slope below which a step of Newton's is not made."""

FAILURE = 10.0
"""What a run that fails counts beyond its loss, when policies are compared, in mean losses."""


class Pretended(Stepped):
    """A source that is told v where the target is told u, v + d(x, v) = u.

    An adjustment d says which command u makes the target do what v makes the source do. Read
    backwards it says what the target does under u, as far as any command of the source could:
    among others that a command at its bound does less there.

    Args:
        source: The source.
        found: The adjustment.
        observation: What the policy saw for which it was made: every number of a state.

    Raises:
        TransferError: What is seen is late.
        SearchError: A number of a state is not seen.
    """

    def __init__(
        self, source: SimulatedTask, result: Adjustment, observation: tuple[Observation, ...]
    ) -> None:
        if any(each.delay_s > 0.0 for each in observation):
            raise TransferError(
                "the adjustment was made of observations that are late",
                where=f"what {source.task.robot.name} is taken to do",
                fix="adjust a policy that sees every position and every velocity as it is now",
            )
        self.source, self.found, self.model = source, result, source.plant.model
        channels = tuple(each.channel for each in observation)
        self._columns = columns(source.task.robot, self.model, channels)
        self._offset = np.array([each.offset for each in observation])
        self._scale = np.array([each.scale for each in observation])

    def felt(self, state: Array, command: Array) -> Array:
        """Return v of v + d(x, v) = u, by Newton's method; shape (m, nu)."""
        plant = self.source.plant
        state = (state[:, self._columns] - self._offset) / self._scale
        half = 0.5 * (plant.high - plant.low)
        low, high = plant.low - 2.0 * half, plant.high + 2.0 * half
        v = np.clip(command - self.found(state, command), low, high)
        for _ in range(STEPS):
            added, slope = self.found.sloped(state, v)
            off = v + added - command
            J = np.eye(len(half)) + slope
            # Far from all data the law may fold over: there no step is longer than the range.
            flat = np.abs(np.linalg.det(J)) < FLAT
            J[flat] = np.eye(len(half))
            step = np.linalg.solve(J, off[..., None])[..., 0]
            v = np.clip(v - np.clip(step, -half, half), low, high)
            if (np.abs(off) <= ENOUGH * half).all():
                break
        return np.asarray(v)

    def advance(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        """Return positions and velocities one control period later."""
        plant = self.source.plant
        commanded = np.clip(command, plant.low, plant.high)
        state = np.concatenate([position, velocity], axis=1)
        return _unclamped(self.source, position, velocity, self.felt(state, commanded))


def _unclamped(source: SimulatedTask, q: Array, v: Array, u: Array) -> tuple[Array, Array]:
    """Return what commands beyond a source's bounds would do: MuJoCo would clamp them."""
    plant = source.plant
    inside = np.clip(u, plant.low, plant.high)
    at_q, at_v = plant.advance(q, v, inside)
    over = u - inside
    if not over.any():
        return at_q, at_v
    # A state moves by an affine function of a command, nearly: what one goes beyond its bound is
    # what it does from half its range within, as much further.
    part = 0.5 * (plant.high - plant.low) * 0.5
    more_q, more_v = np.zeros_like(at_q), np.zeros_like(at_v)
    for actuator, size in enumerate(part):
        other = inside.copy()
        other[:, actuator] -= np.sign(over[:, actuator]) * size
        back_q, back_v = plant.advance(q, v, other)
        share = np.abs(over[:, actuator : actuator + 1]) / size
        more_q += share * (at_q - back_q)
        more_v += share * (at_v - back_v)
    return at_q + more_q, at_v + more_v


def foreseen(
    source: SimulatedTask, stepped: Stepped, policy: Policy, *, rows: int, rng: np.random.Generator
) -> Score:
    """Return how a policy does in noisy runs of what the target is taken to do."""
    task, model = source.task, source.plant.model
    check_period(policy, task)
    q, v = task.start.sample(task.robot, model, rows, rng)
    observer = Observer(policy, task.robot, model, rows, rng=rng, noise=task.noise)
    qs, vs, us = [q], [v], []
    for at in range(task.samples - 1):
        us.append(policy.act(observer.see(q, v), np.full(rows, at * task.period)))
        q, v = stepped.advance(q, v, us[-1])
        qs.append(q)
        vs.append(v)
    position, velocity = np.stack(qs, axis=1), np.stack(vs, axis=1)
    fine = np.asarray(np.isfinite(position).all((1, 2)) & np.isfinite(velocity).all((1, 2)))
    moved = Moved(
        robot=task.robot,
        model=model,
        time=np.asarray(task.period * np.arange(task.samples), dtype=float),
        position=np.where(fine[:, None, None], position, model.qpos0),
        velocity=np.where(fine[:, None, None], velocity, 0.0),
        command=np.stack([*us, us[-1]], axis=1),
        stable=fine,
    )
    return Score(loss=task.loss(moved), success=task.succeeded(moved))


def most_promising(
    source: SimulatedTask,
    result: Adjustment,
    policies: Sequence[Policy],
    *,
    rng: np.random.Generator,
    rows: int = 32,
) -> tuple[Adjusted, tuple[Score, ...]]:
    """Return the policy that promises most once adjusted, and how each is foreseen to do.

    Policies of the source that ask for all that its bounds permit leave an adjustment no room;
    of several, the best that the target can follow is taken. Each is tried in the same noise.

    Args:
        source: Where the policies were made.
        result: The adjustment, made from runs under any of them.
        policies: Policies of the source, the best first.
        rng: Chance.
        rows: Noisy runs by which each is judged.

    Raises:
        TransferError: There is no policy.
    """
    if not policies:
        raise TransferError(
            "there is no policy to choose",
            where=f"an adjustment for {source.task.robot.name}",
            fix="give one policy or more",
        )
    stepped, chance = Pretended(source, result, policies[0].observation), int(rng.integers(2**32))
    many = [applied(result, policy) for policy in policies]
    scores = tuple(
        foreseen(source, stepped, each, rows=rows, rng=np.random.default_rng(chance))
        for each in many
    )
    return many[int(np.argmin([judged(score) for score in scores]))], scores


def judged(score: Score) -> float:
    """Return what policies are compared by: the mean loss, and failures on top."""
    return score.mean * (1.0 + FAILURE * (1.0 - score.share))
