"""`morph excite`: commands to give a robot so that a diagnosis can tell laws apart."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.excite_arguments import Excite
from morph.app.cli.options import description_options
from morph.errors import DiagnosisError

if TYPE_CHECKING:
    from morph.experiment_design.separation import ExperimentPlan, Separation

MARKER = "experiment.json"
MOST_LISTED = 5
"""Pairs of laws that look alike that are listed; more are counted."""


def run_excite(options: Excite) -> int:
    """Plan an experiment as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used or a file cannot be written.
    """
    from morph.app.cli.diagnose import fractions
    from morph.app.cli.effects import parsed
    from morph.app.cli.stages import stages
    from morph.app.report.files import check_folder
    from morph.body.load import load
    from morph.experiment_design.separation import SCHEMA

    # Whatever the command line got wrong is told before any work is done.
    vary = fractions(options.vary)
    if bool(options.separate) == options.for_everything:
        raise DiagnosisError(
            "two laws and every law are asked for at once"
            if options.separate
            else "it is not said what the experiment is to show",
            where="morph excite",
            fix="give either --separate with two laws, or --for-everything",
        )
    if options.separate and len(options.separate) != 2:
        raise DiagnosisError(
            f"an experiment tells two laws apart, and {len(options.separate)} are given",
            where="--separate",
            fix="give two, as in --separate coulomb_friction@elbow viscous_friction@elbow; "
            "docs/effects.md lists for each law those that look alike",
        )
    check_folder(options.out, MARKER, SCHEMA, "an experiment")
    with stages(options.quiet) as progress:
        progress.now("loading")
        robot = load(options.robot, base=options.base, folder=options.folder)
        laws = [parsed(text, robot, option="--separate") for text in options.separate]
        # Late: it loads all that a diagnosis needs.
        from morph.experiment_design.plan import plan

        result = plan(
            robot,
            laws,
            seconds=options.seconds,
            rate=options.rate,
            noise=options.noise,
            vary=vary,
            seed=options.seed,
            progress=progress.now,
        )
    text = _write(result, options.out)
    sys.stdout.write(text if options.json else in_words(result, options) + "\n")
    return 0


def _write(result: ExperimentPlan, out: Path) -> str:
    """Write a plan into a folder, replaced whole or not at all, and return its record's text."""
    from morph.app.report.files import check_folder
    from morph.atomic_directory import atomic_directory
    from morph.experiment_design.separation import SCHEMA
    from morph.files import write_whole
    from morph.record.write import write

    files = [f"run_{number + 1}.csv" for number in range(len(result.runs))]
    text = json.dumps(result.as_json(files), indent=2, allow_nan=False) + "\n"

    def check(folder: Path) -> None:
        check_folder(folder, MARKER, SCHEMA, "an experiment")

    with atomic_directory(out, check, (*files, MARKER)) as folder:
        for file, run in zip(files, result.runs, strict=True):
            write(run.inputs, folder / file)
        write_whole(folder / MARKER, text)
    return text


def in_words(result: ExperimentPlan, options: Excite) -> str:
    """Return what to run, what it tells apart and what it does not, and the next commands."""
    lines = [f"{result.robot.name}: {len(result.runs)} of {result.tried} motions"]
    for number, run in enumerate(result.runs):
        share, led = 100.0 * run.excitation.amplitude, bool(run.excitation.references)
        lines.append(
            f"  run_{number + 1}.csv: {run.excitation.kind}, {run.seconds:.3g} s, {share:.2g} % of "
            + ("how far its joints can go" if led else "the actuators' limits")
        )
    followed = any(run.excitation.references for run in result.runs)
    if followed:
        lines.append(
            "  follow: its motors must hold it up, so let its own controller follow the positions, "
            "and log what the motors are told (the commands here are those of the description)"
        )
    if options.for_everything:
        lines += [*_shown(result.separations), *_alike(result.separations)]
    else:
        lines += [f"  {_line(each)}" for each in result.separations]
        sure = all(each.enough for each in result.separations)
        lines += [] if sure else ["  no motion that was tried tells them apart surely"]
    first = options.out / "run_1.csv"
    described = description_options(options.base, options.folder)
    simulate = ["morph", "simulate", options.robot, *described, "--commands", str(first)]
    simulate += ["--seconds", f"{result.runs[0].seconds:g}"]
    shown = ["morph", "view", options.robot, "--recording", str(first)]
    see = shown if result.runs[0].excitation.references else [*simulate, "--view"]
    further = [
        f"to see it: {shlex.join(see)}",
        "to name what acts, record the robot under it: "
        + shlex.join(["morph", "diagnose", options.robot, *described, "RECORDING", "--out", "DIR"]),
    ]
    return "\n".join([*lines, *further])


def _shown(separations: Sequence[Separation]) -> Iterator[str]:
    """Yield for each part which laws will show beside masses and gains, and which will not."""
    by_place: dict[str, dict[bool, list[str]]] = {}
    for each in (each for each in separations if each.rival == "none"):
        law, _, place = each.law.partition("@")
        by_place.setdefault(place, {True: [], False: []})[each.enough].append(law)
    for place, laws in by_place.items():
        parts = [
            f"{what} {', '.join(sorted(laws[enough]))}"
            for enough, what in ((True, "shows"), (False, "does not show"))
            if laws[enough]
        ]
        yield f"  {place}: {'; '.join(parts)}"


def _alike(separations: Sequence[Separation]) -> Iterator[str]:
    """Yield pairs of laws that show, and look alike."""
    shown = {each.law for each in separations if each.rival == "none" and each.enough}
    pairs = {
        frozenset((each.law, each.rival)): each
        for each in separations
        if not each.enough and {each.law, each.rival} <= shown
    }
    for each in [*pairs.values()][:MOST_LISTED]:
        yield f"  look alike: {each.law} and {each.rival}"
    if len(pairs) > MOST_LISTED:
        yield f"  and {len(pairs) - MOST_LISTED} more pairs in {MARKER}"


def _line(each: Separation) -> str:
    size = ", ".join(f"{name} = {value:.3g}" for name, value in each.size.items())
    other = "masses and gains" if each.rival == "none" else each.rival
    return (
        f"{each.law} ({size}), not {other}: {each.nats:.3g} nats, told apart with a probability of "
        f"{each.power:.2f}"
    )
