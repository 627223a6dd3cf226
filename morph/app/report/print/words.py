"""What the report of a package says in words and in tables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from morph.fabrication.content import Package
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.margins import Margin
from morph.print.part import Check, Part
from morph.print.weight import Weight

FROM = {
    "gcode": "sliced",
    "estimate": "estimated",
    "scale": "weighed",
    "description": "as described",
}
"""Where a mass comes from, as the report calls it."""


@dataclass(frozen=True, kw_only=True)
class LinkRow:
    """What one link weighs, in words."""

    link: str
    designed: str
    predicted: str
    measured: str
    change: str
    moved: str
    inertia: str
    source: str


@dataclass(frozen=True, kw_only=True)
class PartRow:
    """One part, in words."""

    number: str
    name: str
    hand: str
    kind: str
    count: int
    links: str
    grams: str
    support: str
    time: str
    warnings: str


@dataclass(frozen=True, kw_only=True)
class MarginRow:
    """What one motor needs and has, in words."""

    joint: str
    limit: str
    designed: str
    printed: str
    left: str


def headline(package: Package) -> str:
    """Return what the page says first."""
    refused = len(refusals(package))
    parts = [part for part in package.job.parts if part.name in package.job.sliced]
    if not parts:
        return f"No part of {package.title} can be printed"
    copies = sum(part.count for part in parts)
    text = f"{package.title}: {counted(copies, 'part')} to print"
    return f"{text}, {counted(refused, 'thing')} refused" if refused else text


def refusals(package: Package) -> tuple[str, ...]:
    """Return the names of the parts, links and joints of which something was refused."""
    checks = package.job.checks
    return tuple(dict.fromkeys(each.part for each in checks if each.verdict == "refused"))


def summary(package: Package) -> list[str]:
    """Return the sentences under the headline."""
    job = package.job
    plates = [plate for plate in job.plates if plate.name.startswith("plate")]
    sources = {sliced.source for sliced in job.sliced.values()}
    how = "sliced" if "gcode" in sources else "estimated without a slicer"
    lines = []
    if job.sliced:
        lines.append(
            f"{job.grams:.0f} g of {job.profile.material.name.upper()} on "
            f"{counted(len(plates), 'plate')} of the {job.profile.printer.title}, "
            f"{hours(job.seconds)} in all, {how}."
        )
    lines.append(_known(package))
    if package.policy is not None:
        lines.append(package.policy.what)
    return lines


def _known(package: Package) -> str:
    every = len(package.links)
    known = sum(each.source != "description" for each in package.links)
    if not known:
        return (
            f"It keeps the {package.designed_kg:.3f} kg that were described: of none of its links "
            "all that it weighs is known."
        )
    others = (
        ""
        if known == every
        else f" {known} of {every} links have such masses; the others keep what was described."
    )
    return (
        f"The model weighs {package.designed_kg:.3f} kg; with what its parts weigh it is "
        f"{package.now_kg:.3f} kg.{others}"
    )


def link_rows(package: Package) -> list[LinkRow]:
    """Return a row for each link."""
    return [_link_row(each) for each in package.links]


def part_rows(package: Package) -> list[PartRow]:
    """Return a row for each part, the bought ones last."""
    every = sorted(package.job.parts, key=lambda part: part.kind == "bought")
    return [_part_row(part, package) for part in every]


def margin_row(margin: Margin) -> MarginRow:
    """Return a motor's row."""
    return MarginRow(
        joint=margin.joint,
        limit="–" if margin.limit is None else f"{margin.limit:.3g} {margin.unit}",
        designed=_effort(margin.designed, margin.run_designed, margin.unit),
        printed=_effort(margin.printed, margin.run_printed, margin.unit),
        left="–" if margin.left is None else f"{100 * margin.left:.0f} %",
    )


def _effort(held: float, ran: float | None, unit: str) -> str:
    return f"{held:.3g} {unit}" if ran is None else f"{held:.3g} {unit}, moving {ran:.3g}"


def ordered(checks: Iterable[Check]) -> list[Check]:
    """Return checks with the refused first and what passed last."""
    order = ("refused", "noted", "passed")
    return sorted(checks, key=lambda check: order.index(check.verdict))


def hours(seconds: float) -> str:
    """Return a time such as `3 h 05 min`."""
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min"


def _link_row(mass: LinkMass) -> LinkRow:
    before, now = mass.designed, mass.now
    same = mass.source == "description"
    return LinkRow(
        link=mass.link,
        designed=_grams(before),
        predicted="–" if mass.predicted is None else _grams(mass.predicted),
        measured="–" if mass.measured is None else _grams(mass.measured),
        change="–" if same or before.mass <= 0 else f"{100 * (now.mass / before.mass - 1):+.0f} %",
        moved="–" if same else f"{1e3 * float(np.linalg.norm(now.com - before.com)):.1f} mm",
        inertia="–" if same else _inertia(before, now),
        source=FROM[mass.source],
    )


def _inertia(before: Weight, now: Weight) -> str:
    """Return by how much the inertia differs, once the mass is made the same."""
    size = float(np.linalg.norm(before.inertia))
    if size <= 0 or before.mass <= 0 or now.mass <= 0:
        return "–"
    scaled = before.inertia * (now.mass / before.mass)
    return (
        f"{100 * float(np.linalg.norm(now.inertia - scaled)) / float(np.linalg.norm(scaled)):.0f} %"
    )


def _part_row(part: Part, package: Package) -> PartRow:
    sliced = package.job.sliced.get(part.name)
    lies = package.job.orientations.get(part.name)
    saved = ""
    if lies is not None and sliced is not None:
        first, after = lies.first_support_mm3 / 1e3, lies.support_mm3 / 1e3
        saved = f"{1e3 * sliced.support_kg:.1f} g" + (
            f" (as drawn {first:.0f} cm³, turned {after:.0f})" if first - after >= 1 else ""
        )
    links = list(dict.fromkeys(at.link for at in part.placements))
    return PartRow(
        number=part.number,
        name=part.name,
        hand=part.hand,
        kind=part.kind,
        count=part.count,
        links=", ".join(links),
        grams="–" if part.weight is None else f"{1e3 * part.weight.mass:.1f}",
        support=saved or "–",
        time="–" if sliced is None else hours(sliced.seconds),
        warnings="; ".join(sliced.warnings) if sliced is not None else "",
    )


def _grams(weight: Weight) -> str:
    return f"{1e3 * weight.mass:.1f} g"


def counted(count: int, what: str) -> str:
    """Return how many there are, such as `1 part`."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
