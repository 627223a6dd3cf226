"""The sizes of a hidden effect: drawn, then set so that its strength is as wanted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.conceal.case import Case
from experiments.conceal.equations import Equations
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.sensor import FINEST

WEAKEST, STRONGEST = 3.0, 60.0
BOUNDED = ("actuator_delay", "actuator_lag", "torque_scale", "armature")
"""Effects whose sizes have bounds of their own; the encoder is chosen to suit them.

A gain within 15 % of 1 or a rotor below a quarter of the joint's inertia would
hide in what every description is trusted to, 10 % of its masses and 5 % of its
gains, and no recording could tell.
"""


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """What fixes an effect's parameters."""

    target: float
    """Strength wanted."""
    size: float
    """For effects without bounds: their share of what moves the joint."""
    share: float
    """For effects with bounds: where between them, 0 weakest to 1 strongest."""
    side: float
    """-1 or 1."""
    ratio: float
    """Stribeck: friction at rest over friction in fast motion."""
    fade: float
    """Stribeck: vs as a share of a brisk speed."""
    rest: float
    """Stiffness: q0 as a share of the joint's span."""
    counts: float
    """Counts per turn of the encoders."""


def first(case: Case, rng: np.random.Generator) -> Sizes:
    """Return a first draw."""
    # The margin keeps the final strength inside once it is found on a finer step.
    return Sizes(
        target=float(np.exp(rng.uniform(np.log(WEAKEST * 1.06), np.log(STRONGEST / 1.06)))),
        size=0.02,
        share=float(rng.random()),
        side=float(rng.choice([-1, 1])),
        ratio=float(rng.uniform(1.4, 2.5)),
        fade=float(np.exp(rng.uniform(np.log(0.02), np.log(0.2)))),
        rest=float(rng.uniform(-0.3, 0.3)),
        counts=float(np.round(np.exp(rng.uniform(np.log(4096), np.log(FINEST))))),
    )


def parameters(case: Case, sizes: Sizes) -> dict[str, float]:
    """Return the effect's parameters, rounded to what the seal will state."""
    if case.effect is None:
        return {}
    equations = MECHANISMS[case.robot]
    reach = equations.reach[case.joint]
    size, effort, speed = sizes.size, reach.effort, reach.speed
    lever = np.log(60 / 5)
    gain = 0.75 - 0.25 * sizes.share if sizes.side < 0 else 1.3 + 0.3 * sizes.share
    table = {
        "viscous_friction": {"b": size * effort / speed},
        "coulomb_friction": {"c": size * effort},
        "stribeck_friction": {
            "c": size * effort,
            "s": sizes.ratio * size * effort,
            "vs": sizes.fade * speed,
        },
        "quadratic_damping": {"b2": size * effort / speed**2},
        "joint_stiffness": {"k": size * effort / reach.span, "q0": sizes.rest * reach.span},
        "armature": {"J": (0.25 + 0.75 * sizes.share) * inertia(equations, case.joint)},
        "actuator_delay": {"T": 0.005 * np.exp(lever * sizes.share)},
        "actuator_lag": {"T": 0.005 * np.exp(lever * sizes.share)},
        "torque_scale": {"gain": gain},
        "sensor_bias": {"bias": sizes.side * size * 0.1},
    }
    return {name: float(f"{value:.6g}") for name, value in table[case.effect].items()}


def inertia(equations: Equations, joint: int) -> float:
    """Return the nominal inertia about one joint, hanging, kg m2 or kg."""
    nominal = {name: np.array([value]) for name, value in equations.nominal().items()}
    mass = equations.mass(np.zeros((len(equations.joints), 1)), nominal)
    return float(mass[0 if joint == 0 else 2][0])


def suited(case: Case, sizes: Sizes, found: float, rng: np.random.Generator) -> Sizes:
    """Return sizes whose strength comes closer to the target.

    Args:
        case: What is hidden.
        sizes: The sizes tried.
        found: The strength that they gave.
        rng: Source of a new draw, where the target cannot be met.
    """
    if case.effect is None:
        return sizes
    missing = sizes.target / max(found, 1e-6)
    if case.effect not in BOUNDED:
        size = float(np.clip(sizes.size * np.clip(missing, 0.1, 10.0), 1e-4, 0.6))
        return replace(sizes, size=size)
    counts = float(np.round(np.clip(sizes.counts * missing, 1000, 20000)))
    reached = found * counts / sizes.counts
    if WEAKEST * 1.03 <= reached <= STRONGEST / 1.03:
        return replace(sizes, counts=counts)
    weaker = reached > STRONGEST
    low, high = (0.0, sizes.share) if weaker else (sizes.share, 1.0)
    return replace(sizes, counts=counts, share=float(rng.uniform(low, high)))
