"""A rig, and the MJCF that it is described by."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from experiments.unseen_rigs.plant import Plant
from morph.arrays import Array
from morph.files import write_whole


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A description, the plant that is as described, and what the other one has beside."""

    described: Plant
    """The plant without anything left out."""
    lacking: Plant
    """The plant with it."""
    names: tuple[str, ...]
    """Labels of the laws that are right."""
    led: Callable[[Array, float], Mapping[str, float]]
    """Where its joints are led, rad, by random phases and the time; of motors that turn no joint
    the command."""
    gains: tuple[float, float]
    """Of the controller that leads joints, N m/rad and N m s/rad."""
    start: Mapping[str, float] = field(default_factory=dict)
    """Where joints start, rad."""
    base: str = ""
    """The link that floats; empty of a robot that is bolted down."""
    height: float = 0.0
    """At which it starts, m."""
    by_effort: bool = False
    """Whether joints' torques are logged in the place of commands."""
    once: bool = False
    """Whether the second run alone has what is lacking, as a push."""


def inertial(mass: float, size: Sequence[float], place: str = "0 0 0") -> str:
    """Return the inertia of a box of some edges, as MJCF."""
    x, y, z = (each**2 for each in size)
    moments = " ".join(f"{mass / 12 * each:.9g}" for each in (y + z, x + z, x + y))
    return f'<inertial pos="{place}" mass="{mass:g}" diaginertia="{moments}"/>'


def joint(name: str, axis: str = "0 1 0", *, armature: float = 0.002, damping: float = 0.0) -> str:
    """Return a hinge, as MJCF."""
    return f'<joint name="{name}" axis="{axis}" armature="{armature:g}" damping="{damping:g}"/>'


def motors(names: Sequence[str]) -> str:
    """Return a motor of the name of each joint, as MJCF."""
    return "".join(f'<motor name="{name}" joint="{name}"/>' for name in names)


def written(folder: Path, name: str, world: str, rest: str, *, option: str = "") -> Path:
    """Write a description of a world's bodies and what stands beside them."""
    text = f'<mujoco model="{name}">{option}<worldbody>{world}</worldbody>{rest}</mujoco>'
    return write_whole(folder / f"{name}.xml", text)
