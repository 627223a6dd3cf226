"""What `morph print` says of a package."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from morph.fabrication.content import Package

VERDICTS = {
    "holds": "holds on the printed robot",
    "matched": "was matched to the printed robot",
    "lost": "does not hold on the printed robot, and none was found in time",
}
"""What became of a policy, in words."""


def sentences(out: Path, package: Package) -> list[tuple[str, str]]:
    """Return what `morph print` says of a package, each with its style."""
    job = package.job
    printed = [part for part in job.parts if part.name in job.sliced]
    copies = sum(part.count for part in printed)
    source = "sliced" if any(s.source == "gcode" for s in job.sliced.values()) else "estimated"
    plates = sum(plate.name.startswith("plate") for plate in job.plates)
    sorts = "" if copies == len(printed) else f" of {_counted(len(printed), 'sort')}"
    refused = len({check.part for check in job.checks if check.verdict == "refused"})
    but = f"; {_counted(refused, 'thing')} refused" if refused else ""
    lines = [
        (
            f"{package.title}: {_counted(copies, 'part')}{sorts} on {_counted(plates, 'plate')}, "
            f"{job.grams:.0f} g and {_hours(job.seconds)} ({source}){but}"
            if printed
            else f"{package.title}: there is nothing to print{but}",
            "bold",
        ),
        (_weighs(package), ""),
    ]
    if package.policy is not None:
        lines.append((f"the policy {VERDICTS[package.policy.verdict]}: {package.policy.what}", ""))
    for check in job.checks:
        if check.verdict == "refused":
            lines.append((f"refused: {check.part}: {check.what}; {check.fix}", "red"))
    noted = sum(check.verdict == "noted" for check in job.checks)
    if noted:
        lines.append((f"{_counted(noted, 'thing')} to look at, in report.html", ""))
    lines += [(note, "") for note in (*package.notes, *job.notes)]
    lines.append((f"wrote {out}", ""))
    return lines


def _weighs(package: Package) -> str:
    if all(each.source == "description" for each in package.links):
        return (
            f"the robot keeps the {package.designed_kg:.3f} kg of its model: of no link all that "
            "weighs is known"
        )
    return f"it weighs {package.now_kg:.3f} kg; the model said {package.designed_kg:.3f} kg"


def _hours(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60:02d} min"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
