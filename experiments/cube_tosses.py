"""The real tosses of ContactNets' cube: read, simulated from their first samples, compared."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.data import DataError
from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.physics.effect import Effect
from morph.sim.rollout import Variant, rollout
from morph.sim.simulator import compiled

FOLDER = "contactnets_cube"
HALF = 0.0524
"""Half of the cube's width, m, the recordings' unit of length (their README)."""
RATE = 148.0
"""Samples a second (their README)."""
SUBSTEPS = 4
"""Steps a sample: 1.7 ms, which follows the softest and the hardest floor tried."""
DESCRIPTION = f"""<mujoco model="cube"><worldbody><body name="cube"><freejoint/>
<inertial pos="0 0 0" mass="0.37" diaginertia="0.00081 0.00081 0.00081"/>
<geom type="box" size="{HALF} {HALF} {HALF}"/></body></worldbody></mujoco>"""


def tosses(root: Path, numbers: Sequence[int]) -> list[Array]:
    """Return tosses in SI units, (samples, 13): position, quaternion w x y z, velocities.

    Raises:
        DataError: The recordings are not there, or are not what was used.
    """
    path = root / FOLDER / "tosses.npz"
    try:
        with np.load(path, allow_pickle=False) as held:
            raw = [np.asarray(held[str(number)], dtype=float) for number in numbers]
    except (OSError, KeyError, ValueError) as error:
        raise DataError(
            f"the tosses cannot be read: {error}",
            where=str(path),
            fix=f"run python -m experiments.data --set {FOLDER}, or put tosses.npz into {FOLDER} "
            "of the folder that MORPH_RECORDINGS names",
        ) from error
    unit = np.r_[np.full(3, HALF), np.ones(4), np.full(3, HALF), np.ones(3)]
    return [toss[:, :13] * unit for toss in raw]


def flights(variants: Sequence[Variant], real: Sequence[Array]) -> list[Array]:
    """Return each toss simulated from its first sample, (variants, samples, 7) each."""
    found: dict[int, Array] = {}
    # Tosses of about one length go together: in a batch all rows are as long.
    order = sorted(range(len(real)), key=lambda index: len(real[index]))
    for some in np.array_split(order, max(1, len(order) // 20)):
        starts = np.tile(np.array([real[index][0] for index in some]), (len(variants), 1))
        steps = SUBSTEPS * (max(len(real[index]) for index in some) - 1)
        which = np.repeat(np.arange(len(variants)), len(some))
        # A toss's linear velocity is in the world's frame, its angular in the cube's,
        # as MuJoCo has them.
        q, _ = rollout(
            variants, which, starts[:, :7], starts[:, 7:], np.zeros((len(which), steps, 0))
        )
        sampled = q[:, ::SUBSTEPS].reshape(len(variants), len(some), -1, 7)
        for slot, index in enumerate(some):
            found[int(index)] = sampled[:, slot, : len(real[index])]
    return [found[index] for index in range(len(real))]


def position_errors(simulated: Sequence[Array], real: Sequence[Array]) -> Array:
    """Return the mean distance of each toss, in widths of the cube, (variants, tosses)."""
    distance = [
        np.linalg.norm(flight[:, :, :3] - toss[:, :3], axis=2).mean(axis=1)
        for flight, toss in zip(simulated, real, strict=True)
    ]
    return np.stack(distance, axis=1) / (2.0 * HALF)


def rotation_errors(simulated: Sequence[Array], real: Sequence[Array]) -> Array:
    """Return the mean angle between the orientations of each toss, degrees."""
    angles = []
    for flight, toss in zip(simulated, real, strict=True):
        cosine = np.abs(np.einsum("vsi,si->vs", flight[:, :, 3:], toss[:, 3:7]))
        angles.append(np.degrees(2.0 * np.arccos(np.minimum(cosine, 1.0))).mean(axis=1))
    return np.stack(angles, axis=1)


def on(robot: Robot, effects: tuple[Effect, ...]) -> Variant:
    """Return the cube under effects, at the study's step."""
    return compiled(spec_of(robot, timestep=1.0 / (RATE * SUBSTEPS)), effects, robot)


def shuffled(simulated: Sequence[Array], real: Sequence[Array]) -> list[Array]:
    """Return for each toss the simulation of another, moved to its start and cut or held."""
    moved = []
    for index, toss in enumerate(real):
        other = simulated[(index + 1) % len(real)]
        whole = other[:, np.minimum(np.arange(len(toss)), other.shape[1] - 1)].copy()
        whole[:, :, :3] += toss[0, :3] - whole[:, :1, :3]
        moved.append(whole)
    return moved
