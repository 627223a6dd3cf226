"""The planar four-bar: angles, range, transmission and ratios in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import RobotError


@dataclass(frozen=True, kw_only=True)
class FourBar:
    """A planar four-bar.

    `ground` joins two pivots, `crank` turns about the first, `rocker` about the second, and
    `coupler` joins their ends. Angles are measured from the line that runs from the crank's
    pivot to the rocker's. Source: Freudenstein 1955, Trans. ASME 77; Norton 2012, Design of
    Machinery, 5th ed., chapters 2 (Grashof), 4 (position) and 6 (velocity, virtual work).
    """

    ground: float
    """Distance between the pivots, m."""
    crank: float
    """Length of the crank, which is driven, m."""
    coupler: float
    """Length of the coupler, m."""
    rocker: float
    """Length of the rocker, which is moved, m."""
    branch: int = 1
    """1 if the rocker is ahead of the line from the crank's end to the far pivot, else -1."""

    def __post_init__(self) -> None:
        lengths = (self.ground, self.crank, self.coupler, self.rocker)
        if min(lengths) <= 0.0 or 2.0 * max(lengths) > sum(lengths) or self.branch not in (1, -1):
            raise RobotError(
                f"lengths {lengths} m on branch {self.branch} close at no angle",
                where="four-bar",
                fix="make each length shorter than the other three together; branch is 1 or -1",
            )

    @classmethod
    def of(cls, pivot: Array, crank_pin: Array, rocker_pin: Array, far_pivot: Array) -> FourBar:
        """Return the four-bar through four points in its plane, m, each of shape (2,)."""
        points = [np.asarray(point, float) for point in (pivot, crank_pin, rocker_pin, far_pivot)]
        sides = [points[i] - points[i - 1] for i in range(4)]
        diagonal, rocker = points[3] - points[1], points[2] - points[3]
        turn = diagonal[0] * rocker[1] - diagonal[1] * rocker[0]
        ground, crank, coupler, arm = (float(np.linalg.norm(side)) for side in sides)
        branch = 1 if turn >= 0.0 else -1
        return cls(ground=ground, crank=crank, coupler=coupler, rocker=arm, branch=branch)

    @property
    def kind(self) -> str:
        """What Grashof's condition makes of it.

        `crank-rocker`, `double-crank`, `rocker-crank` or `double-rocker` by the shortest
        link, if shortest and longest are together shorter than the other two; `change-point`
        if they are equal; `triple-rocker` otherwise.
        """
        lengths = (self.crank, self.ground, self.rocker, self.coupler)
        slack = sum(lengths) - 2.0 * (max(lengths) + min(lengths))
        if abs(slack) < 1e-12:
            return "change-point"
        if slack < 0.0:
            return "triple-rocker"
        names = ("crank-rocker", "double-crank", "rocker-crank", "double-rocker")
        return names[int(np.argmin(lengths))]

    def crank_range(self) -> tuple[tuple[float, float], ...]:
        """Return the intervals of the crank's angle, rad, at which it closes.

        The diagonal from the crank's end to the far pivot must fit the triangle of coupler
        and rocker. One interval of width 2 pi if the crank turns fully; two intervals if
        it must not pass the line of the pivots on either side.
        """
        squares, product = self.ground**2 + self.crank**2, 2.0 * self.ground * self.crank
        nearest = (squares - (self.coupler - self.rocker) ** 2) / product
        farthest = (squares - (self.coupler + self.rocker) ** 2) / product
        low = float(np.arccos(min(nearest, 1.0)))
        high = float(np.arccos(max(farthest, -1.0)))
        if nearest >= 1.0:
            return ((-high, high),)
        if farthest <= -1.0:
            return ((low, 2.0 * np.pi - low),)
        return ((-high, -low), (low, high))

    def rocker_angle(self, crank_angle: Array | float) -> Array:
        """Return the rocker's angle, rad, at the crank's; shape as given.

        Raises:
            RobotError: The chain does not close at one of the angles.
        """
        angle = np.asarray(crank_angle, float)
        x = self.ground - self.crank * np.cos(angle)
        y = -self.crank * np.sin(angle)
        diagonal = np.hypot(x, y)
        cosine = (self.coupler**2 - self.rocker**2 - diagonal**2) / (2.0 * self.rocker * diagonal)
        if not np.all(np.abs(cosine) <= 1.0):
            shut = np.ravel(angle)[int(np.argmax(np.ravel(np.abs(cosine))))]
            raise RobotError(
                f"does not close at a crank angle of {shut:.6g} rad",
                where="four-bar",
                fix="keep the crank within "
                + " or ".join(f"{low:.6g} to {high:.6g} rad" for low, high in self.crank_range()),
            )
        result: Array = np.arctan2(y, x) + self.branch * np.arccos(cosine)
        return np.asarray((result + np.pi) % (2.0 * np.pi) - np.pi)

    def coupler_angle(self, crank_angle: Array | float) -> Array:
        """Return the angle of the coupler, rad, seen from the crank's end; shape as given."""
        angle, rocker = np.asarray(crank_angle, float), self.rocker_angle(crank_angle)
        x = self.ground + self.rocker * np.cos(rocker) - self.crank * np.cos(angle)
        y = self.rocker * np.sin(rocker) - self.crank * np.sin(angle)
        return np.asarray(np.arctan2(y, x))

    def transmission_angle(self, crank_angle: Array | float) -> Array:
        """Return the angle between coupler and rocker, 0 to pi/2 rad; shape as given.

        At pi/2 all of the coupler's force turns the rocker, at 0 none (Norton, chapter 3).
        """
        between = self.coupler_angle(crank_angle) - self.rocker_angle(crank_angle)
        return np.asarray(np.arcsin(np.abs(np.sin(between))))

    def velocity_ratio(self, crank_angle: Array | float) -> Array:
        """Return the rocker's velocity per that of the crank; shape as given."""
        angle, coupler = np.asarray(crank_angle, float), self.coupler_angle(crank_angle)
        moved = self.rocker * np.sin(self.rocker_angle(crank_angle) - coupler)
        return np.asarray(self.crank * np.sin(angle - coupler) / moved)

    def torque_ratio(self, crank_angle: Array | float) -> Array:
        """Return the torque at the rocker per torque at the crank, by virtual work."""
        return np.asarray(1.0 / self.velocity_ratio(crank_angle))
