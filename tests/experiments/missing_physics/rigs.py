"""A mass on a rail and a rod on a hinge, put under laws of the benchmark."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from experiments.missing_physics.plant import Array, Plant, plant_of
from experiments.missing_physics.simulate import GRID, Motion, Run, moving_state, simulate
from experiments.missing_physics.suites import LAWS

BY_NAME = {law.name: law for law in LAWS}
MASS = 2.0
G = 9.80665


def cart(*, drive: float = 1.0) -> Plant:
    """Return 2 kg on a rail along x."""
    plant = plant_of(
        parent=np.array([-1]), slide=np.array([1]), rotation=np.eye(3)[None],
        origin=np.zeros((1, 3)), axis=np.array([[1.0, 0, 0]]), mass=np.array([MASS]),
        com=np.array([[0.1, 0.0, 0.0]]), inertia=0.01 * np.eye(3)[None],
        gravity=np.array([0, 0, -G]),
    )  # fmt: skip
    return plant.with_joint(0, drive=drive)


def rod() -> Plant:
    """Return a hinge about y with 2 kg at 0.5 m along x: level at q = 0."""
    plant = plant_of(
        parent=np.array([-1]), slide=np.array([0]), rotation=np.eye(3)[None],
        origin=np.zeros((1, 3)), axis=np.array([[0, 1.0, 0]]), mass=np.array([MASS]),
        com=np.array([[0.5, 0.0, 0.0]]), inertia=0.01 * np.eye(3)[None],
        gravity=np.array([0, 0, -G]),
    )  # fmt: skip
    return plant.with_joint(0, drive=1.0)


def put(plant: Plant, name: str, **figures: float) -> Plant:
    return BY_NAME[name].apply(plant, 0, figures)


def go(
    plant: Plant, force: Callable[[Array], Array] | float = 0.0, *, v: float = 0.0, q: float = 0.0,
    seconds: float = 0.5, finer: int = 2,
) -> Motion:  # fmt: skip
    """Return the motion under a command that changes every millisecond."""
    grids = round(seconds / GRID)
    ticks = np.arange(0, grids, 4)
    feed = force(ticks * GRID) if callable(force) else np.full(len(ticks), force)
    none = np.zeros((len(ticks), 1))
    run = Run(ticks=ticks, feed=feed[:, None], reference=np.full_like(none, np.nan), noise=none,
              start=np.array([q]), grids=grids)  # fmt: skip
    return simulate(plant, run, state=moving_state(plant, np.array([q]), np.array([v])),
                    finer=finer)  # fmt: skip


def pull(motion: Motion, at: float) -> float:
    """Return the force at a time, from the change of velocity over two steps."""
    i = round(at / motion.step)
    return float(MASS * (motion.v[i + 1, 0] - motion.v[i - 1, 0]) / (2 * motion.step))
