"""Absurd limit: a range that no joint has."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places
from experiments.plant.description import Description, child_of, joint_in
from experiments.plant.errors import there


class AbsurdLimit(Defect):
    """Degrees for radians, a thousand million for "none", no number, or a range upside down."""

    name: ClassVar[str] = "absurd-limit"
    variants: ClassVar[tuple[str, ...]] = ("degrees", "huge", "not finite", "reversed")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"limit-range" if variant == "reversed" else "limit-absurd"})

    def also(self, variant: str) -> frozenset[str]:
        """Return the code that says that nan and inf are no numbers."""
        return frozenset({"ill-typed"} if variant == "not finite" else ())

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the joints."""
        return original.joints

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the range, sensible now: at most a turn each way, at least 0.8 rad one way."""
        joint = joint_in(original.robot, site)
        limit = joint.find("limit")
        if joint.get("type") != "revolute" or limit is None:
            return ""
        lower, upper = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
        reach = max(abs(lower), abs(upper))
        # 0.8 rad is 46 degrees: read as radians, seven turns.
        sensible = lower < upper and 0.8 <= reach <= 2 * math.pi + 0.1
        return f"[{lower:.3g}, {upper:.3g}] rad" if sensible else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Write the other range."""
        robot = copy.parse()
        joint = joint_in(robot, site)
        limit = there(joint.find("limit"), f"limit of {site}")
        lower, upper = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
        new = {
            "degrees": (f"{math.degrees(lower):.0f}", f"{math.degrees(upper):.0f}"),
            "huge": ("-1e9", "1e9"),
            "not finite": (limit.get("lower", "0"), str(rng.choice(["nan", "inf"]))),
            "reversed": (limit.get("upper", "0"), limit.get("lower", "0")),
        }[variant]
        limit.set("lower", new[0])
        limit.set("upper", new[1])
        copy.write(robot)
        return Done(
            did=f"[{lower:.4g}, {upper:.4g}] became [{new[0]}, {new[1]}]",
            places=Places(parts=frozenset({site, child_of(joint)})),
        )
