"""Suites by name: which kinds of cases they hold, and in what shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from experiments.concealed.body_laws import BODY_LAWS, WORLD_LAWS
from experiments.concealed.joint_laws import ACTUATOR_LAWS, JOINT_LAWS, SENSOR_LAWS
from experiments.concealed.law import Law
from experiments.concealed.outside import OUTSIDE_LAWS

WAYS = ("read", "hidden", "tracked")
"""Every joint has an encoder; one, drawn at random, has none; none has one, and a camera tells the
place and orientation of every link."""
LASTING = (
    "coulomb_friction", "joint_stiffness", "payload", "quadratic_damping", "sensor_bias",
    "torque_scale", "viscous_friction",
)  # fmt: skip
"""Laws that may begin during a run: they remember nothing."""
LAWS: tuple[Law, ...] = JOINT_LAWS + ACTUATOR_LAWS + SENSOR_LAWS + BODY_LAWS + WORLD_LAWS
"""Every law of `effects.md` that acts on a mechanism without contact and with a fixed base."""


@dataclass(frozen=True, kw_only=True)
class Suite:
    """A family of cases with seeds of its own."""

    number: int
    """Keeps its seeds apart from those of other suites."""
    counts: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Shares of cases with one, two and three effects of the library."""
    clean: float = 0.0
    """Share of cases whose description lacks nothing."""
    outside: float = 0.0
    """Share of cases with physics outside the library."""
    judge: bool = False
    """Whether that physics is the half kept from development."""
    drives: bool = False
    """Whether all cases are industrial arms with the physics of real drives."""
    events: bool = False
    """Whether effects are pushes and laws that begin during the runs, in turn."""
    ways: tuple[str, ...] = ("read",)
    """Of which joints' positions logs tell, and by what; each case is logged in every way."""

    def count(self, seed: int, number: int) -> int:
        """Return how many effects of the library a case has; -1 for physics outside of it.

        Every twenty cases hold the shares as nearly as twenty can, in an order drawn at random.
        """
        turn, place = divmod(number, 20)
        order = np.random.default_rng([self.number, seed, turn]).permutation(20)
        chance = (float(order[place]) + 0.5) / 20
        for count, share in zip((1, 2, 3, 0), (*self.counts, self.clean), strict=True):
            if chance < share:
                return count
            chance -= share
        return -1

    def laws(self) -> tuple[Law, ...]:
        """Return the laws of the library that it uses: of sensors only where all are there."""
        return tuple(law for law in LAWS if len(self.ways) == 1 or law.kind != "sensor")

    def events_of(self, kin: int) -> tuple[Law, ...]:
        """Return the laws of one of its cases with events: a push, or what may begin in a run."""
        names = ("external_push",) if kin % 2 == 0 else LASTING
        return tuple(law for law in LAWS if law.name in names)

    def outside_laws(self) -> tuple[Law, ...]:
        """Return the laws outside the library that it uses."""
        return tuple(law for law in OUTSIDE_LAWS if law.judge == self.judge)


SUITES: Mapping[str, Suite] = {
    "development": Suite(number=1, counts=(0.45, 0.2, 0.1), clean=0.1, outside=0.15),
    "calibration": Suite(number=2, counts=(0.45, 0.2, 0.1), clean=0.1, outside=0.15),
    "judge": Suite(number=3, counts=(0.4, 0.2, 0.1), clean=0.1, outside=0.2, judge=True),
    "clean": Suite(number=4, clean=1.0),
    "outside": Suite(number=5, outside=1.0),
    "arms": Suite(number=6, drives=True),
    "channels": Suite(number=7, counts=(0.5, 0.25, 0.0), clean=0.25, judge=True, ways=WAYS),
    "events": Suite(number=8, counts=(0.8, 0.0, 0.0), clean=0.2, judge=True, events=True),
}
"""Twins are among the cases with effects; their truth lists every answer that is as right."""
