"""Motion of a plant under commands, from a start or from any saved state."""

from __future__ import annotations

from ctypes import c_double
from dataclasses import dataclass, replace

import numpy as np

from experiments.concealed.compiled import library, pointer
from experiments.concealed.errors import BenchmarkError
from experiments.concealed.fields import STATE_ROW, STATES
from experiments.concealed.plant import Array, Plant

GRID = 2.5e-4
"""Ticks of loggers fall on multiples of this, s; the step of the integrator divides it."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run as planned: when the logger ticks, and what it sends."""

    ticks: Array
    """Multiples of `GRID` at which it reads and sends, from 0, shape (ticks,)."""
    feed: Array
    """Planned commands, N m, N, rad or m, shape (ticks, joints)."""
    reference: Array
    """Paths that a controller tracks; NaN where it only sends the plan. Same shape."""
    noise: Array
    """Noise of each reading before it is rounded. Same shape."""
    start: Array
    """Positions at rest from which it starts, shape (joints,)."""
    grids: int
    """Length in multiples of `GRID`."""

    @property
    def seconds(self) -> float:
        """Length, s."""
        return self.grids * GRID

    def widened(self, joints: int) -> Run:
        """Return the run for a plant with more joints, which nothing drives, or with fewer."""
        more = max(joints - self.feed.shape[1], 0)

        def wide(columns: Array) -> Array:
            return np.pad(columns, ((0, 0), (0, more)))[:, :joints]

        return replace(
            self, feed=wide(self.feed), reference=wide(self.reference), noise=wide(self.noise),
            start=np.pad(self.start, (0, more))[:joints],
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Motion:
    """What happened in a run."""

    q: Array
    """Positions at every step, shape (steps + 1, joints)."""
    v: Array
    """Velocities, same shape."""
    reading: Array
    """Position readings at the ticks, shape (ticks, joints)."""
    command: Array
    """Commands sent at the ticks, same shape."""
    saved: Array
    """States at the steps asked for, shape (saves, states, joints)."""
    step: float
    """Step, s."""

    def at(self, ticks: Array) -> tuple[Array, Array]:
        """Return positions and velocities at multiples of `GRID`, (ticks, joints) each."""
        every = round(GRID / self.step)
        return self.q[ticks * every], self.v[ticks * every]


def rest_state(plant: Plant, start: Array) -> Array:
    """Return the state at rest at a position, shape (states, joints).

    What lags, and how far rotors are from their links, follows from the first commands.
    """
    state = np.zeros((len(STATES), plant.count))
    state[STATE_ROW["q"]] = start
    state[[STATE_ROW["lag"], STATE_ROW["rotor_q"]]] = np.nan
    return state


def moving_state(plant: Plant, q: Array, v: Array) -> Array:
    """Return the state of motion at q and v without any memory, shape (states, joints)."""
    state = rest_state(plant, q)
    for name in ("v", "before", "rotor_v", "rotor_before"):
        state[STATE_ROW[name]] = v
    return state


def simulate(
    plant: Plant,
    run: Run,
    *,
    state: Array | None = None,
    first: int = 0,
    last: int | None = None,
    save: Array | None = None,
    finer: int = 1,
) -> Motion:
    """Return the motion of a plant in a run, or in a part of it.

    Args:
        plant: The plant.
        run: Commands; replayed as they are where no joint tracks.
        state: State at `first`; by default at rest at the run's start.
        first: First multiple of `GRID`.
        last: Last one; by default the run's end.
        save: Ascending multiples of `GRID` at which the whole state is kept.
        finer: Steps in each multiple of `GRID`.

    Raises:
        BenchmarkError: A velocity grows past 10^4 rad/s.
    """
    n = plant.count
    run = run.widened(n)
    last = run.grids if last is None else last
    state = np.array(rest_state(plant, run.start) if state is None else state, order="C")
    ticks = np.ascontiguousarray(run.ticks * finer, dtype=np.int32)
    feed, reference, noise = (
        np.ascontiguousarray(each, dtype=float) for each in (run.feed, run.reference, run.noise)
    )
    reading, command = np.zeros_like(feed), feed.copy()
    path = np.zeros((run.grids * finer + 1, 2, n))
    marks = np.ascontiguousarray(
        (np.array([], dtype=int) if save is None else save) * finer, dtype=np.int32
    )
    saved = np.zeros((len(marks), len(STATES), n))
    alive, arguments = plant.constants()
    reached = library().march(
        *arguments, pointer(state), int(first) * finer, int(last) * finer, c_double(GRID / finer),
        len(ticks), pointer(ticks), *(pointer(each) for each in (feed, reference, noise)),
        *(pointer(each) for each in (reading, command, path)),
        len(marks), pointer(marks), pointer(saved),
    )  # fmt: skip
    del alive
    if reached != last * finer:
        raise BenchmarkError(
            f"the motion diverged at {reached * GRID / finer:.3f} s",
            where="simulate",
            fix="draw a smaller effect or another case",
        )
    return Motion(
        q=path[:, 0], v=path[:, 1], reading=reading, command=command, saved=saved,
        step=GRID / finer,
    )  # fmt: skip
