"""What the fluid costs: steps of wet, dry and MuJoCo's own models, timed by turns."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch

from experiments.wet.trees import limbed
from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of
from morph.physics.fluid.settle import settle
from morph.physics.fluid.water import immersed
from morph.sim.simulator import compiled

STEP = 0.005
"""Seconds a step."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """One body in three fluids."""

    name: str
    """The body."""
    freedoms: int
    """Its degrees of freedom."""
    bodies: int
    """Its links."""
    over_dry: float
    """Time of a wet step by that of a dry one."""
    of_ellipsoid: float
    """Time of a step with MuJoCo's ellipsoid fluid by that of a wet one."""
    real_time: float
    """Simulated seconds in water by seconds, on one core."""


def cost(name: str, *, repeats: int, steps: int) -> Cost:
    """Return what water costs a body of the shelf, medians of ratios measured by turns."""
    dry, wet, ellipsoid = variants(name)
    told = by_turns([dry, wet, ellipsoid], repeats=repeats, steps=steps)
    return Cost(
        name=name,
        freedoms=dry.nv,
        bodies=dry.nbody - 1,
        over_dry=float(np.median(told[:, 1] / told[:, 0])),
        of_ellipsoid=float(np.median(told[:, 2] / told[:, 1])),
        real_time=float(np.median(STEP / told[:, 1])),
    )


def variants(name: str) -> tuple[Any, Any, Any]:
    """Return a body dry, in our water, and in MuJoCo's ellipsoid fluid, under implicitfast.

    MuJoCo's fluid has no buoyancy: none of the three has weight, so that they do much the same.
    """
    robot = load(name)
    spec = spec_of(robot, timestep=STEP)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_GRAVITY.value
    dry, ellipsoid = spec.copy(), spec.copy()
    ellipsoid.option.density, ellipsoid.option.viscosity = 1000.0, 1e-3
    for geom in ellipsoid.geoms:
        geom.fluid_ellipsoid = 1
    wet = compiled(spec, immersed(robot).effects, robot).model
    return dry.compile(), wet, ellipsoid.compile()


def by_turns(models: Sequence[Any], *, repeats: int, steps: int) -> Array:
    """Return the time of a step of each model, s, shape (repeats, models).

    The models run by turns, so that what else the machine does slows all alike.
    """
    runs = [_started(model) for model in models]
    told = np.empty((repeats, len(models)))
    for row in told:
        for at, (model, data) in enumerate(runs):
            began = time.perf_counter()
            mujoco.mj_step(model, data, steps)
            row[at] = (time.perf_counter() - began) / steps
            _start(model, data)
    return told


def growth(counts: Sequence[int], *, repeats: int, steps: int) -> tuple[Array, Array]:
    """Return the time of a dry and of a wet step of limbed bodies, s, each shape (counts,)."""
    dry, wet = [], []
    for bodies in counts:
        pair = [limbed(bodies, wet=wet_too, step=STEP) for wet_too in (False, True)]
        told = np.median(by_turns(pair, repeats=repeats, steps=steps), axis=0)
        dry.append(told[0])
        wet.append(told[1])
    return np.array(dry), np.array(wet)


def cores(name: str, *, rows: int, repeats: int, steps: int) -> float:
    """Return the throughput of a wet batch on two cores by that on one."""
    _, model, _ = variants(name)
    batches = [Batch(model, rows, threads) for threads in (1, 2)]
    for batch in batches:
        batch.step(nstep=steps)
    ratios = []
    for _ in range(repeats):
        told = []
        for batch in batches:
            began = time.perf_counter()
            batch.step(nstep=steps)
            told.append(time.perf_counter() - began)
        ratios.append(told[0] / told[1])
    return float(np.median(ratios))


def _started(model: Any) -> tuple[Any, Any]:
    data = mujoco.MjData(settle(model))
    _start(model, data)
    return model, data


def _start(model: Any, data: Any) -> None:
    mujoco.mj_resetData(model, data)
    data.qvel[:] = 0.1
    mujoco.mj_step(model, data, 5)
