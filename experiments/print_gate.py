"""What the gate before the slicer says of the meshes that other people published.

Beside each mesh that is not refused stand two spoiled copies, the opposite error: one flattened to
less than a line's width, one with every third face gone. Each mesh counts as one printed part. STL
says nothing of its unit: meshes of robots are in metres, so a folder is read in metres unless
`--unit` says otherwise.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import Save, parse_and_save
from experiments.needs import need_robots
from morph.arrays import JSON
from morph.body.mesh import read_mesh
from morph.body.mesh.read import READERS
from morph.errors import MorphError
from morph.files import write_whole
from morph.print.gate import check_part
from morph.print.mesh import Mesh
from morph.print.part import Check, Part, Placement
from morph.print.printer import Profile, material, printer

EXAMPLE = """example:
  python -m experiments.print_gate
  python -m experiments.print_gate my_parts --unit mm --printer mini --json --out out/gate.json
"""

SETS = ("open_duck_mini_v2/urdf", "poppy_humanoid/meshes")
"""What is read if nothing is named, below the folder of real robots."""
SPOILED = ("flattened", "every third face gone")
"""How copies of good meshes are spoiled."""
MILLIMETRES = {"m": 1000.0, "mm": 1.0}
"""How many there are in a unit."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One mesh."""

    file: str
    """Its folder and name."""
    verdict: str
    """The worst of its checks; `unreadable` if there is nothing to check."""
    why: str
    """What was found, of every check that did not pass."""
    seconds: float
    """What repair and checks took of one processor, without reading the file."""
    spoiled: Mapping[str, str] = field(default_factory=dict)
    """The verdict on each spoiled copy."""


def judged(path: Path, unit: str, profile: Profile, *, ways: Sequence[str] = SPOILED) -> Row:
    """Return what becomes of one file, and of its copies spoiled in these ways."""
    name = f"{path.parent.name}/{path.name}"
    try:
        read = read_mesh(path.read_bytes(), path.suffix, path.name)
    except MorphError as error:
        return Row(file=name, verdict="unreadable", why=error.what, seconds=0.0)
    mesh = Mesh(vertices=read.vertices * MILLIMETRES[unit], faces=read.faces)
    began = time.process_time()
    checks = _check(mesh, path.stem, profile)
    seconds = time.process_time() - began
    verdict = worst(checks)
    copies = () if verdict == "refused" else ways
    spoiled = {way: worst(_check(spoil(mesh, way), path.stem, profile)) for way in copies}
    return Row(file=name, verdict=verdict, why=reasons(checks), seconds=seconds, spoiled=spoiled)


def _check(mesh: Mesh, name: str, profile: Profile) -> Sequence[Check]:
    here = (Placement(link="", pose=np.eye(4), world=np.eye(4)),)
    part = Part(name=name.lower(), kind="printed", mesh=mesh, placements=here)
    return check_part(part, profile)[1]


def spoil(mesh: Mesh, way: str) -> Mesh:
    """Return a mesh that no printer can print."""
    if way == "flattened":
        thickness = np.ptp(mesh.vertices, axis=0)[2]
        return Mesh(vertices=mesh.vertices * [1.0, 1.0, 0.1 / thickness], faces=mesh.faces)
    return Mesh(vertices=mesh.vertices, faces=mesh.faces[np.arange(len(mesh.faces)) % 3 > 0])


def worst(checks: Sequence[Check]) -> str:
    """Return the worst verdict among checks."""
    found = {check.verdict for check in checks}
    return next(each for each in ("refused", "noted", "passed") if each in found)


def reasons(checks: Sequence[Check]) -> str:
    """Return what the checks that did not pass found; of a refused part, why it is refused."""
    refused = [check for check in checks if check.verdict == "refused"]
    told = refused or [check for check in checks if check.verdict == "noted"]
    return "; ".join(f"{check.name}: {check.what}" for check in told)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a table of meshes and verdicts, and their sum."""
    options, save = _options(arguments)
    folders = options.folders or [_needed() / each for each in SETS]
    profile = Profile(printer=printer(options.printer), material=material(options.material))
    endings = {f".{ending}" for ending in READERS}
    paths = [
        path
        for folder in folders
        for path in ([folder] if folder.is_file() else sorted(folder.rglob("*")))
        if path.suffix.lower() in endings
    ]
    if not paths:
        sys.exit(f"no mesh ({', '.join(sorted(endings))}) in {', '.join(map(str, folders))}")
    rows = []
    for path in paths:
        rows.append(judged(path, options.unit, profile))
        if not options.json:
            row = rows[-1]
            print(f"{row.file:48s} {row.verdict:8s} {row.seconds:6.2f} s  {row.why}")
    total = {
        folder: dict(Counter(row.verdict for row in rows if row.file.startswith(f"{folder}/")))
        for folder in sorted({row.file.rpartition("/")[0] for row in rows})
    }
    seconds = sum(row.seconds for row in rows)
    written = {"rows": [asdict(row) for row in rows], "total": total, "seconds": seconds}
    if options.json:
        print(json.dumps(written, indent=1))
    else:
        for folder, counts in total.items():
            print(f"{folder}: " + ", ".join(f"{n} {verdict}" for verdict, n in counts.items()))
        slowest = max(row.seconds for row in rows)
        print(f"{len(rows)} meshes in {seconds:.1f} s of a processor, the slowest {slowest:.2f}")
    if save:
        save(**headline(rows))
    if options.out:
        write_whole(options.out, json.dumps(written, indent=1).encode())


def _needed() -> Path:
    try:
        return need_robots(*(each.split("/")[0] for each in SETS))
    except MorphError as error:
        sys.exit(f"error: {error}")


def headline(rows: Sequence[Row]) -> JSON:
    """Return what a result file holds: verdicts by folder, and seconds of a processor."""
    figures: JSON = {"meshes": len(rows), "seconds": sum(row.seconds for row in rows)}
    for folder in sorted({row.file.rpartition("/")[0] for row in rows}):
        mine = [row for row in rows if row.file.startswith(f"{folder}/")]
        figures[f"{figure_name(folder)}_meshes"] = len(mine)
        for verdict in ("passed", "noted", "refused", "unreadable"):
            count = sum(row.verdict == verdict for row in mine)
            figures[f"{figure_name(folder)}_{verdict}"] = count
    controls = {}
    for way in SPOILED:
        verdicts = [row.spoiled[way] for row in rows if way in row.spoiled]
        controls[way] = {"copies": len(verdicts), "refused": verdicts.count("refused")}
    return {"figures": figures, "controls": controls, "rows": [asdict(row) for row in rows]}


def _options(arguments: Sequence[str] | None) -> tuple[argparse.Namespace, Save]:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.print_gate",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folders", type=Path, nargs="*", help="folders of meshes, or meshes")
    parser.add_argument("--unit", choices=tuple(MILLIMETRES), default="m", help="of the meshes")
    parser.add_argument("--printer", default="mk4", help="name of the printer")
    parser.add_argument("--material", default="pla", help="name of the plastic")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--out", type=Path, help="write the JSON to this file, too")
    return parse_and_save(parser, arguments, module="experiments.print_gate")


if __name__ == "__main__":
    main()
