"""A contact as a spring and a damper: their law, their limits, and MuJoCo's words for them.

MuJoCo gives a contact of impedance d the acceleration dv/dt = -k r - b v + (1 - d) a,
where r is how deep it is, v how fast it deepens, and a what all other forces would give
(MuJoCo documentation, Modeling, Solver parameters, eqs. constraint and solref_direct, at a
constant d). Times the effective mass m of the contact it is a spring K = m k and a damper
C = m b, that bear the share d of a load without giving way.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from morph.errors import EffectError
from morph.physics.fluid import settle as fluid

IMPEDANCE = 0.5
"""The impedance d of a contact whose softness is told.

Nearer 0 the spring bears lasting loads too, but friction, which shares d, creeps: at
(1 - d) / d times the sideways pull over m b. Nearer 1 a body at rest is so little deep that it
leaves the floor within a step, and what should rest chatters where it bounces well.
"""


def ratio_of(e: float) -> float:
    """Return the damping ratio at which a spring and damper bounce with a restitution e.

    The inverse of `restitution_of` by bisection, between 0 and `STIFLED`.
    """
    low, high = 0.0, STIFLED
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if restitution_of(middle) > e else (low, middle)
    return 0.5 * (low + high)


STIFLED = 5.0
"""The greatest damping ratio used: its restitution is 0.0093."""


def restitution_of(ratio: float) -> float:
    """Return the restitution of a spring and damper that cannot pull.

    Source: Schwager and Poschel 2007, Granular Matter 9, eqs. 16 to 20, with the damping
    ratio z = beta / omega_0: e = exp(-z / s * (pi - atan2(2 z s, 1 - 2 z^2))) below 1,
    s = sqrt(1 - z^2); e = exp(-z / s * ln((z + s) / (z - s))) above, s = sqrt(z^2 - 1).

    Args:
        ratio: Damping over critical damping, at least 0.
    """
    if abs(ratio - 1.0) < 1e-6:
        return math.exp(-2.0)
    s = math.sqrt(abs(1.0 - ratio**2))
    if ratio < 1.0:
        angle = math.atan2(2.0 * ratio * s, 2.0 * ratio**2 - 1.0)
        return math.exp(-ratio / s * angle)
    return math.exp(-ratio / s * math.log((ratio + s) / (ratio - s)))


def told(pair: Any) -> tuple[float, float]:
    """Return k, 1/s2, and b, 1/s, of a pair as MuJoCo's direct format has them.

    Source: MuJoCo documentation, Modeling, eqs. solref_standard and solref_direct: a time
    constant T and damping ratio z are k = 1 / (T z)^2 and b = 2 / T.
    """
    first, second = (float(value) for value in pair.solref)
    if first > 0.0:
        return 1.0 / (first * second) ** 2, 2.0 / first
    return -first, -second


def tell(pair: Any, k: float, b: float) -> None:
    """Give a pair the stiffness k, 1/s2, and damping b, 1/s, at a constant impedance.

    Friction is damped at least critically: with the damping of a bouncy spring it would
    not stop what slides. MuJoCo heeds that under an elliptic cone only.
    """
    pair.solref = (-k, -b)
    pair.solreffriction = (-k, -max(b, 2.0 * math.sqrt(k)))
    pair.solimp = (IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0)


def effective_masses(spec: Any, pairs: list[Any], where: str) -> list[float]:
    """Return the effective mass of each pair's contact, kg.

    One over the sum of both bodies' `body_invweight0`, the mean inverse inertia of the
    body's centre of mass at the description's pose, which is how MuJoCo scales contacts. For
    one free body it is its mass, and in water the added mass, too; for the foot of a leg it is
    what the leg lets one feel.

    Raises:
        EffectError: MuJoCo refuses the description as it stands.
    """
    try:
        model = fluid.settle(spec.copy().compile())
    except ValueError as error:
        raise EffectError(
            f"MuJoCo refuses the description: {error}",
            where=where,
            fix="check the effects before this one against the robot's masses",
        ) from error
    bodies = [
        [int(model.geom(name).bodyid[0]) for name in (pair.geomname1, pair.geomname2)]
        for pair in pairs
    ]
    weights = np.asarray(model.body_invweight0)[:, 0]
    return [float(1.0 / max(weights[pair].sum(), 1e-15)) for pair in bodies]


def settle(pair: Any, k: float, b: float, step: float, where: str) -> None:
    """Give a pair a stiffness k, 1/s2, and damping b, 1/s, that the step can follow.

    The step h is taken with forces from its start, so a spring needs k h^2 < 1 (four
    are its limit) and a damper b h < 1 (more would turn the speed round in one step).

    Raises:
        EffectError: The step is too long for either.
    """
    needed = min(1.0 / math.sqrt(k), 1.0 / max(b, 1e-9))
    if step > needed:
        raise EffectError(
            f"its stiffness {k:.3g} 1/s2 and damping {b:.3g} 1/s for each kg of effective mass "
            f"are too much for a step of {step:g} s",
            where=where,
            fix=f"take a step of at most {needed:.2g} s, or a softer contact",
        )
    tell(pair, k, b)
