"""Tables and sentences about a print package."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from morph.app.viewer.content import CellTable, Colour, Marked
from morph.app.viewer.printed.choices import PrintChoices
from morph.app.viewer.printed.skin import HOT, PAINTERS, PLAIN, WARM, legend
from morph.app.viewer.printed.viewed_package import ViewedPackage
from morph.arrays import Array
from morph.fabrication.link_mass import LinkMass
from morph.print.part import Check, Part
from morph.print.weight import Weight

VERDICTS: dict[str, Colour] = {
    "refused": (213, 30, 20),
    "noted": (230, 171, 85),
    "passed": (0, 158, 115),
}
"""Of checks, the worst first."""

MOST_ROWS = 60
"""Of a table; what is left out is counted."""

SOURCES = {"estimate": "estimated", "gcode": "sliced"}
"""Where predicted masses come from."""


def tables(made: ViewedPackage, chosen: PrintChoices) -> tuple[CellTable, ...]:
    """Return what colours mean, the part that is pointed at, checks, parts and masses."""
    results = (
        _legend(made, chosen),
        _held(made, chosen),
        _checks(made),
        _parts(made),
        _masses(made),
    )
    return tuple(table for table in results if table is not None and table.rows)


def notes(made: ViewedPackage) -> Iterator[str]:
    """Yield what is to be known, a sentence each."""
    job, package = made.job, made.package
    if job.sliced:
        yield (
            f"{job.grams:.0f} g of {job.profile.material.name.upper()} and {hours(job.seconds)} on "
            f"the {job.profile.printer.title}; the model weighs {package.designed_kg:.3f} kg, and "
            f"with what is printed {package.now_kg:.3f} kg."
        )
    if package.folder is None:
        yield (
            "Masses are estimated, and nothing is written: `morph print` makes the package, with "
            "plates, parts and the robot as it comes off the printer."
        )
    else:
        yield f"The package is the folder {package.folder.name}."
    if package.policy is not None:
        yield f"Policy ({package.policy.task}): {package.policy.what}"
    for note in (*package.notes, *job.notes):
        yield note if note.endswith(".") else f"{note}."


def hours(seconds: float) -> str:
    """Return a time such as `3 h 05 min`."""
    whole, rest = divmod(round(seconds / 60.0), 60)
    return f"{whole} h {rest:02d} min" if whole else f"{rest} min"


def colour(of: Array) -> Colour:
    """Return a colour as tables have it."""
    red, green, blue = np.rint(of).astype(int).tolist()
    return red, green, blue


def _legend(made: ViewedPackage, chosen: PrintChoices) -> CellTable | None:
    if chosen.by in PAINTERS:
        rows = [(Marked(text=what, colour=colour(of)),)
                for what, of in legend(chosen.by, made.job.profile)]  # fmt: skip
    elif chosen.by == "mass":
        middle = colour(0.5 * (PLAIN + HOT))
        rows = [
            (Marked(text="0 g", colour=colour(PLAIN)),),
            (Marked(text=f"{0.5 * made.heaviest:.1f} g", colour=middle),),
            (Marked(text=f"{made.heaviest:.1f} g", colour=colour(HOT)),),
        ]
    else:
        return None
    return CellTable(title=f"Colours: {chosen.by}", head=("what it means",), rows=tuple(rows))


def _held(made: ViewedPackage, chosen: PrintChoices) -> CellTable | None:
    skin = made.skins.get(chosen.part)
    if skin is None:
        return None
    part, grams = skin.part, made.grams(chosen.part)
    lies, sliced = made.job.orientations.get(part.name), made.job.sliced.get(part.name)
    rows = [("number", part.number or "–"), ("copies", str(part.count)), ("kind", part.kind)]
    if part.hand:
        rows.append(("hand", part.hand))
    if part.mesh is not None:
        size = " × ".join(f"{each:.0f}" for each in part.mesh.extent)
        rows.append(("size", f"{size} mm"))
    if grams is not None:
        rows.append(("mass", f"{grams:.1f} g"))
    if sliced is not None:
        rows += [("time", hours(sliced.seconds)), ("support", f"{1e3 * sliced.support_kg:.1f} g")]
    if lies is not None:
        rows.append(("height as printed", f"{lies.height_mm:.0f} mm"))
    holds = Counter(seat.holds for seat in part.seats)
    rows += [("holds", f"{count} × {what}") for what, count in holds.items()]
    return CellTable(title=_called(part), head=("pointed at", ""), rows=tuple(rows), words=True)


def _checks(made: ViewedPackage) -> CellTable:
    checks = made.job.checks
    lines = [check for name in ("refused", "noted") for check in checks if check.verdict == name]
    rows = [(_mark(check), _said(check)) for check in lines[:MOST_ROWS]]
    if len(lines) > MOST_ROWS:
        rows.append((Marked(text="more", colour=colour(WARM)), f"{len(lines) - MOST_ROWS} checks"))
    passed = Counter(check.name for check in checks if check.verdict == "passed")
    if passed:
        what = ", ".join(f"{name} {count}" for name, count in passed.items())
        rows.append((Marked(text="passed", colour=VERDICTS["passed"]), what))
    return CellTable(
        title="Checks", head=("verdict", "what was found"), rows=tuple(rows), words=True
    )


def _mark(check: Check) -> Marked:
    return Marked(text=check.verdict, colour=VERDICTS[check.verdict])


def _said(check: Check) -> str:
    fix = f" Put it right: {check.fix}." if check.fix else ""
    return f"{check.part.replace('_', ' ')}, {check.name}: {check.what}.{fix}"


def _parts(made: ViewedPackage) -> CellTable:
    rows = [
        (_called(part), str(part.count), _plates(part, made), _grams(made, part))
        for part in made.job.parts
        if part.kind != "fused"
    ]
    left = len(rows) - MOST_ROWS
    rows = [*rows[:MOST_ROWS], *([(f"{left} more", "", "", "")] if left > 0 else [])]
    return CellTable(title="Parts", head=("part", "copies", "plate", "g each"), rows=tuple(rows))


def _plates(part: Part, made: ViewedPackage) -> str:
    if part.kind == "bought":
        return "bought"
    on = [plate.name for plate in made.job.plates if part.name in {it.part for it in plate.laid}]
    return ", ".join(on).replace("_", " ")


def _grams(made: ViewedPackage, part: Part) -> str:
    if part.name not in made.skins:
        return "–" if part.weight is None else f"{1e3 * part.weight.mass:.1f}"
    grams = made.grams(part.name)
    return "–" if grams is None else f"{grams:.1f}"


def _called(part: Part) -> str:
    return f"{part.number} {part.name.replace('_', ' ')}".strip()


def _masses(made: ViewedPackage) -> CellTable:
    rows = [_mass(each) for each in made.package.links[:MOST_ROWS]]
    sources = {each.source for each in made.package.links} - {"description", "scale"}
    how = f", {' and '.join(SOURCES[each] for each in sorted(sources))}" if sources else ""
    return CellTable(
        title=f"Mass of each link (g){how}",
        head=("link", "designed", "predicted", "measured"),
        rows=tuple(rows),
    )


def _mass(each: LinkMass) -> tuple[str, ...]:
    def grams(weight: Weight | None) -> str:
        return "–" if weight is None else f"{1e3 * weight.mass:.1f}"

    return (
        each.link.replace("_", " "),
        grams(each.designed),
        grams(each.predicted),
        grams(each.measured),
    )
