"""Whether parts collide where joints move them: intersections along each joint's range."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from morph.print.errors import SolidError
from morph.print.joint_sweep import TOUCH_MM3, Met, Sweep, told
from morph.print.part import Check, Hinge, Part
from morph.print.printer import Profile

NAME = "clearance"
BLOCKED = 0.05
"""More of the range than this beyond a collision refuses the joint."""
INSIDE = 0.01
"""Most of a printed part that may lie in another before anything moves."""
COARSE_MM = 0.05
"""How far surfaces may be moved to have fewer triangles to look at."""
CROWDED_MM3 = 50.0
"""Room that two bought bodies may share, as drawings round their sizes."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkSolids:
    """The solids of one link, in the world with all joints at zero."""

    solids: tuple[tuple[str, Any], ...]
    """Each part's name and its `manifold3d.Manifold`."""
    printed: dict[str, float]
    """Volume of each part that is printed, mm3, by its name."""
    unknown: tuple[str, ...]
    """Parts that are no solid and so are left out."""

    @property
    def bought(self) -> tuple[tuple[str, Any], ...]:
        """Those of its solids that are not printed."""
        return tuple(each for each in self.solids if each[0] not in self.printed)


def clearances(
    parts: Sequence[Part], hinges: Sequence[Hinge], profile: Profile
) -> tuple[Check, ...]:
    """Return for each joint whether its two links stay clear of each other along its range.

    The parts of the moving link, printed and bought, are carried along the joint in steps of at
    most `STEP_MM`, and intersected with those of the link that stays. Links further along the
    tree are left out, as are two links that no joint connects. Parts that lie in each other
    where nothing has moved, such as a horn on its spline, count as in the way only where they
    lie in each other by more than there.

    Args:
        parts: With their placements in the world, all joints at zero.
        hinges: The joints.
        profile: How it is printed; not used yet, since play is in the parts already.
    """
    del profile
    groups: dict[str, LinkSolids] = {}
    for link in {name for hinge in hinges for name in (hinge.still, hinge.moving)}:
        groups[link] = _group(parts, link)
    return tuple(_clearance(hinge, groups[hinge.still], groups[hinge.moving]) for hinge in hinges)


def _group(parts: Sequence[Part], link: str) -> LinkSolids:
    solids, unknown, printed = [], [], {}
    for part in parts:
        for placement in part.placements:
            if placement.link != link or part.kind == "fused":
                continue
            try:
                if part.mesh is None:
                    continue
                solid = part.mesh.moved(placement.world).manifold.simplify(COARSE_MM)
                solids.append((part.name, solid))
                if part.kind == "printed":
                    printed[part.name] = float(solid.volume())
            except SolidError:
                unknown.append(part.name)
    return LinkSolids(solids=tuple(solids), printed=printed, unknown=tuple(unknown))


def _clearance(hinge: Hinge, still: LinkSolids, moving: LinkSolids) -> Check:
    left_out = sorted({*still.unknown, *moving.unknown})
    note = f"; without {', '.join(left_out)}, no solid" if left_out else ""
    if not still.solids or not moving.solids:
        what = f"nothing to look at: {hinge.still} or {hinge.moving} has no solid part{note}"
        return _says(hinge, "passed" if not left_out else "noted", what)
    drawn = Sweep(hinge, still.bought, moving.bought)
    sweep = Sweep(hinge, still.solids, moving.solids)
    room = _Free.of(drawn)
    crowded = [pair for pair, volume in drawn.rest.items() if volume > CROWDED_MM3]
    if crowded and room.blocked > BLOCKED:
        return _drawn_together(hinge, drawn, room)
    for (one, other), volume in sweep.rest.items():
        both = [
            side[name]
            for side, name in ((still.printed, one), (moving.printed, other))
            if name in side
        ]
        if volume > TOUCH_MM3 and len(both) == 2 and volume > INSIDE * min(both):
            what = f"{other} and {one} lie in each other by {volume:.3g} mm3 before anything moves"
            return _says(hinge, "refused", what, "move them apart, or join them into one part")
    return _judged(hinge, sweep, room, note)


