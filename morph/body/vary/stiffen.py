"""Putting a spring and a damper beside a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco

from morph.body.vary.operation import Operation
from morph.body.vary.part import joint


@dataclass(frozen=True, kw_only=True)
class Stiffen(Operation):
    """A joint with a spring and a damper in parallel to those it has.

    Two springs in parallel, k0 at rest at r0 and k at r, act as one:
    tau = -k0 (q - r0) - k (q - r) = -(k0 + k) (q - (k0 r0 + k r) / (k0 + k)).
    Dampers add: d0 + d.
    """

    name: ClassVar[str] = "stiffen"
    amount: ClassVar[str] = "stiffness"

    joint: str
    """The hinge or slide, or the link that it alone moves."""
    stiffness: float = 0.0
    """k: of the spring added, N m/rad or N/m."""
    damping: float = 0.0
    """d: of the damper added, N m s/rad or N s/m."""
    rest: float | None = None
    """r: where the spring added rests, rad or m; None: where the present one does."""

    def __post_init__(self) -> None:
        self.check_finite("stiffness", "damping", *(() if self.rest is None else ("rest",)))
        for field in ("stiffness", "damping"):
            if getattr(self, field) < 0:
                raise self.refuse(
                    f"{field} is {getattr(self, field)}, below 0", f"give a {field} of 0 or more"
                )

    def apply(self, spec: Any) -> None:
        """Add the spring and the damper."""
        result = joint(spec, self.joint)
        if result.type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            raise self.refuse("it is neither a hinge nor a slide", "name a hinge or a slide")
        before = float(result.stiffness[0])
        rest = result.springref if self.rest is None else self.rest
        if rest != result.springref and result.stiffness[1:].any():
            raise self.refuse(
                "its own spring is not linear, so two rests make no one spring",
                "leave out rest",
            )
        if self.stiffness > 0:
            both = before + self.stiffness
            result.springref = (before * result.springref + self.stiffness * rest) / both
            result.stiffness = (both, *result.stiffness[1:])
        result.damping = (result.damping[0] + self.damping, *result.damping[1:])
