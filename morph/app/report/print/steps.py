"""What to do with a package, one step after the other, and what its plates hold."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from morph.app.report.print.words import counted, hours, refusals
from morph.fabrication.content import Package
from morph.print.job import Job, Plate
from morph.print.part import Check


@dataclass(frozen=True, kw_only=True)
class PrintStep:
    """One thing to do."""

    what: str
    """It, in few words."""
    how: str
    """What to know for it."""
    command: str = ""
    """What to type; empty if nothing."""


@dataclass(frozen=True, kw_only=True)
class PlateRow:
    """One plate, in words."""

    name: str
    file: str
    copies: int
    grams: str
    time: str
    holds: str


@dataclass(frozen=True, kw_only=True)
class Advice:
    """What is to be done about several checks, and what they found."""

    fix: str
    checks: tuple[Check, ...]


def steps(package: Package, sliced: Collection[str] = ()) -> list[PrintStep]:
    """Return what to do, in order.

    Args:
        package: What is printed.
        sliced: Names of the plates that have a G-code in the package.
    """
    job = package.job
    plates = [plate for plate in job.plates if not _tries(plate)]
    results = []
    mend = refusals(package)
    if mend:
        lies = " Refused parts lie in refused/, and on no plate." if job.refused else ""
        none = "" if plates else " Before that, nothing can be printed."
        results.append(
            PrintStep(
                what=f"Mend {counted(len(mend), 'thing')} and make the package anew",
                how=f"What and why is below.{lies}{none}",
            )
        )
    if len(plates) < len(job.plates):
        play = job.profile.clearance_mm
        results.append(
            PrintStep(
                what="Print the gauges and try in them what you bought",
                how=f"These parts leave a play of {play:g} mm on each side. If another notch of "
                "a gauge fits better, make the package anew with its play, --play MM: it changes "
                "what morph drew, not parts that came as meshes.",
            )
        )
    if plates:
        results.append(_printing(job, plates, sliced))
        results.append(
            PrintStep(
                what="Buy the rest and put it together",
                how="bom.csv counts what is bought; assembly.html shows each step.",
            )
        )
        results.append(_weighing(package))
    results.append(_using(package))
    return results


def _printing(job: Job, plates: Sequence[Plate], sliced: Collection[str]) -> PrintStep:
    with_code = all(plate.name in sliced for plate in plates)
    ready = (
        "Their G-code lies beside them."
        if with_code
        else f"Open each in a slicer: layers of {job.profile.layer_mm:g} mm, "
        f"{counted(job.profile.walls, 'wall')}, {100 * job.profile.infill:.0f} % infill, with "
        "support; the masses hold for these settings alone."
    )
    return PrintStep(
        what=f"Print {counted(len(plates), 'plate')}",
        how=f"{ready} Everything lies as it is to be printed.",
    )


def _weighing(package: Package) -> PrintStep:
    part = next((part for part in package.job.parts if part.name in package.job.sliced), None)
    name = "PART" if part is None else part.number or part.name
    tried = ", and tries the policy on it" if package.policy is not None else ""
    return PrintStep(
        what="Weigh what came off the printer",
        how=f"One copy of a part is enough. It corrects the robot in robot/{tried}.",
        command=f"morph weigh DIR {name}=GRAMS",
    )


def _using(package: Package) -> PrintStep:
    if package.policy is None:
        known = any(each.source != "description" for each in package.links)
        return PrintStep(
            what="Learn and simulate on the robot in robot/, not on the model",
            how="It has the masses of its parts, as far as they are known."
            if known
            else "It keeps the masses that were described, until a card.toml beside the "
            "description says what of it is bought.",
            command="morph view DIR/robot",
        )
    lost = "It does not hold there yet. " if package.policy.verdict == "lost" else ""
    return PrintStep(
        what="See the policy on the robot as printed",
        how=f"{lost}policy/ is made for robot/, and for no other.",
        command=f"morph view DIR/robot --task {package.policy.task} --policy DIR/policy",
    )


def plate_rows(package: Package, sliced: Collection[str] = ()) -> list[PlateRow]:
    """Return a row for each plate, the gauges first."""
    return [_row(plate, package.job, plate.name in sliced) for plate in package.job.plates]


def _row(plate: Plate, job: Job, sliced: bool) -> PlateRow:
    lying = [job.sliced[laid.part] for laid in plate.laid if laid.part in job.sliced]
    counts: dict[str, int] = {}
    for laid in plate.laid:
        counts[laid.part] = counts.get(laid.part, 0) + 1
    numbers = {part.name: part.number for part in job.parts}
    holds = (
        f"{count} × {numbers.get(name) or name}" if count > 1 else numbers.get(name) or name
        for name, count in counts.items()
    )
    return PlateRow(
        name=plate.name,
        file=f"{plate.name}.3mf" + (", .gcode" if sliced else ""),
        copies=len(plate.laid),
        grams=f"{1e3 * sum(each.weight.mass + each.support_kg for each in lying):.0f}",
        time=hours(sum(each.seconds for each in lying)),
        holds=", ".join(holds),
    )


def advised(checks: Iterable[Check]) -> list[Advice]:
    """Return checks together that ask for the same, in the order in which they come."""
    results: dict[str, list[Check]] = {}
    for check in checks:
        results.setdefault(check.fix, []).append(check)
    return [Advice(fix=fix, checks=tuple(each)) for fix, each in results.items()]


def _tries(plate: Plate) -> bool:
    return plate.name.startswith("gauges")
