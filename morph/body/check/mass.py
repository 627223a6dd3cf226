"""Whether every link has a mass and an inertia that some body could have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.check.place import WORLD, at_link
from morph.body.draft import Draft, DraftLink
from morph.body.finding import DescriptionFinding
from morph.body.inertia import DENSITY, ball, is_physical, mended
from morph.body.solids import Solid, solid, together

TOKEN_MASS, TOKEN_SIZE = 1e-6, 0.01
"""Mass, kg, and radius of gyration, m, of a link that moves and has neither mass nor shape."""


LIGHTEST, LEAST = 1e-13, 1e-14
"""Mass, kg, and inertia, kg m2, below which MuJoCo moves nothing (mjMINVAL 1e-15), with room."""


def check_mass(draft: Draft, *, base_moves: bool = False) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with masses and inertias that MuJoCo can move, and what was wrong.

    Args:
        draft: One tree.
        base_moves: Whether its base is to float, or to stand on a board.
    """
    heads, alone = _moving(draft, base_moves)
    findings: list[DescriptionFinding] = []
    changed = {}
    for link in draft.links:
        mended_link, result = _link(draft, link, link.name in heads, link.name in alone)
        changed[link.name] = mended_link
        findings.extend(result)
    return draft.with_links(changed), findings


def shape_of(link: DraftLink, *, hull: bool = False) -> Solid | None:
    """Return the solid of a link's collision shapes, or of its visual ones; None without any."""
    for role in ("collision", "visual"):
        shapes = (shape for shape in link.shapes if shape.role == role)
        result = together(one for shape in shapes if (one := solid(shape, hull=hull)) is not None)
        if result is not None:
            return result
    return None


def _moving(draft: Draft, base_moves: bool) -> tuple[set[str], set[str]]:
    """Return the links that bear a moving joint; and those that have no mass with it.

    What is welded to a link counts with it.
    """
    above, head = draft.joint_above(), draft.heads()
    heavy = {head[link.name] for link in draft.links if _is_heavy(link)}
    heads = {name for name in head.values() if name in above or (base_moves and name != WORLD)}
    return heads, heads - heavy


def _is_heavy(link: DraftLink) -> bool:
    """Return whether MuJoCo can move a link by its own mass."""
    mass = link.mass or 0.0
    if mass <= LIGHTEST:
        return False
    given = link.inertia is not None and np.any(link.inertia)
    inertia = link.inertia if given else ball(mass, DENSITY)
    # Not the trace: an inertia that no body has may add up to nothing, and its mass still counts.
    return float(np.abs(np.asarray(inertia)).max()) > LEAST


def _link(
    draft: Draft, link: DraftLink, moves: bool, alone: bool
) -> tuple[DraftLink, list[DescriptionFinding]]:
    mass = link.mass or 0.0
    if mass < 0:
        return _negative(draft, link)
    # A mass that is stated stays: where its inertia alone is next to none, that is mended.
    if mass == 0 or (alone and not _is_heavy(replace(link, inertia=None))):
        return _massless(draft, link, alone)
    if link.inertia is None or not np.any(link.inertia):
        return _no_inertia(draft, link, mass)
    thin = moves and float(np.linalg.eigvalsh(link.inertia)[0]) <= LEAST
    if is_physical(link.inertia) and not thin:
        return link, []
    return _broken(draft, link, mass, link.inertia)


def _from_shape(link: DraftLink, mass: float | None = None) -> DraftLink | None:
    result = shape_of(link)
    if result is None:
        return None
    density = DENSITY if mass is None else mass / result.volume
    inertia = result.inertia * density
    light = result.volume * density <= LIGHTEST or np.abs(inertia).max() <= LEAST
    if light or not is_physical(inertia):
        return None
    return replace(
        link,
        mass=result.volume * density,
        com=result.com if mass is None else link.com,
        inertia=inertia,
        inertia_from="mesh x density",
    )


