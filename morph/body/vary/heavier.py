"""Making a link heavier or lighter without changing its shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.body.vary.operation import Operation
from morph.body.vary.part import chosen


@dataclass(frozen=True, kw_only=True)
class Heavier(Operation):
    """A link of another density: m' = s m and I' = s I, with s = factor + add / m.

    The centre of mass stays, and the mass added is spread as the link's own is:
    I is an integral of density, so it grows as the mass does. On the whole
    body, m is the mass of all links.
    """

    name: ClassVar[str] = "heavier"
    amount: ClassVar[str] = "factor"

    link: str
    """The link, or `*` for all."""
    factor: float = 1.0
    """Mass per mass before."""
    add: float = 0.0
    """Mass added after that, kg; negative takes away."""

    def __post_init__(self) -> None:
        self.check_positive("factor")
        self.check_finite("add")

    def apply(self, spec: Any) -> None:
        """Multiply mass and inertia of the links chosen."""
        bodies = chosen(spec, self.link)
        mass = sum(body.mass for body in bodies if body.explicitinertial)
        if mass <= 0:
            raise self.refuse("it has no mass to multiply", "give it a mass in the description")
        share = self.factor + self.add / mass
        if share <= 0:
            raise self.refuse(
                f"add = {self.add} kg leaves {share * mass:.6g} kg of {mass:.6g} kg",
                "take away less than it weighs",
            )
        for body in bodies:
            if body.explicitinertial:
                body.mass = body.mass * share
                body.inertia = body.inertia * share
