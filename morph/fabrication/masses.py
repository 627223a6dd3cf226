"""What each link weighs by its parts, and with what a scale showed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from morph.body.robot import Robot
from morph.fabrication.link_mass import LinkMass, Source
from morph.fabrication.printed import designed
from morph.print.job import Job
from morph.print.part import Part
from morph.print.weight import Weight, together


def link_masses(
    robot: Robot,
    job: Job,
    complete: Iterable[str],
    readings: Mapping[str, float] | None = None,
) -> tuple[LinkMass, ...]:
    """Return what every link weighs, in the order of the robot.

    A link's parts are put together by Steiner's theorem. Only of a link of which every part is
    known, and none was refused, anything is predicted; all others keep what was described.

    Args:
        robot: The body as it was designed.
        job: Its parts, with the weights of those that are printed.
        complete: Links of which everything that weighs is a part.
        readings: What a scale showed for one copy of a part, kg, by the part's name; its
            spread is that which was predicted, of another density.
    """
    whole = set(complete) - {at.link for part in job.refused for at in part.placements}
    shown = readings or {}
    before = designed(robot)
    return tuple(
        _mass(link.name, before[link.name], job, shown, link.name in whole) for link in robot.links
    )


def _mass(link: str, before: Weight, job: Job, shown: Mapping[str, float], whole: bool) -> LinkMass:
    here = [part for part in job.parts if any(at.link == link for at in part.placements)]
    predicted = _of(link, here, {}) if whole else None
    if predicted is None or predicted.mass <= 0:
        return LinkMass(
            link=link, designed=before, predicted=None, measured=None, source="description"
        )
    weighed = any(part.name in shown for part in here)
    return LinkMass(
        link=link,
        designed=before,
        predicted=predicted,
        measured=_of(link, here, shown) if weighed else None,
        source="scale" if weighed else _source(here, job),
    )


def _of(link: str, parts: Sequence[Part], shown: Mapping[str, float]) -> Weight | None:
    """Return what parts weigh in a link's frame; None if one's weight is not known."""
    results = []
    for part in parts:
        weight = part.weight
        if weight is None and part.kind == "fused":
            # It is printed with what it is fused into, whose weight holds it.
            continue
        if weight is None:
            return None
        if part.name in shown:
            weight = weight.scaled(shown[part.name])
        results += [weight.moved(at.pose) for at in part.placements if at.link == link]
    return together(results)


def _source(parts: Sequence[Part], job: Job) -> Source:
    sources = {job.sliced[part.name].source for part in parts if part.name in job.sliced}
    return "estimate" if "estimate" in sources else "gcode" if sources else "description"