def _negative(draft: Draft, link: DraftLink) -> tuple[DraftLink, list[DescriptionFinding]]:
    other = _from_shape(link)
    finding = DescriptionFinding(
        code="inertia-broken",
        severity="refused" if other is None else "repaired",
        where=at_link(draft, link),
        what=f"its mass is {link.mass:g} kg, which no body has",
        done="nothing" if other is None else _taken(other),
        fix="write the mass that a scale shows",
    )
    return other or link, [finding]


def _taken(link: DraftLink) -> str:
    return f"its shape at {DENSITY:g} kg/m3 was taken: {link.mass:.4g} kg"


def _massless(
    draft: Draft, link: DraftLink, alone: bool
) -> tuple[DraftLink, list[DescriptionFinding]]:
    if not alone:
        spun = link.inertia is not None and bool(np.any(link.inertia))
        bare = replace(link, mass=0.0, inertia=None, inertia_from="none")
        if link.name == WORLD or (not link.shapes and not spun):
            return bare, []
        done = "its inertia was left out" if spun else "it stayed massless"
        return bare, [
            DescriptionFinding(
                code="mass-missing",
                severity="repaired" if spun else "info",
                where=at_link(draft, link),
                what=f"it has {'an inertia' if spun else 'a shape'} and no mass",
                done=f"{done}, as what it is fixed to is weighed without it",
                fix="give it an <inertial>, unless the mass is counted in a neighbour",
            )
        ]
    other = _from_shape(link)
    if other is None:
        other = replace(
            link,
            mass=TOKEN_MASS,
            inertia=np.eye(3) * TOKEN_MASS * TOKEN_SIZE**2,
            inertia_from="none",
        )
        done = f"it got {TOKEN_MASS:g} kg, as what has no mass cannot be moved"
    else:
        done = _taken(other)
    return other, [
        DescriptionFinding(
            code="mass-missing",
            severity="repaired",
            where=at_link(draft, link),
            what=f"it moves and has {'no' if not link.mass else 'next to no'} mass, nor has "
            "anything fixed to it",
            done=done,
            fix="give it an <inertial> with its mass and inertia",
        )
    ]


def _no_inertia(
    draft: Draft, link: DraftLink, mass: float
) -> tuple[DraftLink, list[DescriptionFinding]]:
    other = _from_shape(link, mass)
    done = "its shape, filled evenly with that mass, was taken"
    if other is None:
        other = replace(link, inertia=ball(mass, DENSITY), inertia_from="none")
        done = f"that of a ball of {DENSITY:g} kg/m3 was taken"
    return other, [
        DescriptionFinding(
            code="inertia-missing",
            severity="repaired",
            where=at_link(draft, link),
            what=f"it weighs {mass:g} kg and has no rotational inertia",
            done=done,
            fix="give its <inertia>, from CAD or from its shape",
        )
    ]


def _broken(
    draft: Draft, link: DraftLink, mass: float, inertia: Array
) -> tuple[DraftLink, list[DescriptionFinding]]:
    moments = np.linalg.eigvalsh(inertia)
    shown = ", ".join(f"{value:.4g}" for value in moments)
    kind = "are not all positive" if moments[0] <= LEAST else "break the triangle inequality"
    nearest = mended(inertia)
    if nearest is not None and np.linalg.eigvalsh(nearest)[0] > LEAST:
        other, done = replace(link, inertia=nearest), "the nearest possible inertia was taken: "
    else:
        other = _from_shape(link, mass) or replace(link, inertia=ball(mass, DENSITY))
        done = "that of its shape or of a ball was taken: "
    after = ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(np.array(other.inertia)))
    return other, [
        DescriptionFinding(
            code="inertia-broken",
            severity="repaired",
            where=at_link(draft, link),
            what=f"its principal moments {shown} kg m2 {kind}",
            done=done + after,
            fix="recompute it in CAD; the sum of any two principal moments exceeds the third",
        )
    ]
