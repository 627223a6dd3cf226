"""Random articulated bodies in a fluid, and bodies with limbs, of a given number of links."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.fluid.numbers import (
    ADDED,
    CENTRE,
    DISPLACED,
    MARK,
    QUADRATIC,
    SCALE,
    SIGNATURE,
    WIDTH,
    write_numbers,
)
from morph.physics.fluid.settle import settle
from morph.physics.fluid.tensor import ellipsoid_tensor

LIMB = 3
"""Links of a limb."""

DENSITY = 1000.0
"""Of the fluid and of the bodies, kg/m3."""


def random_tree(bodies: int, rng: np.random.Generator, *, step: float) -> mujoco.MjModel:
    """Return a floating tree of ellipsoids on hinges, neutral in its fluid, without drag.

    Each link is an ellipsoid of the fluid's density with Lamb's added mass; its centre of
    buoyancy lies up to a tenth of its size from its middle.
    """
    spec = _spec(step, mujoco.mjtIntegrator.mjINT_RK4)
    held = [spec.worldbody]
    for at in range(bodies):
        parent = held[int(rng.integers(1, at + 1))] if at else held[0]
        radii = np.sort(rng.uniform(0.05, 0.15, 3))[::-1]
        body = _link(spec, parent, f"link_{at}", radii, rng.uniform(-0.25, 0.25, 3))
        if at:
            axis = rng.normal(size=3)
            body.add_joint(axis=axis / np.linalg.norm(axis), pos=rng.uniform(-0.1, 0.1, 3))
        else:
            body.add_freejoint()
        _wet(spec, body.name, radii, offset=rng.uniform(-0.1, 0.1, 3) * radii.min(), drag=0.0)
        held.append(body)
    return settle(spec.compile())


def limbed(bodies: int, *, wet: bool, step: float = 0.005) -> mujoco.MjModel:
    """Return a floating body with limbs of three links each, the last one maybe shorter.

    A limb's depth does not grow with their number, as that of a chain would: the inertia of a
    chain has an entry for every pair of its joints, in the fluid or out of it.
    """
    spec = _spec(step, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    radii = np.array([0.1, 0.04, 0.04])
    root = link = _link(spec, spec.worldbody, "link_0", radii, np.zeros(3))
    root.add_freejoint()
    for at in range(1, bodies):
        parent = root if at % LIMB == 1 else link
        link = _link(spec, parent, f"link_{at}", radii, np.array([0.22, 0.0, 0.0]))
        link.add_joint(axis=(0, at % 2, 1 - at % 2), pos=(-0.11, 0, 0), damping=0.05)
    for at in range(bodies if wet else 0):
        _wet(spec, f"link_{at}", radii, offset=np.zeros(3), drag=1.0)
    return settle(spec.compile())


def _spec(step: float, integrator: mujoco.mjtIntegrator) -> Any:
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.integrator = step, integrator
    return spec


def _link(spec: Any, parent: Any, name: str, radii: Array, place: Array) -> Any:
    body = parent.add_body(name=name, pos=place)
    ellipsoid = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    body.add_geom(type=ellipsoid, size=radii, density=DENSITY, contype=0, conaffinity=0)
    return body


def _wet(spec: Any, name: str, radii: Array, *, offset: Array, drag: float) -> None:
    tensor = ellipsoid_tensor(*(float(radius) for radius in radii))
    numbers = np.zeros(WIDTH)
    numbers[MARK], numbers[SCALE] = SIGNATURE, 1.0
    numbers[ADDED] = DENSITY * tensor.matrix[np.triu_indices(6)]
    numbers[DISPLACED], numbers[CENTRE] = DENSITY * tensor.volume, offset
    numbers[QUADRATIC] = drag * np.repeat([5.0, 0.01], 3)
    write_numbers(spec, name, numbers.tolist())
