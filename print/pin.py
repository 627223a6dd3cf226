"""Pins that let two pieces go together one way only, and where in a section they have room."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.printer import Profile
from morph.print.section import Section, section

RADII_MM = (5.0, 4.0, 3.5, 3.0, 2.5, 2.0, 1.75, 1.5, 1.25)
"""Radii of the thicker pin, the best first; a pin of 2.5 mm is the thinnest that stands a knock."""

THINNER_MM = 0.75
"""By how much the second pin's radius is less: more than the play, or it would go in both holes."""

LENGTH = 2.0
"""Length of a pin in its diameters."""

LONGEST_MM = 10.0
"""Length that no pin exceeds."""

ROOT_MM = 1.0
"""How deep a pin begins in the piece that it belongs to."""

TIP_MM = 0.6
"""How much its tip is tapered, so that it finds its hole."""

MOUTH_MM = 0.1
"""How far before the plane a hole begins."""

FLAT = 0.4
"""How far the flat of a lone pin lies from its middle, in its radius: as a D it goes in one way."""

STEP_MM = 1.5
"""Least difference between how far apart two joints' pins stand."""

SIDES = 48
"""Sides of a round pin."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pin:
    """A pin that stands on a plane z = 0, z along it."""

    middle: Array
    """Where it stands, mm, shape (2,)."""
    radius: float
    """mm."""
    length: float
    """Out of the plane, mm."""
    flat: bool = False
    """Whether it is a D rather than round."""

    def solid(self) -> Any:
        """Return the pin with its root as a `manifold3d.Manifold`."""
        import manifold3d

        shaft = self._outline(self.radius).extrude(ROOT_MM + self.length - TIP_MM)
        scale = 1.0 - TIP_MM / (2.0 * self.radius)
        tip = self._outline(self.radius).extrude(TIP_MM, 0, 0.0, (scale, scale))
        tip = tip.translate((0.0, 0.0, ROOT_MM + self.length - TIP_MM))
        whole = manifold3d.Manifold.batch_boolean([shaft, tip], manifold3d.OpType.Add)
        return whole.translate((*self.middle, -ROOT_MM))

    def hole(self, play: float) -> Any:
        """Return what must be empty for it, with play on each side, mm.

        It begins a little before the plane, so that no skin is left over its mouth.
        """
        return self._room(play, self.length + 2.0 * play, before=MOUTH_MM)

    def walled(self, play: float, wall: float) -> Any:
        """Return the hole with a wall around it and below it, mm."""
        return self._room(play + wall, self.length + 2.0 * play + wall)

    def _room(self, around: float, deep: float, *, before: float = 0.0) -> Any:
        shape = self._outline(self.radius)
        if around > 0.0:
            import manifold3d

            shape = shape.offset(around, manifold3d.JoinType.Miter, 2.0)
        return shape.extrude(before + deep).translate((*self.middle, -before))

    def _outline(self, radius: float) -> Any:
        import manifold3d

        disc = manifold3d.CrossSection.circle(radius, SIDES)
        if not self.flat:
            return disc
        keep = manifold3d.CrossSection.square((2.0 * radius, (1.0 + FLAT) * radius))
        return disc ^ keep.translate((-radius, -radius))


def pins(low: Any, high: Any, profile: Profile, *, mark: int = 0) -> tuple[Pin, ...]:
    """Return pins on one solid that go into another: two unlike ones, or one D; none if no room.

    Args:
        low: A `manifold3d.Manifold` below z = 0 that gets the pins.
        high: One above it that gets the holes.
        profile: Names the play, and the wall that must stay around a hole.
        mark: Sets two pins nearer together by so many steps, if they still have room, so that of
            many pieces only those go together that belong together.
    """
    wall, play = profile.thinnest_mm, profile.clearance_mm
    results: dict[float, Section | None] = {}
    slight = section(common(low, high, LENGTH * 2.0 * RADII_MM[-1] + 2.0 * play + wall))
    if slight is None or slight.deepest < RADII_MM[-1] + play + wall:
        return ()
    for alone in (False, True):
        for radius in RADII_MM:
            length = min(LENGTH * 2.0 * radius, LONGEST_MM)
            if length not in results:
                results[length] = section(common(low, high, length + 2.0 * play + wall))
            room = results[length]
            if room is None:
                continue
            chosen = _lone(room, radius, length, play + wall)
            if not alone:
                chosen = _marked(_pair(room, radius, length, play + wall), mark, room, play, wall)
            if chosen and all(_held(high, pin, profile) for pin in chosen):
                return chosen
    return ()


def common(low: Any, high: Any, depth: float) -> Any:
    """Return what is material on both sides of z = 0, down to the roots and up to a depth, mm."""
    import manifold3d

    near = 0.02
    sections = [low.slice(-near), low.slice(-ROOT_MM)]
    sections += [high.slice(float(at)) for at in np.linspace(near, depth, 6)]
    return manifold3d.CrossSection.batch_boolean(sections, manifold3d.OpType.Intersect)


def _pair(room: Section, radius: float, length: float, around: float) -> tuple[Pin, ...]:
    """Return a thicker and a thinner pin as far apart as the section lets them be."""
    thin = radius - THINNER_MM
    if thin < RADII_MM[-1]:
        return ()
    thick_at, thin_at = room.outermost(radius + around), room.outermost(thin + around)
    if not len(thick_at):
        return ()
    angle = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    ways = np.stack([np.cos(angle), np.sin(angle)])
    first = thick_at[np.argmax(thick_at @ ways, axis=0)]
    second = thin_at[np.argmin(thin_at @ ways, axis=0)]
    apart = np.linalg.norm(first - second, axis=1)
    best = int(np.argmax(apart))
    if apart[best] < radius + thin + 2.0 * around:
        return ()
    return (
        Pin(middle=first[best], radius=radius, length=length),
        Pin(middle=second[best], radius=thin, length=length),
    )


def _marked(
    pair: tuple[Pin, ...], mark: int, room: Section, play: float, wall: float
) -> tuple[Pin, ...]:
    """Return two pins nearer together; as they were where the second would have no room."""
    if not pair or mark == 0:
        return pair
    thick, thin = pair
    apart = float(np.linalg.norm(thick.middle - thin.middle))
    # Two holes give way by twice the play; a step is more, or a wrong piece would go on.
    nearer = mark * max(STEP_MM, 3.0 * play)
    if apart - nearer < thick.radius + thin.radius + 2.0 * (play + wall):
        return pair
    middle = thin.middle + (thick.middle - thin.middle) * (nearer / apart)
    if room.at(middle) < thin.radius + play + wall:
        return pair
    return (thick, replace(thin, middle=middle))


def _lone(room: Section, radius: float, length: float, around: float) -> tuple[Pin, ...]:
    """Return a D in the deepest place."""
    if room.deepest < radius + around:
        return ()
    row, column = np.unravel_index(int(np.argmax(room.depth)), room.depth.shape)
    middle = room.origin + room.pitch * np.array([column, row])
    return (Pin(middle=middle, radius=radius, length=length, flat=True),)


def _held(high: Any, pin: Pin, profile: Profile) -> bool:
    """Return whether a hole has its whole wall in a solid; sections alone are samples."""
    walled = pin.walled(profile.clearance_mm, 0.5 * profile.thinnest_mm)
    return bool((walled - high).volume() < 1e-3 * walled.volume())
