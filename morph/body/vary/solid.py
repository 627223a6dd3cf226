"""Uniform solids: their inertia about their centre."""

from __future__ import annotations

SHAPES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}
"""How many sizes each takes: three edges; a radius; a radius and a length along z, m."""


def solid_inertia(shape: str, size: tuple[float, ...], mass: float) -> tuple[float, float, float]:
    """Return the principal inertias x, y, z of a uniform solid about its centre, kg m2.

    Box: m (b^2 + c^2) / 12. Sphere: 2 m r^2 / 5. Cylinder: m r^2 / 2 along its
    axis, m (3 r^2 + l^2) / 12 across. A capsule is a cylinder of length l, whose
    ends are the halves of a sphere with their centres of mass 3 r / 8 beyond it
    (Meriam and Kraige, Engineering Mechanics: Dynamics, appendix D).

    Args:
        shape: A key of `SHAPES`.
        size: As `SHAPES` says; a capsule's length is that between the centres of its ends.
        mass: kg.
    """
    if shape == "box":
        a, b, c = (edge**2 for edge in size)
        return mass * (b + c) / 12, mass * (a + c) / 12, mass * (a + b) / 12
    r = size[0]
    if shape == "sphere":
        same = 2 * mass * r**2 / 5
        return same, same, same
    length = size[1]
    ball = mass * (4 * r / (4 * r + 3 * length)) if shape == "capsule" else 0.0
    rod = mass - ball
    along = rod * r**2 / 2 + 2 * ball * r**2 / 5
    # About the middle: 2/5 r^2 less what a half loses to its own centre, then moved out.
    ends = ball * (2 * r**2 / 5 + length**2 / 4 + 3 * r * length / 8)
    across = rod * (3 * r**2 + length**2) / 12 + ends
    return across, across, along
