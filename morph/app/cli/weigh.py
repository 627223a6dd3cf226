"""`morph weigh`: a package corrected by a scale, and its policy tried again."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.console import harmless, paragraph, say, width
from morph.app.cli.stages import stages
from morph.app.cli.weigh_arguments import Weigh
from morph.errors import MakeError

if TYPE_CHECKING:
    from morph.make.scale import ScaleReading
    from morph.make.weigh import Weighed

DONE, STOPPED_SHORT = 0, 3

REPORT = "report.html"
"""The report of a package."""

VERDICTS = {
    "holds": "the policy holds",
    "matched": "the policy was matched to this robot",
    "lost": "the policy is lost on this robot",
}
"""What became of a policy, in words."""


def run_weigh(asked: Weigh) -> int:
    """Correct the package and return the exit status.

    Raises:
        MorphError: A reading makes no sense, or the package cannot be used or written.
    """
    from morph.make.package_folder import package_folder
    from morph.make.packed import FILE
    from morph.make.reading import read_package
    from morph.make.scale import readings, taken
    from morph.make.weigh import write_weighed
    from morph.run_folder import lock_run_folder

    if not 0.0 <= asked.seconds < float("inf"):
        raise MakeError(f"{asked.seconds:g} s is no time", where="--seconds", fix="give 0 or more")
    place = Path(asked.package)
    # Read while it is held: of two readings at once, one would be lost.
    with lock_run_folder(place, beside=True):
        package = read_package(place)
        new = readings(package, asked.reading, anyway=asked.anyway)
        with stages(asked.quiet) as told, package_folder(place) as folder:
            found = write_weighed(
                place,
                folder,
                package,
                taken(package.readings, new),
                seconds=asked.seconds if asked.match else 0.0,
                seed=asked.seed,
                told=told.now,
            )
            told.now("writing the report")
            _report(folder, found, asked.seed)
    if asked.json:
        sys.stdout.write((place / FILE).read_text(encoding="utf-8"))
    else:
        _say(asked, new, found)
    policy = found.package.policy
    return STOPPED_SHORT if policy is not None and policy.verdict == "lost" else DONE


def _report(folder: Path, found: Weighed, seed: int) -> None:
    from morph.app.report.print.files import write_pages
    from morph.make.margins import margins
    from morph.make.policies import policies_in

    learned, now = None, None
    if found.package.policy is not None:
        learned, now = policies_in(folder, found.designed, found.printed)
    told = margins(found.designed, found.printed, learned=learned, matched=now, seed=seed)
    write_pages(folder, found.package, told)


def _say(asked: Weigh, new: tuple[ScaleReading, ...], found: Weighed) -> None:
    package, columns = found.package, width()
    lines = [
        (
            f"{package.title} weighs {package.now_kg:.4f} kg; it was {found.before_kg:.4f} kg "
            f"before, and {package.designed_kg:.4f} kg by the model",
            "bold",
        )
    ]
    weights = {part.name: part.weight for part in package.job.parts}
    for each in new:
        weight = weights[each.part]
        predicted = f"{1e3 * weight.mass:.2f} g predicted" if weight is not None else ""
        shown = "forgotten" if each.kg is None else f"{1e3 * each.kg:.2f} g"
        lines.append((f"  {each.part}: {shown}, {predicted}", ""))
    for name in _unchanged(new, found):
        lines.append(
            (f"  {name} keeps what was described: not all of its parts are known", "yellow")
        )
    policy = package.policy
    if policy is None:
        lines.append(("there is no policy in this package", ""))
    else:
        style = "yellow" if policy.verdict == "lost" else "green"
        lines += [(VERDICTS.get(policy.verdict, policy.verdict), style), (f"  {policy.what}", "")]
        if policy.verdict == "lost":
            lines.append((f"  {_advice(asked)}", "yellow"))
    lines.append((f"corrected {asked.package}: robot, policy, {REPORT} and package.json", ""))
    say((piece, style) for text, style in lines for piece in paragraph(harmless(text), 4, columns))


def _unchanged(new: tuple[ScaleReading, ...], found: Weighed) -> list[str]:
    """Return the links of weighed parts whose mass stays as described."""
    names = {each.part for each in new}
    links = {
        at.link for part in found.package.job.parts if part.name in names for at in part.placements
    }
    return [
        each.link
        for each in found.package.links
        if each.link in links and each.source == "description"
    ]


def _advice(asked: Weigh) -> str:
    if not asked.match:
        return "leave out --no-match to have it matched again"
    return "give more --seconds, or learn it anew on the folder robot of the package"
