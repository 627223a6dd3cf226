"""How a body moved: where its links are in every picture, and what else is told of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.times import nearest_samples
from morph.arrays import Array

RATE = 60.0
"""Pictures a second."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionFrames:
    """The pictures of one motion, `RATE` a second; beyond the last one it rests there."""

    position: Array
    """Where each link is in its body's world, m, shape (pictures, links, 3), the world first."""
    turn: Array
    """Unit quaternions, w first, shape (pictures, links, 4)."""
    arrows: Mapping[str, Array] = field(default_factory=dict)
    """Arrows by their kind (`contact`, `fluid`, `torque`, `wrench`, `remaining`), in the body's
    world, m: from and to, shape (pictures, arrows, 2, 3); one that is not there is NaN."""
    heat: Array | None = None
    """How strongly each link is coloured, 0 to 1, shape (pictures, links); None for not at all."""
    series: Mapping[str, Array] = field(default_factory=dict)
    """Numbers that are told while it moves, by name with unit: shape (pictures,)."""
    marks: Array | None = None
    """A marker in each picture, m, shape (pictures, 3), NaN for none; None for none at all."""

    lost: float | None = field(default=None, init=False)
    """When its numbers ceased to be finite, s, as in a run that blew up; there it rests."""

    def __post_init__(self) -> None:
        """Hold the last pose that can be drawn."""
        sound = np.isfinite(self.position).all(axis=(1, 2)) & np.isfinite(self.turn).all(
            axis=(1, 2)
        )
        if sound.all():
            return
        kept = np.maximum.accumulate(np.where(sound, np.arange(self.pictures), -1))
        position, turn = self.position[kept], self.turn[kept]
        # Before the first sound picture there is none to hold.
        position[kept < 0], turn[kept < 0] = 0.0, (1.0, 0.0, 0.0, 0.0)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "turn", turn)
        object.__setattr__(self, "lost", float(np.argmin(sound)) / RATE)

    @property
    def pictures(self) -> int:
        """How many pictures there are."""
        return len(self.position)

    @property
    def seconds(self) -> float:
        """How long it is, s."""
        return (self.pictures - 1) / RATE

    def at(self, time: float) -> int:
        """Return which picture is shown at a time, s."""
        return min(self.pictures - 1, max(0, int(time * RATE + 1e-6)))


def motion(model: Any, times: Array, positions: Array) -> MotionFrames:
    """Return a motion from a run.

    Args:
        model: The `mujoco.MjModel` that ran.
        times: When, s, rising, shape (samples,).
        positions: Its `qpos` then, shape (samples, nq).
    """
    return posed(model, positions[nearest_samples(times, RATE)])


def posed(model: Any, positions: Array) -> MotionFrames:
    """Return a motion from the poses in its pictures, `qpos` of shape (pictures, nq)."""
    data = mujoco.MjData(model)
    position = np.empty((len(positions), model.nbody, 3))
    turn = np.empty((len(positions), model.nbody, 4))
    for at, pose in enumerate(positions):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        position[at], turn[at] = data.xpos, data.xquat
    return MotionFrames(position=position, turn=turn)
