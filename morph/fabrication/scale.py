"""What a scale showed: `PART=GRAMS`, looked at before anything is corrected by it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from morph.errors import MakeError
from morph.fabrication.content import Package
from morph.nearest import nearest
from morph.print.part import Part

OFF = 0.3
"""Share of a part's predicted mass by which a reading may be off before it is doubted."""

HEAVIEST = 1e5
"""Greatest reading, g."""

MOST = 1000
"""Most copies that are weighed together."""

FORGET = "predicted"
"""What stands instead of grams to forget a part's reading."""


@dataclass(frozen=True, kw_only=True)
class ScaleReading:
    """One reading."""

    part: str
    """The part's name."""
    kg: float | None
    """What one copy weighs, kg; None to forget what was read before."""


def readings(
    package: Package, lines: Iterable[str], *, anyway: bool = False
) -> tuple[ScaleReading, ...]:
    """Return readings of parts, once they have proved to make sense.

    `PART=GRAMS` is the mass of one copy, `PART=GRAMS/COUNT` that of so many copies on the scale
    together, and `PART=predicted` forgets what was read before. PART is a name or a number, such
    as `P-03`.

    Args:
        package: The package whose parts were weighed.
        lines: The readings, as typed.
        anyway: Whether readings are taken that are off by more than `OFF`.

    Raises:
        MakeError: A part is unknown, no part of the robot's or weighed twice; a number is none;
            or a reading is far off what was predicted.
    """
    results: dict[str, ScaleReading] = {}
    for each in lines:
        name, stated, value = each.partition("=")
        if not stated:
            raise _refused(f"{each!r} says no mass", each, "write PART=GRAMS, such as P-01=12.3")
        part = _part(package, name.strip())
        reading = ScaleReading(part=part.name, kg=_kg(value.strip(), each))
        if results.setdefault(part.name, reading) != reading:
            raise _refused(
                f"{part.name!r} is weighed twice, with different masses",
                each,
                "give one reading of each part; several copies as PART=GRAMS/COUNT",
            )
    if not anyway:
        _check_far(package, results.values())
    return tuple(results.values())


def taken(before: Mapping[str, float], new: Iterable[ScaleReading]) -> dict[str, float]:
    """Return all readings, kg by the part's name: the later one of a part counts."""
    after = dict(before)
    for each in new:
        after.pop(each.part, None)
        if each.kg is not None:
            after[each.part] = each.kg
    return after


def _part(package: Package, name: str) -> Part:
    job = package.job
    for part in job.parts:
        if name in (part.name, part.number) or name.upper() == part.number:
            if part.weight is None:
                into = f"; weigh {part.into}, of which it is printed a piece" if part.into else ""
                raise _refused(
                    f"nothing was predicted of {part.name!r}{into}",
                    name,
                    "weigh a part that is printed or bought by itself",
                )
            return part
    for kind, others in (("a gauge, no part of the robot", job.gauges), ("refused", job.refused)):
        if any(name in (part.name, part.number) for part in others):
            raise _refused(f"{name!r} is {kind}", name, "weigh a part of the robot")
    known = [text for part in job.parts for text in (part.name, part.number) if text]
    raise _refused(
        f"there is no part {name[:60]!r}",
        name,
        f"the nearest are {nearest(name, known)}; package.json lists all",
    )


def _kg(value: str, text: str) -> float | None:
    """Return what one copy weighs, kg; None if the reading is to be forgotten."""
    if value == FORGET:
        return None
    grams, several, count = value.partition("/")
    try:
        mass, copies = float(grams), int(count) if several else 1
    except ValueError:
        mass, copies = math.nan, 0
    if not (0.0 < mass <= HEAVIEST and 1 <= copies <= MOST):
        raise _refused(
            f"{value[:60]!r} is no mass",
            text,
            f"write grams above 0 and up to {HEAVIEST:g}, such as 12.3, 49.2/4 for four copies "
            f"together, or `{FORGET}` to forget a reading",
        )
    return 1e-3 * mass / copies


def _check_far(package: Package, results: Iterable[ScaleReading]) -> None:
    weights = {part.name: part.weight for part in package.job.parts}
    far = []
    for each in results:
        predicted = weights[each.part]
        if each.kg is None or predicted is None or predicted.mass <= 0.0:
            continue
        off = each.kg / predicted.mass - 1.0
        if abs(off) > OFF:
            far.append(
                f"{each.part} {1e3 * each.kg:.4g} g ({1e3 * predicted.mass:.4g} g predicted, "
                f"{100.0 * off:+.0f} %)"
            )
    if far:
        raise _refused(
            f"far from what was predicted: {', '.join(far)}",
            "the scale",
            "see whether it is this part, one copy, in grams and without support; --anyway takes "
            "such readings",
        )


def _refused(what: str, where: str, fix: str) -> MakeError:
    return MakeError(what, where=f"the reading {where[:60]!r}" if "=" in where else where, fix=fix)