def _says(
    hinge: Hinge,
    verdict: Literal["passed", "noted", "refused"],
    what: str,
    fix: str = "",
    value: float | None = None,
) -> Check:
    limit = None if value is None else BLOCKED
    return Check(
        part=hinge.name, name=NAME, verdict=verdict, what=what, fix=fix, value=value, limit=limit
    )


@dataclass(frozen=True, kw_only=True)
class _Free:
    """How far a joint moves, and what stops it."""

    below: float
    """Down to here."""
    above: float
    """Up to here."""
    met: Met | None
    """What is met there; nothing if all of the range is free."""
    at: float
    """Where that is."""
    blocked: float
    """Part of the range that is not free, 0 to 1."""

    @staticmethod
    def of(sweep: Sweep) -> _Free:
        """Return how far a joint moves."""
        below, under = sweep.free_to(sweep.low)
        above, over = sweep.free_to(sweep.high)
        span = max(sweep.high - sweep.low, 1e-9)
        return _Free(
            below=below,
            above=above,
            met=under or over,
            at=below if under else above,
            blocked=1.0 - (above - below) / span if under or over else 0.0,
        )


def _drawn_together(hinge: Hinge, drawn: Sweep, room: _Free) -> Check:
    """Return the check of a joint whose bought bodies no printed part can bring apart."""
    (still, moving), volume = max(drawn.rest.items(), key=lambda each: each[1])
    what = (
        f"the {moving} of {hinge.moving} and the {still} of {hinge.still} are bought, and drawn "
        f"into each other by {volume / 1e3:.2g} cm3: no printed part can mend that"
    )
    fix = "move one of the two in the description; what is printed follows"
    return _says(hinge, "refused", what, fix, value=room.blocked)


def _judged(hinge: Hinge, sweep: Sweep, room: _Free, note: str) -> Check:
    free = _Free.of(sweep)
    rest = {pair: volume for pair, volume in sweep.rest.items() if volume > TOUCH_MM3}
    if rest:
        (still, moving), volume = max(rest.items(), key=lambda each: each[1])
        note = f"; {moving} and {still} share {volume:.3g} mm3 before anything moves{note}"
    whole = f"{told(hinge, sweep.low)} to {told(hinge, sweep.high)}"
    if free.met is None:
        verdict: Literal["passed", "noted"] = "noted" if note else "passed"
        return _says(hinge, verdict, f"free from {whole}{note}", value=0.0)
    if room.met is not None and free.blocked - room.blocked <= BLOCKED:
        return _drawn_in_the_way(hinge, room, free, whole, note)
    (still, moving), volume = free.met
    what = (
        f"{moving} meets {still} at {told(hinge, free.at)} ({volume:.3g} mm3); free from "
        f"{told(hinge, free.below)} to {told(hinge, free.above)} of {whole}{note}"
    )
    fix = "limit the joint to the range that is free, or move the parts apart"
    return _says(
        hinge, "refused" if free.blocked > BLOCKED else "noted", what, fix, value=free.blocked
    )


def _drawn_in_the_way(hinge: Hinge, room: _Free, free: _Free, whole: str, note: str) -> Check:
    """Return the check of a joint that bought bodies stop where they are drawn."""
    (still, moving), _ = room.met or (("", ""), 0.0)
    what = (
        f"the {moving} of {hinge.moving} meets the {still} of {hinge.still} at "
        f"{told(hinge, room.at)}: both are bought and drawn in each other's way, and the joint is "
        f"free from {told(hinge, free.below)} to {told(hinge, free.above)} of {whole}{note}"
    )
    fix = "move one of the two in the description, or limit the joint to the range that is free"
    return _says(
        hinge, "refused" if free.blocked > BLOCKED else "noted", what, fix, value=free.blocked
    )
