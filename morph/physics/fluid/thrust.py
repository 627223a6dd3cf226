"""Thrust: the momentum that a beating paddle leaves behind in its wake."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.physics.effect import parameter
from morph.physics.fluid.edge import Edge, edge_at, trailing_edge
from morph.physics.fluid.numbers import (
    CHORD,
    EDGE,
    NORMAL,
    SHED,
    add_numbers,
    numbers_of,
    write_numbers,
)
from morph.physics.kinds import BodyEffect
from morph.physics.motion import Motion


def shed_mass(span: float, density: float) -> float:
    """Return the virtual mass per length of an edge, m = rho pi / 4 s^2, kg/m.

    Source: Lighthill 1960, Note on the swimming of slender fish, J. Fluid Mech. 9: the circle
    around a flat section of span s.

    Args:
        span: Length of the edge, s, m.
        density: Density of the fluid, rho, kg/m3.
    """
    return density * math.pi / 4.0 * span**2


def tail_force(velocity: Array, chord: Array, normal: Array, mass: float) -> Array:
    """Return the force on a trailing edge, N, shape (..., 3).

    F = -m max(u, 0) w n + m w^2 t / 2, with u = v . t and w = v . n.

    The water beside the edge moves along n with it, at w, and has the momentum m w n per length.
    As the edge advances along its own chord, a length u of that water is left behind every
    second; the pressure in the plane behind the edge adds m w^2 / 2 along the chord.

    It takes -F . v = m |u| w^2 / 2 from the body: for u > 0, this is the kinetic energy of the
    wake that is laid down. It never gives any. An edge that leads (u < 0) leaves no wake; of its
    force, what pulls along the chord remains, and brakes.

    Source: Lighthill 1971, Large-amplitude elongated-body theory of fish locomotion, Proc. R.
    Soc. B 179, the terms at the tail of his momentum balance, there for u > 0.

    Args:
        velocity: Velocity v of the edge through the water, m/s, shape (..., 3).
        chord: Unit vector t from the edge into the paddle, shape (..., 3).
        normal: Unit vector n normal to the paddle, shape (..., 3).
        mass: Virtual mass m per length, kg/m.
    """
    along = np.sum(velocity * chord, axis=-1, keepdims=True)
    across = np.sum(velocity * normal, axis=-1, keepdims=True)
    left = np.maximum(along, 0.0) * across * normal
    return np.asarray(mass * (0.5 * across**2 * chord - left))


@dataclass(frozen=True, kw_only=True)
class Thrust(BodyEffect):
    """The wake of a paddle, a fin or a blade pushes it forward: C times Lighthill's force.

    At the trailing edge acts F = C m (w^2 t / 2 - max(u, 0) w n), with u and w the edge's speed
    along its chord t and along its normal n, and m = rho pi / 4 s^2 for an edge of length s.
    C = 1 is Lighthill's theory, for a flow that follows the paddle; what separates on its way
    makes it less. Where `span` is 0, edge, chord and normal come from the link's shapes.

    The inertia of the water around the paddle is `added_mass`, which without this effect leaves
    nothing behind: a paddle in a perfect fluid gets back in half of its stroke what the other
    half cost it, and a symmetric stroke moves nothing.

    Source: Lighthill 1971, Large-amplitude elongated-body theory of fish locomotion, Proc. R.
    Soc. B 179, the terms at the tail of his momentum balance.
    """

    name: ClassVar[str] = "thrust"
    strengths: ClassVar[tuple[str, ...]] = ("C",)
    dissipative: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ("torque_scale", "quadratic_drag")
    excited_by: ClassVar[str] = (
        "Fast strokes that are the same in both directions, about more than one offset, "
        "of a body that is free to move."
    )
    separate_by: ClassVar[dict[str, str]] = {
        "torque_scale": "A symmetric stroke of a paddle that trails: only thrust moves the body.",
        "quadratic_drag": "The same stroke forward and backward in time: what drag does turns "
        "round, what thrust does stays.",
    }

    body: str
    """Link it acts on: a paddle, a fin or a blade."""
    C: float = parameter(0.0, unit="-", low=0.0, high=5.0, neutral=0.0)
    """Share of Lighthill's force that acts."""
    density: float = parameter(1000.0, unit="kg/m3", low=0.01, high=2e4, free=False)
    """Density of the fluid: 1000 for fresh water, 1025 for the sea, 1.2 for air."""
    span: float = parameter(0.0, unit="m", low=0.0, high=100.0, free=False)
    """Length of the trailing edge; 0 where the link's shapes tell it and all that follows."""
    x: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """The edge's middle in the link's frame: x. The chord points from it to the link's origin."""
    y: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """The edge's middle in the link's frame: y."""
    z: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """The edge's middle in the link's frame: z."""
    nx: float = parameter(0.0, unit="-", low=-1.0, high=1.0, free=False)
    """The normal of the paddle at its edge, of any length: x."""
    ny: float = parameter(0.0, unit="-", low=-1.0, high=1.0, free=False)
    """The normal of the paddle at its edge, of any length: y."""
    nz: float = parameter(0.0, unit="-", low=-1.0, high=1.0, free=False)
    """The normal of the paddle at its edge, of any length: z."""

    @classmethod
    def of(cls, robot: Robot, body: str, C: float = 1.0, *, density: float = 1000.0) -> Thrust:
        """Return the thrust of a link with the edge that its shapes have, said in numbers.

        Raises:
            EffectError: The link is no paddle.
        """
        edge = trailing_edge(spec_of(robot).compile(), body)
        place = dict(zip(("x", "y", "z"), edge.middle.tolist(), strict=True))
        across = dict(zip(("nx", "ny", "nz"), edge.normal.tolist(), strict=True))
        return cls(body=body, C=C, density=density, span=edge.span, **place, **across)

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return nothing: what a recording is screened with has no edge yet."""
        return ()

    def edge(self, spec: Any = None) -> Edge:
        """Return the edge as told, or as a `mujoco.MjSpec` has it.

        Raises:
            EffectError: The link is no paddle, or what is told is no edge.
        """
        if self.span > 0.0:
            middle, normal = np.array([self.x, self.y, self.z]), [self.nx, self.ny, self.nz]
            return edge_at(middle, np.array(normal), self.span)
        if spec is None:
            raise EffectError(
                "its span is 0, and there are no shapes here to tell its edge",
                where=f"effect {self.label}",
                fix="give span, x, y, z and nx, ny, nz; Thrust.of(robot, link) does",
            )
        return trailing_edge(spec.copy().compile(), self.body)

    def edit(self, spec: Any) -> None:
        """Tell the fluid where the link's trailing edge is and what it sheds."""
        if self.C == 0.0:
            # Models of all coefficients run in one batch: they have the same sizes.
            add_numbers(spec, self.body, SHED, (0.0,))
            return
        edge = self.edge(spec)
        numbers = numbers_of(spec, self.body)
        if numbers[SHED.start] != 0.0:
            raise EffectError(
                f"{self.body} has a thrust already",
                where=f"effect {self.label}",
                fix="give each link one thrust",
            )
        numbers[EDGE], numbers[CHORD] = edge.middle.tolist(), edge.chord.tolist()
        numbers[NORMAL] = edge.normal.tolist()
        numbers[SHED] = [self.C * shed_mass(edge.span, self.density)]
        write_numbers(spec, self.body, numbers)

    def regressor(self, motion: Motion) -> Array:
        """Return the force for a coefficient of one."""
        body, edge = motion.bodies[self.body], self.edge()
        velocity = body.velocity[:, :3] + np.cross(body.velocity[:, 3:], edge.middle)
        mass = shed_mass(edge.span, self.density)
        force = tail_force(velocity, edge.chord, edge.normal, mass)
        load = np.concatenate([force, np.cross(edge.middle, force)], axis=1)
        return body.forces(load[:, :, None])

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"The wake of {self.body} pushes with {self.C:.3g} of the force of Lighthill's theory: "
            "thrust was left out."
        )
