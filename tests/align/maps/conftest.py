"""A pendulum in a formula, and the same pendulum in a disguise that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.maps.body_map import MapData
from morph.alignment.samples import Pairs, Transitions

LEVEL = np.array([False, False])


def swing(x: Array, u: Array) -> Array:
    """A pendulum of 1 m that stands up, with some friction, over 50 ms in five steps."""
    angle, rate = x[:, 0], x[:, 1]
    for _ in range(5):
        rate = rate + 0.01 * (9.81 * np.sin(angle) - 0.3 * rate + 4.0 * u[:, 0])
        angle = angle + 0.01 * rate
    return np.stack([angle, rate], axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class Planted:
    """What is given, and the true states and commands of rows that no map has seen."""

    given: MapData
    target: Array
    told: Array
    state: Array
    command: Array


def draw(rows: int, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    x = np.stack([rng.uniform(-1.5, 1.5, rows), 2.0 * rng.standard_normal(rows)], axis=1)
    u = rng.uniform(-1.0, 1.0, size=(rows, 1))
    return x, u, swing(x, u)


def wear(x: Array) -> Array:
    """The rate first, doubled; then the angle, flipped: y = (2 v, -q / 2) + 0.3."""
    return np.asarray(np.stack([2.0 * x[:, 1], -0.5 * x[:, 0]], axis=1) + 0.3)


@pytest.fixture(scope="session")
def planted() -> Planted:
    """A pendulum seen with its numbers swapped, scaled and one flipped; commands tripled."""
    rng = np.random.default_rng(100)
    x, u, after = draw(150, rng)
    source = Transitions(state=x, command=u, after=after, turns=LEVEL)
    x, u, after = draw(150, rng)
    target = Transitions(state=wear(x), command=3.0 * u, after=wear(after), turns=LEVEL)
    labelled, _, _ = draw(10, rng)
    unseen, told, _ = draw(200, rng)
    return Planted(
        given=MapData(
            source=source,
            target=target,
            pairs=Pairs(source=labelled, target=wear(labelled)),
            step=swing,
            source_worth=lambda s: np.asarray(s[:, 0] ** 2),
            target_worth=lambda s: np.asarray((2.0 * (s[:, 1] - 0.3)) ** 2),
        ),
        target=wear(unseen),
        told=3.0 * told,
        state=unseen,
        command=told,
    )
