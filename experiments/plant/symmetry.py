"""Flipped axis and mirrored limb: left and right mixed up."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places
from experiments.plant.description import (
    Description,
    child_of,
    joint_in,
    numbers,
    parent_of,
    text_of,
)
from experiments.plant.errors import there
from experiments.plant.measure import inertial
from experiments.plant.sides import axis_in_world, joint_at, side, twin, twins

SAME = 0.05
"""rad: limits closer than this say the same."""


class FlippedAxis(Defect):
    """A joint's axis negated, its limits left, while its twin keeps its own."""

    name: ClassVar[str] = "flipped-axis"
    variants: ClassVar[tuple[str, ...]] = ("negated",)

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"axis-flipped"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints that have a twin."""
        return [name for pair in twins(original) for name in pair]

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return why the two turn alike now and would not afterwards.

        Either the limits say so: they reach further one way than the other, and agree
        with the axes as they are. Or both turn about the axis from right to left in one
        sense, and so do all other such pairs of the robot.
        """
        sense = _sense(original, site)
        if sense == 0:
            return ""
        own, other = _limits(original, site), _limits(original, twin(site))
        if own and other and abs(own[0] + own[1]) > 4 * SAME:
            mirrored = other if sense > 0 else (-other[1], -other[0])
            agree = max(abs(a - b) for a, b in zip(own, mirrored, strict=True)) < SAME
            return f"limits {own} beside {other}, axes in sense {sense:+d}" if agree else ""
        across, _ = side(original)
        pitch = [one for one, _ in twins(original) if _turns_about(original, one, across)]
        if len(pitch) < 2 or not {site, twin(site)} & set(pitch):
            return ""
        alike = all(_sense(original, one) > 0 for one in pitch)
        return f"all {len(pitch)} pairs pitch in one sense" if alike else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Negate the axis."""
        robot = copy.parse()
        axis = there(joint_in(robot, site).find("axis"), f"axis of {site}")
        old = axis.get("xyz", "")
        axis.set("xyz", text_of(0.0 - value for value in numbers(axis, "xyz", "")))
        copy.write(robot)
        return Done(
            did=f"axis {old} became {axis.get('xyz')}",
            places=Places(
                parts=frozenset({site, child_of(joint_in(robot, site))}),
                partners=frozenset({twin(site), child_of(joint_in(robot, twin(site)))}),
            ),
        )


class MirroredLimb(Defect):
    """A limb's first joint at the place of its twin on the other side."""

    name: ClassVar[str] = "mirrored-limb"
    variants: ClassVar[tuple[str, ...]] = ("xyz copied", "origin copied")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"limb-mirrored"})

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints that hang, with their twins, from one part in the middle."""
        return [
            name
            for pair in twins(original)
            if len({parent_of(joint_in(original.robot, name)) for name in pair}) == 1
            for name in pair
        ]

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return how far the limb is from its place, and what of the robot goes with it."""
        across, middle = side(original)
        here, there = joint_at(original, site), joint_at(original, twin(site))
        apart = here - there
        off = abs(float(apart[across]))
        along = float(np.linalg.norm(np.delete(apart, across)))
        crosses = (here[across] - middle) * (there[across] - middle) < 0
        limb = original.below(child_of(joint_in(original.robot, site)))
        mass = sum(one.mass for link in limb if (one := inertial(original, link)))
        if off < 0.02 or along > 0.02 * off or not crosses:
            return ""
        # A limb bends: what moves by one joint alone, or not at all, is a part.
        if sum(_turns(original, original.parents[link]) for link in limb) < 2:
            return ""
        return f"{off:.3f} m from its twin, limb of {len(limb)} links and {mass:.2f} kg"

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Give the joint the place of its twin, as a block that was copied and not finished."""
        robot = copy.parse()
        own = there(joint_in(robot, site).find("origin"), f"origin of {site}")
        other = there(joint_in(robot, twin(site)).find("origin"), f"origin of {twin(site)}")
        old = own.get("xyz", "")
        own.set("xyz", other.get("xyz", "0 0 0"))
        if variant == "origin copied" and other.get("rpy"):
            own.set("rpy", other.get("rpy", ""))
        copy.write(robot)
        return Done(
            did=f"origin {old} became {own.get('xyz')}",
            places=Places(parts=frozenset({site, child_of(joint_in(robot, site))})),
        )


def _turns(original: Description, joint: str) -> bool:
    return joint_in(original.robot, joint).get("type") in ("revolute", "continuous")


def _turns_about(original: Description, joint: str, across: int) -> bool:
    """Return whether a joint turns about the line from right to left."""
    return _turns(original, joint) and abs(axis_in_world(original, joint)[across]) > 0.9


def _sense(original: Description, joint: str) -> int:
    """Return +1 if the twins' motions are mirror images at equal positions, -1 if at opposite.

    Zero if they do not turn, or the axes are no mirror images. A turn is an axial vector:
    its mirror image across a plane with the reflection M is det(M) M a = -M a.
    """
    if not (_turns(original, joint) and _turns(original, twin(joint))):
        return 0
    across, _ = side(original)
    one, other = axis_in_world(original, joint), axis_in_world(original, twin(joint))
    image = -one
    image[across] = one[across]
    match = float(image @ other)
    return 0 if abs(match) < 0.999 else (1 if match > 0 else -1)


def _limits(original: Description, joint: str) -> tuple[float, float] | None:
    """Return a joint's limits, rad, or None for one without."""
    limit = joint_in(original.robot, joint).find("limit")
    if limit is None or limit.get("lower") is None:
        return None
    return float(limit.get("lower", "0")), float(limit.get("upper", "0"))
