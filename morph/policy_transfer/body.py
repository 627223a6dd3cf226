"""A body that balances, as arrays about its state of rest: what maps and hops work on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.search.regulator.rest import Rest, off_rest, rest
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import moved_by
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task
from morph.task.upright import LEAN, STRAY, Upright, upright

STEP = 1e-5
"""Distance of a finite difference, in the state's units."""

Law = Callable[[Array, Array], Array]
"""From states about rest, (m, n), and the time, s, (m,), to commands about rest, (m, nu)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A body with its task: x = (position, velocity) - rest, u = command - what holds it there."""

    task: Task
    """What it is to do, where it begins and how long each command is held."""
    plant: Plant
    """The body, one control period after another."""
    still: Rest
    """Where it rests."""
    upright: Upright
    """How well it balances."""
    sight: Array | None = None
    """What laws and learners see of a state x about rest, sight @ x, shape (n, 2 nv); x if none."""

    together: Array | None = None
    """What actuators are told for each command of a law, (actuators, nu); one each if none."""

    dear: float = 1.0
    """What effort costs against the usual, fixed beforehand for every method alike."""

    @property
    def size(self) -> int:
        """How many numbers of a state are seen."""
        return 2 * int(self.plant.model.nv) if self.sight is None else len(self.sight)

    def seen(self, state: Array) -> Array:
        """Return what is seen of states about rest, shape (..., n)."""
        if self.sight is None:
            return state
        # Not by BLAS, whose rounding depends on the row: one reading must be one number.
        return np.asarray(np.einsum("ij,...j->...i", self.sight, state))

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and greatest commands about rest, shape (nu,) both."""
        low, high = self.plant.low - self.still.command, self.plant.high - self.still.command
        if self.together is None:
            return low, high
        # Of actuators that are told as one, the one with the least room bounds them all.
        share = self.together
        with np.errstate(divide="ignore", invalid="ignore"):
            least = np.where(share > 0.0, low[:, None], high[:, None]) / share
            most = np.where(share > 0.0, high[:, None], low[:, None]) / share
        apart = share == 0.0
        return (
            np.where(apart, -np.inf, least).max(axis=0),
            np.where(apart, np.inf, most).min(axis=0),
        )

    def _told(self, command: Array) -> Array:
        """Return what actuators are told, (m, actuators), for commands about rest, (m, nu)."""
        each = command if self.together is None else command @ self.together.T
        return np.clip(each + self.still.command, self.plant.low, self.plant.high)

    def state(self, position: Array, velocity: Array) -> Array:
        """Return states about rest, shape (..., n)."""
        return off_rest(self.plant, self.still, position, velocity)

    def place(self, state: Array) -> tuple[Array, Array]:
        """Return MuJoCo's positions and velocities of states about rest (m, n)."""
        nv = self.plant.model.nv
        q = moved_by(self.plant.model, self.still.position, state[:, :nv])
        return q, state[:, nv:] + self.still.velocity

    def step(self, state: Array, command: Array) -> Array:
        """Return the states (m, n) one control period after states under commands (m, nu)."""
        q, v = self.place(state)
        return self.state(*self.plant.advance(q, v, self._told(command)))

    @cached_property
    def linear(self) -> tuple[Array, Array]:
        """A and B of x' = A x + B u at rest, x whole: the truth, only for an oracle to look at."""
        return linearise(self.plant, self.still.position, self.still.velocity, self.still.command)

    @cached_property
    def outcome(self) -> Array:
        """What the task looks at, z = C x of what is seen, to first order, shape (numbers, n).

        Tilts over LEAN, places over STRAY, and their rates a fifth of a second ahead: the score
        of the task is exp(-|z|^2 / 2) of the first half.
        """
        nv = self.plant.model.nv
        move = np.concatenate([STEP * np.eye(nv), -STEP * np.eye(nv)])
        q, _ = self.place(np.concatenate([move, np.zeros_like(move)], axis=1))
        seen = self._seen(q)
        slope = (seen[:nv] - seen[nv:]).T / (2.0 * STEP)
        slope = slope[np.abs(slope).max(axis=1) > 1e-6]
        none = np.zeros_like(slope)
        whole = np.block([[slope, none], [none, 0.2 * slope]])
        if self.sight is None:
            return whole
        # What is seen explains other numbers of the task in part; these are left out.
        seen = whole @ np.linalg.pinv(self.sight)
        observed = np.abs(seen @ self.sight - whole).max(axis=1) < 1e-6 * np.abs(whole).max(axis=1)
        return np.asarray(seen[observed])

    def _seen(self, q: Array) -> Array:
        moved = self._moved(q[:, None], np.zeros((len(q), 1, self.plant.model.nv)))
        tilt = self.upright.tilt(moved)[:, 0] / LEAN
        if not self.upright.placed:
            return tilt
        return np.concatenate([tilt, self.upright.middle(moved)[:, 0, :2] / STRAY], axis=1)

    def _moved(self, q: Array, v: Array) -> Moved:
        return Moved(
            robot=self.task.robot,
            model=self.plant.model,
            time=self.task.period * np.arange(q.shape[1], dtype=float),
            position=q,
            velocity=v,
            command=np.zeros((*q.shape[:2], self.plant.model.nu)),
        )

    def transitions(
        self,
        count: int,
        rng: np.random.Generator,
        *,
        share: float = 0.1,
        noise: float | None = None,
    ) -> Transitions:
        """Return so many transitions of random commands about rest, seen through noise.

        Each run begins by chance of the start without its push, and ends, for a new one to
        begin, when it has tilted half as far as the score bears. Every command is drawn anew.

        Args:
            count: How many.
            rng: The chance of starts, commands and noise.
            share: Standard deviation of the commands, in half ranges.
            noise: Of every observation; the task's if none is given.
        """
        level = self.task.noise if noise is None else noise
        low, high = self.bounds
        half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
        rows: list[tuple[Array, Array, Array]] = []
        x = self._begun(rng)
        for _ in range(count):
            u = np.clip(share * half * rng.standard_normal(len(half)), low, high)
            after = self.step(x[None], u[None])[0]
            rows.append((x, u, after))
            lost = (
                not np.isfinite(after).all() or np.abs(self.outcome @ self.seen(after)).max() > 1.0
            )
            x = self._begun(rng) if lost else after
        state, command, after = (np.array(each) for each in zip(*rows, strict=True))
        seen = level * rng.standard_normal((2, *state.shape))
        # What follows one transition is where the next begins: one reading, with one noise.
        follows = np.flatnonzero((state[1:] == after[:-1]).all(axis=1))
        seen[0, follows + 1] = seen[1, follows]
        return Transitions(
            state=self.seen(state + seen[0]),
            command=command,
            after=self.seen(np.nan_to_num(after) + seen[1]),
            turns=np.zeros(self.size, dtype=bool),
        )

    def _begun(self, rng: np.random.Generator) -> Array:
        start = replace(self.task.start, push=None)
        q, v = start.sample(self.task.robot, self.plant.model, 1, rng)
        return np.asarray(self.state(q, v)[0])

    def run(self, law: Law, *, rows: int, rng: np.random.Generator) -> Moved:
        """Return runs of the task under a law that sees states about rest through noise."""
        model = self.plant.model
        q, v = self.task.start.sample(self.task.robot, model, rows, rng)

        def act(position: Array, velocity: Array, time: float) -> Array:
            x = self.state(position, velocity)
            x = x + self.task.noise * rng.standard_normal(x.shape)
            return self._told(np.nan_to_num(law(self.seen(x), np.full(len(x), time))))

        return run(self.task, self.plant.simulator, act, q, v)

    def score(self, law: Law, *, rows: int = 20, seed: int = 0) -> float:
        """Return the mean score of the task under a law, 0 to 1."""
        with np.errstate(over="ignore", invalid="ignore"):
            moved = self.run(law, rows=rows, rng=np.random.default_rng([seed, 7]))
        return float(self.upright.score(moved).mean())


def body(task: Task, *, carriers: tuple[str, ...] = (), still: Rest | None = None) -> Body:
    """Return a body with a task, at rest where the task's goals are met.

    Args:
        task: The task, `balance` of a robot.
        carriers: The links that carry it, as in `upright`.
        still: Where it rests; sought if it is not given.

    Raises:
        SearchError: It can rest nowhere.
    """
    plant = Plant(task.simulator(), task.period)
    result = rest(task, plant, np.random.default_rng(0)) if still is None else still
    return Body(task=task, plant=plant, still=result, upright=upright(task, carriers=carriers))


def linear_law(gain: Array, shift: Array | float = 0.0) -> Law:
    """Return the law u = gain x + shift."""
    return lambda x, time: x @ gain.T + shift


def still_law(commands: int) -> Law:
    """Return the law that holds still."""
    return lambda x, time: np.zeros((len(x), commands))
