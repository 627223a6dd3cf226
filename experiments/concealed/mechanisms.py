"""The mechanisms of the benchmark, each with figures drawn anew for every case."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from experiments.concealed.mechanism import (
    NONE,
    SERVO,
    TORQUE,
    Link,
    Mechanism,
    chain,
    drive,
)

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
Vector = tuple[float, float, float]
Drawn = tuple[list[Link], float, bool]
"""Links, highest frequency of slow excitation (Hz), whether drives may be cut off."""


def _near(rng: np.random.Generator, value: float) -> float:
    """Return a figure within a factor of 1.4 of a typical one."""
    return float(value * np.exp(rng.uniform(-1, 1) * np.log(1.4)))


def _near_all(rng: np.random.Generator, values: Vector) -> Vector:
    x, y, z = (_near(rng, value) if value else 0.0 for value in values)
    return x, y, z


def _down(rng: np.random.Generator, length: float) -> Vector:
    return (0.0, 0.0, -_near(rng, length))


def _pendulum(rng: np.random.Generator) -> Drawn:
    return [Link(axis=Y, reach=_down(rng, 0.6), mass=_near(rng, 1.3), span=1.1)], 1.0, True


def _cart_pole(rng: np.random.Generator) -> Drawn:
    cart = Link(
        axis=X, reach=(0.0, 0.03, 0.0), mass=_near(rng, 1.1), slide=True, span=0.35,
        damping=_near(rng, 0.4), thickness=0.06,
    )  # fmt: skip
    return (
        [cart, Link(axis=Y, reach=_down(rng, 0.45), mass=_near(rng, 0.35), drive=NONE)],
        0.8,
        True,
    )


def _double_pendulum(rng: np.random.Generator) -> Drawn:
    rotor, other = _near(rng, 0.004), _near(rng, 0.002)
    upper = Link(axis=Y, reach=_down(rng, 0.28), mass=_near(rng, 0.8), rotor=rotor, span=0.9)
    lower = Link(axis=Y, reach=_down(rng, 0.25), mass=_near(rng, 0.5), rotor=other, span=0.9)
    return [upper, lower], 1.0, True


def _leg(rng: np.random.Generator) -> Drawn:
    hip = Link(
        axis=X, reach=(0.0, _near(rng, 0.07), 0.0), mass=_near(rng, 0.7),
        rotor=_near(rng, 0.006), span=0.4,
    )  # fmt: skip
    thigh = Link(
        axis=Y, reach=_down(rng, 0.21), mass=_near(rng, 0.9), rotor=_near(rng, 0.006), span=0.7,
        home=0.3,
    )  # fmt: skip
    shank = Link(
        axis=Y, reach=_down(rng, 0.22), mass=_near(rng, 0.25), rotor=_near(rng, 0.006), span=0.7,
        home=-0.6, damping=_near(rng, 0.02),
    )  # fmt: skip
    return [hip, thigh, shank], 1.2, True


def _servo_arm(rng: np.random.Generator) -> Drawn:
    turn = Link(axis=Z, reach=(0.0, 0.0, _near(rng, 0.06)), mass=_near(rng, 0.25),
                rotor=_near(rng, 0.02), drive=SERVO, span=0.9)  # fmt: skip
    upper = Link(axis=Y, reach=(0.0, 0.0, _near(rng, 0.13)), mass=_near(rng, 0.2), home=0.5,
                 rotor=_near(rng, 0.02), drive=SERVO)  # fmt: skip
    fore = Link(axis=Y, reach=(_near(rng, 0.12), 0.0, 0.0), mass=_near(rng, 0.15),
                rotor=_near(rng, 0.02), drive=SERVO)  # fmt: skip
    wrist = Link(axis=Y, reach=(_near(rng, 0.09), 0.0, 0.0), mass=_near(rng, 0.12), home=0.4,
                 rotor=_near(rng, 0.01), drive=SERVO, thickness=0.02)  # fmt: skip
    return [turn, upper, fore, wrist], 0.7, False


def _arm(rng: np.random.Generator, joints: int, kind: int) -> list[Link]:
    """Return an arm whose axes turn as those of industrial arms do: z, y, y, x, y, x, ..."""
    plan = [
        (Z, (0.0, 0.0, 0.25), 7.0, 0.6, 0.9, 0.0),
        (Y, (0.0, 0.0, 0.40), 6.0, 0.6, 0.5, 0.4),
        (Y, (0.30, 0.0, 0.0), 4.0, 0.3, 0.5, -0.3),
        (X, (0.12, 0.0, 0.0), 2.0, 0.1, 0.8, 0.5),
        (Y, (0.10, 0.0, 0.0), 1.5, 0.1, 0.7, 0.6),
        (X, (0.07, 0.01, 0.0), 0.6, 0.05, 0.9, 0.0),
    ]
    if joints == 7:
        plan.insert(2, (Z, (0.0, 0.0, 0.12), 3.0, 0.3, 0.7, 0.3))
    return [
        Link(
            axis=axis, reach=_near_all(rng, reach),
            mass=_near(rng, mass), rotor=_near(rng, rotor), span=span, home=home, drive=kind,
            thickness=0.06,
        )
        for axis, reach, mass, rotor, span, home in plan
    ]  # fmt: skip


def _six_joint_arm(rng: np.random.Generator) -> Drawn:
    return _arm(rng, 6, int(rng.choice([TORQUE, SERVO]))), 0.5, False


def _seven_joint_arm(rng: np.random.Generator) -> Drawn:
    return _arm(rng, 7, TORQUE), 0.5, False


def _submerged_arm(rng: np.random.Generator) -> Drawn:
    base = Link(axis=Z, reach=(_near(rng, 0.1), 0.0, 0.0), mass=_near(rng, 1.2), span=0.8,
                rotor=_near(rng, 0.01), drive=SERVO)  # fmt: skip
    upper = Link(axis=Y, reach=(_near(rng, 0.3), 0.0, 0.0), mass=_near(rng, 1.0), span=0.7,
                 rotor=_near(rng, 0.01), drive=SERVO)  # fmt: skip
    paddle = Link(axis=Z, reach=(_near(rng, 0.25), 0.0, 0.0), mass=_near(rng, 0.5), span=0.8,
                  rotor=_near(rng, 0.01), drive=SERVO)  # fmt: skip
    return [base, upper, paddle], 0.8, False


FAMILIES: Mapping[str, Callable[[np.random.Generator], Drawn]] = {
    "pendulum": _pendulum,
    "cart_pole": _cart_pole,
    "double_pendulum": _double_pendulum,
    "leg": _leg,
    "servo_arm": _servo_arm,
    "six_joint_arm": _six_joint_arm,
    "seven_joint_arm": _seven_joint_arm,
    "submerged_arm": _submerged_arm,
}
"""How each kind of mechanism is drawn."""

SYLLABLES = (
    "ba",
    "do",
    "fi",
    "ga",
    "ku",
    "lem",
    "mor",
    "nit",
    "po",
    "rus",
    "sel",
    "ta",
    "vo",
    "zan",
)


def _names(rng: np.random.Generator, count: int) -> list[str]:
    """Return distinct names that say nothing of what they name."""
    names: list[str] = []
    while len(names) < count:
        name = "".join(str(each) for each in rng.choice(SYLLABLES, 3))
        if name not in names:
            names.append(name)
    return names


def draw_mechanism(family: str, rng: np.random.Generator) -> Mechanism:
    """Return a mechanism of a family with figures, frames and names drawn at random."""
    links, rate, coasts = FAMILIES[family](rng)
    plant = drive(chain(links, rng), links, rng.uniform(3.0, 7.0), rng.uniform(0.8, 1.6))
    names = _names(rng, 2 * len(links))
    return Mechanism(
        family=family,
        plant=plant,
        links=tuple(names[: len(links)]),
        joints=tuple(names[len(links) :]),
        home=np.array([link.home for link in links]),
        span=np.array([link.span for link in links]),
        rate=rate,
        submerged=family == "submerged_arm",
        coasts=coasts,
    )
