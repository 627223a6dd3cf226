"""Two links, a motor at each joint; both joints at 0 hang down."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array, Equations, Parameters, Reach, kinetic


class DoublePendulum(Equations):
    """Two links with relative angles; source: Spong, Hutchinson and Vidyasagar, ch. 7.

    The inertias I1 and I2 are about the centres of mass. The rotors add J on
    the diagonal only.
    """

    name = "double_pendulum"
    joints = ("shoulder", "elbow")
    actuators = ("shoulder", "elbow")
    kinds = ("hinge", "hinge")
    reach = (Reach(span=1.0, effort=2.0, speed=4.0), Reach(span=1.0, effort=1.0, speed=5.0))
    varied = ("m1", "r1", "I1", "m2", "r2", "I2")

    def nominal(self) -> dict[str, float]:
        """Return what `robots/double_pendulum` states."""
        return {
            "m1": 0.5656297340368834,
            "r1": 0.2,
            "I1": 0.0010430138022811501,
            "l1": 0.2,
            "m2": 0.64,
            "r2": 0.2830843860488245,
            "I2": 0.002590597069830336,
            "g": 9.81,
            "J_shoulder": 0.0035774212337463937,
            "J_elbow": 0.0035774212337463937,
            "d_shoulder": 0.0,
            "d_elbow": 0.0,
        }

    def mass(self, q: Array, p: Parameters) -> tuple[Array, ...]:
        """Return M(q)."""
        coupling = p["m2"] * p["l1"] * p["r2"] * np.cos(q[1])
        forearm = p["I2"] + p["m2"] * p["r2"] ** 2
        upper = p["I1"] + p["m1"] * p["r1"] ** 2 + p["m2"] * p["l1"] ** 2
        return (
            upper + forearm + 2 * coupling + p["J_shoulder"],
            forearm + coupling,
            forearm + p["J_elbow"],
        )

    def bias(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return Coriolis torques, gravity and damping."""
        pull = p["m2"] * p["l1"] * p["r2"] * np.sin(q[1])
        forearm = p["g"] * p["m2"] * p["r2"] * np.sin(q[0] + q[1])
        upper = p["g"] * (p["m1"] * p["r1"] + p["m2"] * p["l1"]) * np.sin(q[0])
        out = np.empty_like(q)
        out[0] = upper + forearm - pull * v[1] * (2 * v[0] + v[1]) + p["d_shoulder"] * v[0]
        out[1] = forearm + pull * v[0] ** 2 + p["d_elbow"] * v[1]
        return out

    def energy(self, q: Array, v: Array, p: Parameters) -> Array:
        """Return the energy above hanging at rest."""
        upper = p["g"] * (p["m1"] * p["r1"] + p["m2"] * p["l1"]) * (1 - np.cos(q[0]))
        forearm = p["g"] * p["m2"] * p["r2"] * (1 - np.cos(q[0] + q[1]))
        return np.asarray(kinetic(self.mass(q, p), v) + upper + forearm)
