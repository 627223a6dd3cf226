"""What may differ between a body and its description: weights, lengths, damping, gains, gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.body.vary.apply import edited
from morph.errors import DiagnosisError
from morph.files import sha256
from morph.model.nuisance_parameters import Knob, that_matter

WIDE = 1.2
"""Standard deviation of the logarithm of a figure that may be anything: two of it are a factor
of eleven."""

TRUSTED = 0.05
"""The same for a figure that was measured: five percent."""

MOST = 30.0
"""Greatest factor by which a figure may be off."""


def unknowns(robot: Robot, width: float = TRUSTED) -> tuple[Knob, ...]:
    """Return every figure of a robot on which its motion depends, as logarithms of factors.

    Of a link that is its weight (mass and inertia together) and its length (where its mass and
    what it carries are; the mass stays); of a joint damping, armature, dry friction and stiffness
    that the description has; of an actuator its gain; and gravity.

    Args:
        robot: The robot.
        width: Standard deviation that each logarithm has before any data.
    """
    listed = [("world", "world", "gravity")]
    for link in robot.links:
        listed += [("weight", link.name, "weight"), ("length", link.name, "length")]
    listed += [("gain", actuator.name, "gain") for actuator in robot.actuators]
    spec = bare_spec(robot)
    for joint in robot.joints:
        if joint.kind in {"hinge", "slide"}:
            for figure in ("damping", "armature", "frictionloss", "stiffness"):
                if np.any(getattr(spec.joint(joint.name), figure)):
                    listed.append(("joint", joint.name, figure))
    results = [Knob(kind=k, part=p, what=w, fraction=width) for k, p, w in listed]
    return tuple(that_matter(robot, results))


def turned(robot: Robot, factors: Mapping[str, float]) -> Robot:
    """Return a robot with figures multiplied: `{"length:pole": 2.0}`.

    Raises:
        DiagnosisError: There is no such figure, or it does not matter.
    """
    known = {knob.name: knob for knob in unknowns(robot)}
    for name in factors:
        if name not in known:
            raise DiagnosisError(
                f"there is no figure {name!r}; there are {', '.join(known)}",
                where=f"robot {robot.name}",
                fix="name one of these",
            )
    chosen = [known[name] for name in factors]
    return with_knobs(robot, chosen, np.log(list(factors.values())))


def with_knobs(robot: Robot, knobs: Sequence[Knob], logarithms: Array) -> Robot:
    """Return the robot with knobs turned by so much; its name and hash say so."""
    spec = bare_spec(robot)
    lines = []
    for knob, logarithm in zip(knobs, logarithms, strict=True):
        if logarithm != 0.0:
            knob.edit(spec, float(logarithm))
            lines.append(f"{knob.name}*{np.exp(logarithm):.4g}")
    if not lines:
        return robot
    exact = [f"{knob.name} {float(x)!r}" for knob, x in zip(knobs, logarithms, strict=True)]
    digest = sha256(robot.sha256 or sha256(robot.mjcf), *exact)
    return edited(robot, spec, "+".join((robot.name, *lines)), digest)
