"""What may be left out of a description, row by row, as `effects.md` states each law."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from experiments.conceal.equations import Array

JOINT_LAWS = (
    "viscous_friction",
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_damping",
    "joint_stiffness",
    "armature",
)
ACTUATOR_LAWS = ("actuator_delay", "actuator_lag", "torque_scale")
SENSOR_LAWS = ("sensor_bias",)
LAWS = JOINT_LAWS + ACTUATOR_LAWS + SENSOR_LAWS
FIELDS = {
    "viscous_friction": {"b": "viscous"},
    "coulomb_friction": {"c": "coulomb"},
    "stribeck_friction": {"c": "coulomb", "s": "static", "vs": "fade"},
    "quadratic_damping": {"b2": "quadratic"},
    "joint_stiffness": {"k": "stiffness", "q0": "rest"},
    "armature": {"J": "armature"},
    "actuator_delay": {"T": "delay"},
    "actuator_lag": {"T": "lag"},
    "torque_scale": {"gain": "gain"},
    "sensor_bias": {"bias": "offset"},
}
"""Which field of `Laws` each parameter of an effect fills."""


@dataclass(frozen=True, kw_only=True)
class Laws:
    """Every law at once; a row without an effect holds the neutral values.

    All fields have shape (joints, rows); an actuator has its joint's index.
    """

    viscous: Array
    """b of -b v."""
    coulomb: Array
    """c, the dry friction of fast motion."""
    static: Array
    """s, the dry friction at rest; at most c means that nothing is added."""
    fade: Array
    """vs, the speed at which what s adds has fallen to 1/e."""
    quadratic: Array
    """b2 of -b2 v |v|."""
    stiffness: Array
    """k of -k (q - q0)."""
    rest: Array
    """q0."""
    armature: Array
    """J added on the diagonal of M."""
    delay: Array
    """T by which a command acts late, s."""
    lag: Array
    """T of a first-order lag, s."""
    gain: Array
    """Torque produced over torque commanded."""
    offset: Array
    """What the position's sensor adds."""

    def level(self, v: Array) -> Array:
        """Return the greatest dry friction at each velocity: c + (s - c) exp(-(v/vs)^2)."""
        extra = np.maximum(self.static - self.coulomb, 0.0)
        if not extra.any():
            return self.coulomb
        return np.asarray(self.coulomb + extra * np.exp(-((v / self.fade) ** 2)))

    def smooth(self, q: Array, v: Array) -> Array:
        """Return the torques that are smooth in the state, shape (joints, rows)."""
        return np.asarray(
            -(self.viscous + self.quadratic * np.abs(v)) * v - self.stiffness * (q - self.rest)
        )

    @property
    def dry(self) -> bool:
        """Whether any row has dry friction."""
        return bool((self.coulomb > 0).any() or (self.static > 0).any())

    def repeated(self, count: int) -> Laws:
        """Return each row `count` times in succession."""
        return Laws(
            **{f.name: np.repeat(getattr(self, f.name), count, axis=1) for f in fields(self)}
        )

    def put(self, effect: str, joint: int, row: int | slice, parameters: dict[str, float]) -> Laws:
        """Return a copy in which some rows have an effect; a gain multiplies what is there."""
        changed: dict[str, Array] = {}
        for symbol, name in FIELDS[effect].items():
            array = getattr(self, name).copy()
            if name == "gain":
                array[joint, row] *= parameters[symbol]
            else:
                array[joint, row] = parameters[symbol]
            changed[name] = array
        return replace(self, **changed)


def neutral(joints: int, rows: int) -> Laws:
    """Return laws that change nothing."""
    ones = {"gain", "fade"}
    return Laws(
        **{f.name: np.full((joints, rows), 1.0 if f.name in ones else 0.0) for f in fields(Laws)}
    )
