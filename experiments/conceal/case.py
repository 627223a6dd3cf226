"""What a case hides, and where: drawn from a seed, known before anything is simulated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.conceal.equations import Equations
from experiments.conceal.laws import ACTUATOR_LAWS, LAWS, SENSOR_LAWS
from experiments.conceal.mechanisms import MECHANISMS


@dataclass(frozen=True, kw_only=True)
class Case:
    """One robot with at most one effect left out of its description."""

    name: str
    """Name of the case's folder."""
    seed: int
    """Fixes everything about the case that is drawn."""
    robot: str
    """A name on the shelf."""
    effect: str | None
    """What is left out, or None for a clean case."""
    kind: str | None
    """`joint`, `actuator` or `sensor`."""
    place: str | None
    """The joint, the actuator, or the sensor's channel."""

    @property
    def joint(self) -> int:
        """The index of the joint that the place belongs to; 0 for a clean case."""
        joints = MECHANISMS[self.robot].joints
        return 0 if self.place is None else joints.index(self.place.split(".")[0])


def places(equations: Equations, effect: str) -> tuple[tuple[str, str], ...]:
    """Return each (kind, name) where an effect may be hidden.

    A bias of a slide's position is left out: the mechanism is the same everywhere
    along its rail, so no experiment could reveal it.
    """
    if effect in ACTUATOR_LAWS:
        return tuple(("actuator", name) for name in equations.actuators)
    if effect in SENSOR_LAWS:
        turning = zip(equations.joints, equations.kinds, strict=True)
        return tuple(("sensor", f"{j}.position") for j, kind in turning if kind == "hinge")
    return tuple(("joint", name) for name in equations.joints)


def make_cases(count: int, seed: int, *, clean: bool) -> list[Case]:
    """Return cases with robots and places at random and each effect equally often."""
    rng = np.random.default_rng([seed, int(clean)])
    order = [LAWS[i] for _ in range(count // len(LAWS) + 1) for i in rng.permutation(len(LAWS))]
    names = list(MECHANISMS)
    cases = []
    for number in range(count):
        robot = names[int(rng.integers(len(names)))]
        effect = None if clean else order[number]
        kind, place = None, None
        if effect is not None:
            options = places(MECHANISMS[robot], effect)
            kind, place = options[int(rng.integers(len(options)))]
        label = "clean" if clean else "effect"
        cases.append(
            Case(
                name=f"{label}_{seed}_{number:03d}",
                seed=int(rng.integers(2**31)),
                robot=robot,
                effect=effect,
                kind=kind,
                place=place,
            )
        )
    return cases
