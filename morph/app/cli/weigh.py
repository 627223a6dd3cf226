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
    from morph.fabrication.scale import ScaleReading
    from morph.fabrication.weigh import Weighed

DONE, STOPPED_SHORT = 0, 3

REPORT = "report.html"
"""The report of a package."""

VERDICTS = {
    "holds": "the policy holds",
    "matched": "the policy was matched to this robot",
    "lost": "the policy is lost on this robot",
}
"""What became of a policy, in words."""


def run_weigh(options: Weigh) -> int:
    """Correct the package and return the exit status.

    Raises:
        MorphError: A reading makes no sense, or the package cannot be used or written.
    """
    from morph.fabrication.package_folder import package_folder
    from morph.fabrication.packed import FILE
    from morph.fabrication.reading import read_package
    from morph.fabrication.scale import readings, taken
    from morph.fabrication.weigh import write_weighed
    from morph.run_folder import lock_run_folder

    if not 0.0 <= options.seconds < float("inf"):
        raise MakeError(
            f"{options.seconds:g} s is no time", where="--seconds", fix="give 0 or more"
        )
    place = Path(options.package)
    # Read while it is held: of two readings at once, one would be lost.
    with lock_run_folder(place, beside=True):
        package = read_package(place)
        new = readings(package, options.reading, anyway=options.anyway)
        with stages(options.quiet) as progress, package_folder(place) as folder:
            result = write_weighed(
                place,
                folder,
                package,
                taken(package.readings, new),
                seconds=options.seconds if options.match else 0.0,
                seed=options.seed,
                progress=progress.now,
            )
            progress.now("writing the report")
            _report(folder, result, options.seed)
    if options.json:
        sys.stdout.write((place / FILE).read_text(encoding="utf-8"))
    else:
        _say(options, new, result)
    policy = result.package.policy
    return STOPPED_SHORT if policy is not None and policy.verdict == "lost" else DONE


def _report(folder: Path, result: Weighed, seed: int) -> None:
    from morph.app.report.print.files import write_pages
    from morph.fabrication.margins import margins
    from morph.fabrication.policies import policies_in

    learned, now = None, None
    if result.package.policy is not None:
        learned, now = policies_in(folder, result.designed, result.printed)
    comparison = margins(result.designed, result.printed, learned=learned, matched=now, seed=seed)
    write_pages(folder, result.package, comparison)


def _say(options: Weigh, new: tuple[ScaleReading, ...], result: Weighed) -> None:
    package, columns = result.package, width()
    lines = [
        (
            f"{package.title} weighs {package.now_kg:.4f} kg; it was {result.before_kg:.4f} kg "
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
    for name in _unchanged(new, result):
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
            lines.append((f"  {_advice(options)}", "yellow"))
    lines.append((f"corrected {options.package}: robot, policy, {REPORT} and package.json", ""))
    say((piece, style) for text, style in lines for piece in paragraph(harmless(text), 4, columns))


def _unchanged(new: tuple[ScaleReading, ...], result: Weighed) -> list[str]:
    """Return the links of weighed parts whose mass stays as described."""
    names = {each.part for each in new}
    links = {
        at.link for part in result.package.job.parts if part.name in names for at in part.placements
    }
    return [
        each.link
        for each in result.package.links
        if each.link in links and each.source == "description"
    ]


def _advice(options: Weigh) -> str:
    if not options.match:
        return "leave out --no-match to have it matched again"
    return "give more --seconds, or learn it anew on the folder robot of the package"
