"""What bodies do under random commands from states far from rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.disguised.disguise import Disguise
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.body.load import load
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator

PERIOD = 0.05
"""How long a command is held, s."""

STEP = 0.01
"""Of the simulation, s: five times the shelf's, so that a study ends soon."""

RUN = 5
"""Transitions of one run, from one start."""

SHARE = 0.4
"""Greatest command, in half ranges."""

WIDE = 1.7
"""Greatest number of a disguised command before it is bent: its deviation is then about 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Wild:
    """A body of the shelf that is moved through much of what it can do."""

    name: str
    """On the shelf."""
    plant: Plant
    """Its simulation."""
    place: Array
    """Positions are drawn from +- this, shape (nv,)."""
    pace: Array
    """And velocities from normal numbers of this deviation, shape (nv,)."""

    @property
    def joints(self) -> int:
        """How many there are."""
        return int(self.plant.model.nv)

    def step(self, state: Array, command: Array) -> Array:
        """Return the states (m, 2 nv) that follow after a period."""
        nv = self.joints
        q, v = self.plant.advance(state[:, :nv], state[:, nv:], command)
        return np.concatenate([q, v], axis=1)

    def starts(self, count: int, rng: np.random.Generator) -> Array:
        """Return states by chance, shape (count, 2 nv)."""
        q = rng.uniform(-self.place, self.place, size=(count, self.joints))
        return np.concatenate([q, self.pace * rng.standard_normal((count, self.joints))], axis=1)

    def commands(self, count: int, rng: np.random.Generator) -> Array:
        """Return commands by chance, shape (count, nu)."""
        high = SHARE * self.plant.high
        return np.asarray(rng.uniform(-high, high, size=(count, len(high))))

    def runs(self, commands: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return states (runs, steps + 1, n) under commands (runs, steps, nu), and the commands."""
        x = [self.starts(len(commands), rng)]
        for step in range(commands.shape[1]):
            x.append(self.step(x[-1], commands[:, step]))
        return np.stack(x, axis=1), commands


def wild(name: str) -> Wild:
    """Return a body of the shelf with a range of states in which its joints do not meet limits."""
    plant = Plant(Simulator(load(name), step=STEP), PERIOD)
    model: Any = plant.model
    slides = model.jnt_type == 2
    place = np.where(slides, 1.0, 1.2)
    reach = 0.6 * np.abs(model.jnt_range).min(axis=1)
    place = np.where(model.jnt_limited, np.minimum(place, reach), place)
    return Wild(name=name, plant=plant, place=place, pace=np.full(model.nv, 1.5))


def transitions(seen: Array, commands: Array) -> Transitions:
    """Return runs (runs, steps + 1, n) as transitions; each state between two is read once."""
    n = seen.shape[-1]
    return Transitions(
        state=seen[:, :-1].reshape(-1, n),
        command=commands.reshape(-1, commands.shape[-1]),
        after=seen[:, 1:].reshape(-1, n),
        turns=np.zeros(n, dtype=bool),
    )


def bare(body: Wild, count: int, noise: float, rng: np.random.Generator) -> Transitions:
    """Return what a body is seen to do as it is."""
    u = body.commands(count, rng)
    x, _ = body.runs(u.reshape(-1, RUN, u.shape[1]), rng)
    return transitions(x + noise * rng.standard_normal(x.shape), u)


def worn(
    body: Wild, hidden: Disguise, count: int, noise: float, rng: np.random.Generator
) -> tuple[Transitions, Array, Array]:
    """Return what a disguised body is seen to do, and its true states and commands.

    Noise is that of the body's own readings, in its own units, before they are disguised.
    """
    z = rng.uniform(-WIDE, WIDE, size=(count, len(hidden.commands.mix)))
    a = hidden.commands.bent(z)
    told = hidden.command(a)
    x, _ = body.runs(told.reshape(-1, RUN, told.shape[1]), rng)
    seen = hidden.states.worn(x + noise * rng.standard_normal(x.shape))
    return transitions(seen, a), x[:, :-1].reshape(count, -1), told
