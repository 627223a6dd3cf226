"""`morph print`: from a body to a package for the printer."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.console import harmless, paragraph, say, width
from morph.app.cli.print_arguments import Print
from morph.app.cli.stages import stages
from morph.errors import MakeError, OutputError

if TYPE_CHECKING:
    from morph.body.robot import Robot
    from morph.fabrication.content import Package
    from morph.print.printer import Profile
    from morph.print.slicer import Slicer

CHOSEN = (
    *("policy", "seconds", "slicer", "timeout", "layer", "walls", "infill", "play"),
    *("base", "folder", "seed"),
)
"""Options that stand in the command by which a package is got again."""

DONE, STOPPED_SHORT = 0, 3


def run_print(options: Print) -> int:
    """Make the package and return the exit status.

    Raises:
        MorphError: An input cannot be used, or the package cannot be written.
    """
    from morph.app.cli.print_text import sentences
    from morph.fabrication.packed import FILE

    package, out = packaged(options), Path(options.out)
    if options.json:
        sys.stdout.write((out / FILE).read_text(encoding="utf-8"))
    else:
        columns = width()
        say(
            (line, style)
            for statement, style in sentences(out, package)
            for line in paragraph(harmless(statement), 4, columns)
        )
    lost = package.policy is not None and package.policy.verdict == "lost"
    refused = any(check.verdict == "refused" for check in package.job.checks)
    return STOPPED_SHORT if refused or lost or not package.job.sliced else DONE


def packaged(options: Print) -> Package:
    """Make the package, write it to `options.out` and return it.

    Raises:
        MorphError: An input cannot be used, or the package cannot be written.
    """
    from morph.fabrication.package_folder import check_out, package_folder
    from morph.print.errors import PrintError
    from morph.run_folder import lock_run_folder

    if not options.out.strip():
        # As a path it would be the folder where one stands.
        raise OutputError("no folder is named", where="--out", fix="name a new or an empty folder")
    out = Path(options.out)
    check_out(out)
    try:
        profile, slicer = _profile(options), _slicer(options)
        _check_times(options)
        with lock_run_folder(out, beside=True), stages(options.quiet) as progress:
            robot = _robot(options)
            _check_policy(options, robot)
            package = _package(options, robot, profile, slicer, progress.now)
            with package_folder(out) as folder:
                return _write(options, folder, robot, package, slicer, progress.now)
    except PrintError as error:
        raise MakeError(error.what, where=error.where, fix=error.fix) from error


def _check_times(options: Print) -> None:
    for name in ("seconds", "timeout"):
        value = getattr(options, name)
        if not 0 <= value < math.inf or (name == "timeout" and value == 0):
            raise MakeError(
                f"{value:g} is no time that can be waited",
                where=f"--{name}",
                fix=f"say how many seconds, such as {getattr(Print, name):g}",
            )


def _check_policy(options: Print, robot: Robot) -> None:
    """Refuse a policy that cannot be used now, not after all the parts were sliced."""
    if options.policy is None:
        return
    from morph.fabrication.policies import task_of
    from morph.policy.store import load_policy

    load_policy(Path(options.policy), robot)
    task_of(Path(options.policy), robot)


def _profile(options: Print) -> Profile:
    from morph.print.printer import Profile, material, printer

    return Profile(
        printer=printer(options.printer),
        material=material(options.material),
        layer_mm=options.layer,
        walls=options.walls,
        infill=options.infill,
        clearance_mm=options.play,
    )


def _slicer(options: Print) -> Slicer | None:
    from morph.print.slicer import find_slicer

    result = None if options.slicer == "none" else find_slicer()
    if result is None and options.slicer == "needed":
        raise MakeError(
            "there is no PrusaSlicer",
            where="--slicer",
            fix="install it (on Debian: apt-get install prusa-slicer), or say --slicer auto",
        )
    return result


def _robot(options: Print) -> Robot:
    from morph.body.load import load

    return load(options.robot, base=options.base, folder=options.folder)


def _package(
    options: Print,
    robot: Robot,
    profile: Profile,
    slicer: Slicer | None,
    tell: Callable[[str], None],
) -> Package:
    """Return what is to be written, but for the policy."""
    from morph.fabrication.content import Package
    from morph.fabrication.divide import divide
    from morph.fabrication.masses import link_masses
    from morph.print.prepare import prepare

    tell("dividing it into parts")
    division = divide(robot, profile)
    job = prepare(
        division.parts,
        division.hinges,
        profile,
        slicer=slicer,
        tell=tell,
        timeout_s=options.timeout,
    )
    job = replace(job, checks=(*division.checks, *job.checks))
    return Package(
        name=robot.name,
        title=robot.card.title if robot.card is not None else robot.name,
        designed_sha256=robot.sha256,
        job=job,
        links=link_masses(robot, job, division.complete),
        hinges=division.hinges,
        complete=division.complete,
        notes=division.notes,
        command=_command(options),
    )


def _write(
    options: Print,
    folder: Path,
    robot: Robot,
    package: Package,
    slicer: Slicer | None,
    tell: Callable[[str], None],
) -> Package:
    """Write all of it into a folder, `package.json` last."""
    from morph.app.report.print.files import write_pages
    from morph.fabrication.margins import margins
    from morph.fabrication.package import write_content, write_parts, write_robots

    tell("writing the robot as it comes off the printer")
    made = write_robots(folder, robot, package)
    package = replace(package, made_sha256=made.sha256)
    learned, matched = None, None
    if options.policy is not None:
        from morph.fabrication.policies import matched_in, task_of
        from morph.policy.store import load_policy

        source = Path(options.policy)
        matched, statement = matched_in(
            folder, source, robot, seconds=options.seconds, seed=options.seed, progress=tell
        )
        package = replace(package, policy=statement)
        learned = (load_policy(source, robot), task_of(source, robot))
    tell("seeing what the motors need")
    needed = margins(robot, made, learned=learned, matched=matched, seed=options.seed)
    tell("writing plates and parts")
    files = write_parts(folder, package.job, _metadata(package))
    if slicer is not None and options.gcode:
        package, more = _sliced(options, folder, package, slicer, tell)
        files |= more
    write_pages(folder, package, needed)
    write_content(folder, package, files)
    return package


def _sliced(
    options: Print, folder: Path, package: Package, slicer: Slicer, tell: Callable[[str], None]
) -> tuple[Package, dict[str, str]]:
    """Write the G-code of every plate; what the slicer warned of becomes a note."""
    from morph.files import write_whole
    from morph.print.plate_code import codes

    result = codes(package.job, slicer, tell=tell, timeout_s=options.timeout)
    files = {f"{name}.gcode": f"plates/{name}.gcode" for name in result}
    for name, code in result.items():
        write_whole(folder / files[f"{name}.gcode"], code.gcode)
    warned = tuple(
        f"{slicer.name} warns of {name}: {warning}"
        for name, code in result.items()
        for warning in code.warnings
    )
    return replace(package, notes=(*package.notes, *warned)), files


def _metadata(package: Package) -> dict[str, str]:
    """Return what each 3MF says of itself; names of our own need a namespace."""
    import morph

    metadata = {"Title": package.title, "Application": f"morph {morph.__version__}"}
    if package.policy is not None:
        metadata["policy_sha256"] = package.policy.sha256
    return {**metadata, "robot_sha256": package.made_sha256}


def _command(options: Print) -> str:
    lines = ["morph", "print", options.robot, "--printer", options.printer]
    lines += ["--material", options.material, "--out", options.out]
    for name in CHOSEN:
        value = getattr(options, name)
        if value is not None and value != getattr(Print, name, None):
            lines += [f"--{name}", str(value)]
    return shlex.join(lines if options.gcode else [*lines, "--no-gcode"])
