"""A rigid pendulum on a motor; q = 0 hangs down."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array, Equations, Parameters, Reach, kinetic


class Pendulum(Equations):
    """(I + m r^2 + J) a + d v + m g r sin q = tau."""

    name = "pendulum"
    joints = ("hinge",)
    actuators = ("hinge",)
    kinds = ("hinge",)
    reach = (Reach(span=1.3, effort=3.0, speed=3.0),)
    varied = ("m", "r", "I")

    def nominal(self) -> dict[str, float]:
        """Return what `robots/pendulum` states."""
        return {"m": 1.0, "r": 0.5, "I": 0.001, "g": 9.81, "J_hinge": 0.0, "d_hinge": 0.0}

    def mass(self, q: Array, p: Parameters) -> tuple[Array, ...]:
        """Return the inertia about the hinge."""
        return (p["I"] + p["m"] * p["r"] ** 2 + p["J_hinge"],)

    def bias(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return gravity's torque and damping."""
        gravity = p["m"] * p["g"] * p["r"] * np.sin(q[0])
        return np.asarray((gravity + p["d_hinge"] * v[0])[None])

    def energy(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return the energy above hanging at rest."""
        potential = p["m"] * p["g"] * p["r"] * (1 - np.cos(q[0]))
        return np.asarray(kinetic(self.mass(q, p), v) + potential)
