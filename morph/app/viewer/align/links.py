"""Where on a body the numbers are that a map joins: names of readings and commands to links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.viewer.figure import Figure
from morph.arrays import Array
from morph.policy_transfer.body import Body
from morph.policy_transfer.parts import names_of

STRONG = 0.5
"""Share of a reading's greatest coefficient from which a joint counts to it."""


FEW = 2
"""Links of a group that are named."""


@dataclass(frozen=True, kw_only=True)
class LinkNames:
    """Names of a body's links by what its numbers are called."""

    states: Mapping[str, tuple[str, ...]]
    """By the names of its state."""
    commands: Mapping[str, tuple[str, ...]]
    """By the names of its commands."""


def parts_of(body: Body) -> LinkNames:
    """Return which links the numbers of a body are about."""
    names, model = names_of(body), body.plant.model
    half = body.size // 2
    seen = np.eye(half) if body.sight is None else body.sight[:half, : model.nv]
    states: dict[str, tuple[str, ...]] = {}
    for at, row in enumerate(np.abs(seen)):
        which = np.flatnonzero(row >= STRONG * row.max())
        links = tuple(dict.fromkeys(model.body(model.dof_bodyid[dof]).name for dof in which))
        states[names.state[at]] = states[names.state[half + at]] = links
    driven = [_driven(model, each) for each in range(model.nu)]
    given = np.eye(model.nu) if body.together is None else np.abs(body.together)
    commands = {
        name: tuple(dict.fromkeys(driven[at] for at in np.flatnonzero(column)))
        for name, column in zip(names.command, given.T, strict=True)
    }
    return LinkNames(states=states, commands=commands)


def spoken(body: Body) -> dict[str, str]:
    """Return what numbers of a body are called that no joint has by itself: with their links."""
    result = parts_of(body)
    numbers = {} if body.sight is None else dict(result.states)
    groups = {} if body.together is None else dict(result.commands)
    joints = {joint.name for joint in body.task.robot.joints}
    return {
        name: f"{name} ({_few(links)})"
        for name, links in (numbers | groups).items()
        if links and name not in joints
    }


def _few(links: Sequence[str]) -> str:
    more = len(links) - FEW
    return ", ".join(links[:FEW]) + (f" and {more} more" if more > 0 else "")


def middle(figure: Figure, link: str) -> tuple[float, float, float]:
    """Return the middle of what is drawn of a link, in its frame, m; its origin if nothing is."""
    at = figure.links.index(link)
    points = [shape.vertices for shape in figure.shapes if shape.body == at]
    if not points:
        return (0.0, 0.0, 0.0)
    every: Array = np.concatenate(points)
    x, y, z = (0.5 * (every.min(axis=0) + every.max(axis=0))).tolist()
    return (x, y, z)


def _driven(model: mujoco.MjModel, actuator: int) -> str:
    """Return the link that an actuator drives."""
    kind, at = model.actuator_trntype[actuator], int(model.actuator_trnid[actuator, 0])
    if kind == mujoco.mjtTrn.mjTRN_JOINT.value:
        return str(model.body(model.jnt_bodyid[at]).name)
    if kind == mujoco.mjtTrn.mjTRN_SITE.value:
        return str(model.body(model.site_bodyid[at]).name)
    return str(model.body(at if kind == mujoco.mjtTrn.mjTRN_BODY.value else 0).name)
