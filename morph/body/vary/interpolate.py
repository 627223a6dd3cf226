"""Bodies on the way from one to another, of the same or of different topology."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import mujoco

from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.body.vary.apply import rebuilt
from morph.body.vary.blend import (
    blend_actuator,
    blend_body,
    blend_joint,
    blend_options,
    blend_shapes,
)
from morph.body.vary.fade import (
    MOVING,
    SMALLEST,
    effort_at,
    fade_actuator,
    fade_body,
    fade_joint,
    lock_by_constraint,
    place_between,
    size_at,
    weld_by_constraint,
)
from morph.body.vary.loops import fade_loops
from morph.body.vary.match import match
from morph.body.vary.rename import renamed
from morph.body.vary.signs import opposite, reverse
from morph.body.vary.union import Union, skeleton, union
from morph.errors import RobotError
from morph.files import sha256


def interpolate(
    first: Robot,
    second: Robot,
    fraction: float,
    *,
    mapping: Mapping[str, str] | None = None,
    smallest: float = SMALLEST,
) -> Robot:
    """Return a body on the way from one robot to another.

    Of a part that both have, positions, ranges and gains go in straight lines,
    orientations by slerp, and inertias through bodies that can exist, masses
    in geometric steps (pseudo.py). A part that only one has grows or shrinks
    (fade.py), so that all bodies on one way have the same links, joints and
    actuators, in the same order and by the first body's names. Where a joint's
    axes point more than 90 degrees apart, the second body's position, force
    and command of it count the other way: q' = -q. What has no
    numbers between, such as meshes, materials and sensors, is
    that of the nearer body.

    At fraction 0 it moves as the first robot, at 1 as the second: exactly, if
    their topology is the same; else but for links of `smallest` size, which
    weigh `smallest`^3 of themselves and stand locked.

    Source: the path through one tree is that of Liu, Pathak and Kitani 2022,
    REvolveR, ICML, for policies that are to go along it.

    Args:
        first: The robot at fraction 0.
        second: The robot at fraction 1.
        fraction: 0 to 1.
        mapping: Links of the first that have a counterpart, with its name in
            the second; None: by name, then by structure (match.py).
        smallest: Size of an absent link, to its own.

    Raises:
        RobotError: The fraction lies outside 0 to 1, no tree holds both
            bodies, an axis that differs cannot be turned, or an actuator
            drives no joint.
    """
    return _Way.of(first, second, mapping, smallest).at(fraction)


def path(
    first: Robot,
    second: Robot,
    steps: int,
    *,
    mapping: Mapping[str, str] | None = None,
    smallest: float = SMALLEST,
) -> tuple[Robot, ...]:
    """Return the steps + 1 bodies at fractions 0, 1 / steps, ..., 1.

    Args:
        first: The robot at fraction 0.
        second: The robot at fraction 1.
        steps: How many steps to take, at least 1.
        mapping: As `interpolate` takes it.
        smallest: As `interpolate` takes it.

    Raises:
        RobotError: As `interpolate` does, or there is no step.
    """
    if steps < 1:
        raise RobotError(
            f"steps is {steps}", where=f"path from {first.name}", fix="take at least 1 step"
        )
    way = _Way.of(first, second, mapping, smallest)
    return tuple(way.at(step / steps) for step in range(steps + 1))


@dataclass(frozen=True, kw_only=True)
class _Way:
    first: Robot
    second: Robot
    tree: Union
    smallest: float
    mass: float
    origin: str

    @staticmethod
    def of(first: Robot, second: Robot, mapping: Mapping[str, str] | None, smallest: float) -> _Way:
        where = f"way from {first.name} to {second.name}"
        if not 0 < smallest < 1:
            raise RobotError(
                f"smallest is {smallest}", where=where, fix="choose it between 0 and 1"
            )
        for robot in (first, second):
            for actuator in robot.actuators:
                robot.driven_by(actuator)
        one, other = bare_spec(first), bare_spec(second)
        one.modelname, other.modelname = first.name, second.name
        twin = _beside(one, replace(second, mjcf=renamed(second.mjcf, match(one, other, mapping))))
        tree = union(one, bare_spec(twin))
        ends = [robot.sha256 or sha256(robot.mjcf) for robot in (first, second)]
        given = "" if mapping is None else repr(sorted(mapping.items()))
        origin = sha256(*ends, given, repr(smallest))
        mass = max(first.mass, second.mass)
        return _Way(
            first=first, second=twin, tree=tree, smallest=smallest, mass=mass, origin=origin
        )

    def at(self, fraction: float) -> Robot:
        name = f"{self.first.name}~{self.second.name}({fraction:.6g})"
        if not 0 <= fraction <= 1:
            raise RobotError(
                f"the fraction is {fraction}", where=name, fix="give a fraction from 0 to 1"
            )
        nearer = self.first if fraction < 0.5 else self.second
        spec = bare_spec(replace(nearer, mjcf=skeleton(nearer.mjcf, self.tree)))
        ends = bare_spec(self.first), bare_spec(self.second)
        blend_options(spec, *ends, fraction)
        for link in self.tree.parents:
            self._link(spec, ends, link, fraction)
        for actuator, joint in self.tree.actuators.items():
            self._actuator(spec, ends, actuator, joint, fraction)
        fade_loops(spec, ends, fraction, self._sizes(ends, fraction))
        return rebuilt(spec, nearer, name, sha256(self.origin, repr(float(fraction))))

    def _link(self, spec: Any, ends: tuple[Any, Any], name: str, fraction: float) -> None:
        body, twins = spec.body(name), (ends[0].body(name), ends[1].body(name))
        if all(twins):
            blend_body(body, *twins, fraction)
            blend_shapes(body, *twins, fraction)
            s = 1.0
        else:
            presence, source = _only(twins, fraction)
            s = size_at(presence, self.smallest)
            fade_body(spec, body, source, presence, s)
            self._place(body, source, presence, fraction, ends)
        for joint in self.tree.joints[name]:
            self._joint(spec, ends, joint, fraction, link_is_whole=all(twins))

    def _place(
        self, body: Any, source: Any, presence: float, fraction: float, ends: tuple[Any, Any]
    ) -> None:
        if body.name in self.tree.between:
            place_between(body, source, presence)
            return
        carrier = self.tree.parents[body.name]
        carriers = ends[0].body(carrier), ends[1].body(carrier)
        s = 1.0 if all(carriers) else size_at(_only(carriers, fraction)[0], self.smallest)
        body.pos, body.quat = source.pos * s, source.quat.copy()

    def _joint(
        self, spec: Any, ends: tuple[Any, Any], name: str, fraction: float, *, link_is_whole: bool
    ) -> None:
        joint, twins = spec.joint(name), (ends[0].joint(name), ends[1].joint(name))
        if all(twins):
            blend_joint(joint, *twins, fraction)
            return
        presence, source = _only(twins, fraction)
        s = size_at(presence, self.smallest)
        fade_joint(joint, source, s)
        if link_is_whole:
            joint.pos = source.pos.copy()
        if joint.type in MOVING:
            lock_by_constraint(spec, joint, presence, self.mass)
        else:
            weld_by_constraint(spec, joint, presence, self.mass)

    def _sizes(self, ends: tuple[Any, Any], fraction: float) -> dict[str, float]:
        sizes: dict[str, float] = {}
        for name in self.tree.parents:
            twins = ends[0].body(name), ends[1].body(name)
            if not all(twins):
                sizes[name] = size_at(_only(twins, fraction)[0], self.smallest)
        return sizes

    def _actuator(
        self, spec: Any, ends: tuple[Any, Any], name: str, joint: str, fraction: float
    ) -> None:
        actuator = spec.actuator(name)
        twins = ends[0].actuator(name), ends[1].actuator(name)
        if all(twins):
            blend_actuator(actuator, *twins, fraction)
            return
        presence, source = _only(twins, fraction)
        if all((ends[0].joint(joint), ends[1].joint(joint))):
            fade_actuator(actuator, source, presence)
        else:
            slide = spec.joint(joint).type == mujoco.mjtJoint.mjJNT_SLIDE
            s = size_at(presence, self.smallest)
            fade_actuator(actuator, source, effort_at(s, slide=slide))


def _beside(first: Any, second: Robot) -> Robot:
    # The second body as it counts its joints when it counts them as the first does.
    spec = bare_spec(second)
    turned = opposite(first, spec)
    if not turned:
        return second
    for joint in turned:
        reverse(spec, joint)
    spec.compile()
    return replace(second, mjcf=fulltext(spec))


def _only(twins: tuple[Any, Any], fraction: float) -> tuple[float, Any]:
    # The presence of a part that one body has, and that body's part.
    first, second = twins
    return (1 - fraction, first) if first else (fraction, second)
