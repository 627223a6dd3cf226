"""What the gate before the slicer says of the meshes that other people published.

Each mesh counts as one printed part. STL says nothing of its unit: meshes of robots are in
metres, so a folder is read in metres unless `--unit` says otherwise.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from experiments.plant.originals import robots_root
from morph.body.mesh import read_mesh
from morph.body.mesh.read import READERS
from morph.errors import MorphError
from morph.files import write_whole
from print.gate import check_part
from print.mesh import Mesh
from print.part import Check, Part, Placement
from print.printer import Profile, material, printer

EXAMPLE = """example:
  python -m experiments.print_gate
  python -m experiments.print_gate my_parts --unit mm --printer mini --json --out out/gate.json
"""

SETS = ("open_duck_mini_v2/urdf", "poppy_humanoid/meshes")
"""What is read if nothing is named, below the folder of real robots."""
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


def judged(path: Path, unit: str, profile: Profile) -> Row:
    """Return what becomes of one file."""
    name = f"{path.parent.name}/{path.name}"
    try:
        read = read_mesh(path.read_bytes(), path.suffix, path.name)
    except MorphError as error:
        return Row(file=name, verdict="unreadable", why=error.what, seconds=0.0)
    mesh = Mesh(vertices=read.vertices * MILLIMETRES[unit], faces=read.faces)
    here = (Placement(link="", pose=np.eye(4), world=np.eye(4)),)
    part = Part(name=path.stem.lower(), kind="printed", mesh=mesh, placements=here)
    began = time.process_time()
    _, checks = check_part(part, profile)
    seconds = time.process_time() - began
    return Row(file=name, verdict=worst(checks), why=reasons(checks), seconds=seconds)


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
    options = _options(arguments)
    folders = options.folders or [robots_root() / each for each in SETS]
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
    if options.out:
        write_whole(options.out, json.dumps(written, indent=1).encode())


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
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
    return parser.parse_args(arguments)


if __name__ == "__main__":
    main()
