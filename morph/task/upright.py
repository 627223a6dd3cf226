"""How well a body balances, 0 to 1: the same measure for every body that can fall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.sim.start import started
from morph.task.moved import Moved
from morph.task.task import Task

LEAN = 0.25
"""Tilt of the centre of mass over what carries it that costs two fifths of the score, rad."""

FALLEN = 0.8
"""Tilt from which a body has fallen: nothing after it counts, rad."""

STRAY = 1.0
"""How far what carries it may go and still score three fifths, m."""

AWAY = 3.0
"""How far away it counts as lost: nothing after it counts, m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Upright:
    """The mean over time of exp(-(tilt / LEAN)^2 / 2 - (place / STRAY)^2 / 2).

    The tilt is that of the line from the carrier's origin to the centre of mass against where it
    points at rest, in both directions of the horizon. The place is where the carrier is, and
    counts only if a motor moves it. From the moment a body fell or is lost every sample is 0.
    """

    carriers: tuple[str, ...]
    """The links that carry the body: a cart, a board, two feet."""
    rest: tuple[float, float, float]
    """From the carriers' middle to the centre of mass at rest, m."""
    placed: bool
    """Whether the place counts."""

    def tilt(self, moved: Moved) -> Array:
        """Return the tilts ahead and aside, rad, shape (..., samples, 2)."""
        middle, mass = _masses(moved, self.carriers)
        off = mass - middle
        # A body that hangs upside down has tilted by more than a right angle.
        angle = np.arctan2(off[..., :2] - np.array(self.rest[:2]), off[..., 2:])
        return np.asarray(angle)

    def middle(self, moved: Moved) -> Array:
        """Return where the carriers' middle is, m, shape (..., samples, 3)."""
        return _masses(moved, self.carriers)[0]

    def place(self, moved: Moved) -> Array:
        """Return how far the carriers' middle is from where it was at first, m, (..., samples)."""
        middle = self.middle(moved)
        gone = middle[..., :2] - middle[..., :1, :2]
        return np.asarray(np.sqrt(np.square(gone).sum(axis=-1)))

    def reward(self, moved: Moved) -> Array:
        """Return the score of every sample, shape (..., samples)."""
        tilt = np.sqrt(np.square(self.tilt(moved)).sum(axis=-1))
        place = self.place(moved) if self.placed else np.zeros_like(tilt)
        with np.errstate(invalid="ignore"):
            up = (tilt < FALLEN) & (place < AWAY)
            good = np.exp(-0.5 * (tilt / LEAN) ** 2 - 0.5 * (place / STRAY) ** 2)
        alive = np.logical_and.accumulate(up, axis=-1)
        return np.where(alive, good, 0.0)

    def score(self, moved: Moved) -> Array:
        """Return the score of every run, 0 to 1, shape (...,); one that is unstable has 0."""
        score = self.reward(moved).mean(axis=-1)
        return np.asarray(score if moved.stable is None else np.where(moved.stable, score, 0.0))


def upright(task: Task, *, carriers: tuple[str, ...] = ()) -> Upright:
    """Return the score of balancing for a task whose start names where the body stands.

    Args:
        task: The task.
        carriers: The links that carry the body; the link of the first slide if none is named,
            else the link that the first joint turns.

    Raises:
        TaskError: The body has no joint, or nothing that its carriers would carry.
    """
    robot = task.robot
    model: Any = spec_of(robot).compile()
    if not robot.joints:
        raise TaskError(
            "it has no joint", where=f"robot {robot.name}", fix="give a body that moves"
        )
    slides = [joint for joint in robot.joints if joint.kind == "slide"]
    named = carriers or ((slides or list(robot.joints))[0].link,)
    driven = set(robot.driven)
    q, _ = started(robot, model, task.start.position, {})
    moved = Moved(
        robot=robot,
        model=model,
        time=np.zeros(1),
        position=q[None, None],
        velocity=np.zeros((1, 1, model.nv)),
        command=np.zeros((1, 1, model.nu)),
    )
    held = {model.body(name).id for name in named}
    if not sum(mass for at, mass in enumerate(model.body_mass) if at not in held) > 0.0:
        raise TaskError(
            f"nothing with a mass stands on {', '.join(named)}",
            where=f"robot {robot.name}",
            fix="give a body of two links or more that have a mass",
        )
    middle, mass = _masses(moved, named)
    x, y, z = (mass - middle)[0, 0]
    placed = any(joint.link in named and joint.name in driven for joint in slides)
    return Upright(carriers=named, rest=(float(x), float(y), float(z)), placed=placed)


def _masses(moved: Moved, carriers: tuple[str, ...]) -> tuple[Array, Array]:
    """Return the carriers' middle and the centre of mass of the rest, (..., samples, 3) both."""
    model = moved.model
    held = [model.body(name).id for name in carriers]
    middle = np.mean([moved.pose(body).position for body in held], axis=0)
    mass = model.body_mass.copy()
    mass[held] = 0.0
    com = np.zeros_like(middle)
    for body in np.flatnonzero(mass):
        pose = moved.pose(int(body))
        com += mass[body] * (pose.position + pose.rotation @ model.body_ipos[body])
    return middle, com / mass.sum()
