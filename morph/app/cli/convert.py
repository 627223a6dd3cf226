"""`morph convert`: a clean description of a robot, in a folder of its own."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Convert
from morph.app.cli.console import harmless, paragraph, say, width
from morph.errors import OutputError

if TYPE_CHECKING:
    from morph.body.collide import Cut
    from morph.body.convert import Conversion
    from morph.body.robot import Robot

SCHEMA = "morph.conversion/1"
"""Name and version of what `--json` prints."""


def run_convert(options: Convert) -> int:
    """Write the description and return the exit status.

    Raises:
        MorphError: The robot cannot be used, or the folder cannot be written to.
    """
    from morph.body.convert import check_folder, convert
    from morph.body.load import load

    if not options.out.strip():
        # As a path it would be the folder where one stands.
        raise OutputError("no folder is named", where="--out", fix="name a new or an empty folder")
    out = Path(options.out)
    check_folder(out)
    robot = load(options.robot, base=options.base, folder=options.folder)
    if options.servo:
        from morph.body.motors import with_servos

        robot = with_servos(robot, options.servo)
    cuts: tuple[Cut, ...] = ()
    if options.pieces:
        from morph.body.collide import with_pieces

        robot, cuts = with_pieces(robot, progress=_cutting)
    written = convert(robot, options.to, out)
    if options.json:
        content = {
            "schema": SCHEMA,
            "files": [str(path) for path in written.files],
            "left_out": list(written.left_out),
            "pieces": [asdict(cut) for cut in cuts],
        }
        sys.stdout.write(json.dumps(content, indent=2, allow_nan=False) + "\n")
    else:
        columns = width()
        lines = [
            piece for line in _words(options, robot, written, cuts) for piece in _fit(line, columns)
        ]
        say((line, "") for line in lines)
    return 0


def _fit(line: str, columns: int | None) -> list[str]:
    return paragraph(harmless(line), 4, columns)


def _cutting(mesh: str) -> None:
    sys.stderr.write(f"cutting {harmless(mesh)}\n")
    sys.stderr.flush()


def _words(options: Convert, robot: Robot, written: Conversion, cuts: tuple[Cut, ...]) -> list[str]:
    meshes = len(written.files) - 2
    beside = f", {meshes} mesh{'es' if meshes > 1 else ''}" if meshes else ""
    lines = [f"wrote {written.files[0]}{beside} and {written.files[-1].name}"]
    repaired = sum(finding.severity == "repaired" for finding in robot.findings)
    if repaired:
        asking = f"morph inspect {shlex.quote(options.robot)}"
        many = f"{repaired} repairs are" if repaired > 1 else "1 repair is"
        lines.append(f"{many} in it, which {asking} lists")
    for cut in cuts:
        filled = f"{cut.hull_ratio:.3g} of its volume as its hull"
        if cut.pieces > 1:
            filled += f", {cut.pieces_ratio:.3g} as {cut.pieces} pieces"
        lines.append(f"{cut.mesh} of {cut.link} fills {filled}")
    if written.left_out:
        lines += [
            f"{options.to.upper()} does not hold:",
            *(f"  {left}" for left in written.left_out),
        ]
    return lines
