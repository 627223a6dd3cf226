"""A cart on a rail with a pole; the hinge's q = 0 hangs down."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array, Equations, Parameters, Reach, kinetic


class Cartpole(Equations):
    """A pole of centre distance r on a cart of mass M.

    (M + m) x'' + m r cos(t) t'' - m r sin(t) t'^2 + d x' = F and
    (I + m r^2) t'' + m r cos(t) x'' + m g r sin(t) = 0, from the Lagrangian
    with the pole's centre at (x + r sin t, -r cos t).
    """

    name = "cartpole"
    joints = ("slide", "hinge")
    actuators = ("slide",)
    kinds = ("slide", "hinge")
    reach = (Reach(span=0.7, effort=4.0, speed=1.5), Reach(span=1.2, effort=0.6, speed=5.0))
    varied = ("M", "m", "r", "I")

    def nominal(self) -> dict[str, float]:
        """Return what `robots/cartpole` states: a uniform rod of 0.5 m and 0.5 kg."""
        return {
            "M": 0.5,
            "m": 0.5,
            "r": 0.25,
            "I": 0.5 * 0.5**2 / 12,
            "g": 9.82,
            "J_slide": 0.0,
            "J_hinge": 0.0,
            "d_slide": 0.1,
            "d_hinge": 0.0,
        }

    def mass(self, q: Array, p: Parameters) -> tuple[Array, ...]:
        """Return M(q)."""
        moment = p["m"] * p["r"]
        return (
            p["M"] + p["m"] + p["J_slide"],
            moment * np.cos(q[1]),
            p["I"] + moment * p["r"] + p["J_hinge"],
        )

    def bias(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return the centrifugal force, gravity and damping."""
        pull = p["m"] * p["r"] * np.sin(q[1])
        out = np.empty_like(q)
        out[0] = p["d_slide"] * v[0] - pull * v[1] ** 2
        out[1] = p["g"] * pull + p["d_hinge"] * v[1]
        return out

    def energy(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return the energy above hanging at rest."""
        potential = p["m"] * p["g"] * p["r"] * (1 - np.cos(q[1]))
        return np.asarray(kinetic(self.mass(q, p), v) + potential)
