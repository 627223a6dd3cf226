"""How near the estimate without a slicer comes to what PrusaSlicer's G-code weighs, part by part.

Meshes are taken in millimetres; those of less than 2 mm are metres. Beside the estimate stand
what one would take without it: the plastic of the solid, that times the infill, and the solid's
centre and inertia with the mass of the G-code. A part of which no solid can be made, or that
fits the bed in no orientation, is named and left out.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_robots
from experiments.orient import add_part_options, read, stl_files
from morph.arrays import JSON
from morph.errors import MorphError
from morph.print.arrays import Array
from morph.print.errors import PrintError
from morph.print.estimate import estimated
from morph.print.mesh import Mesh
from morph.print.orient import orient
from morph.print.part import Part
from morph.print.printer import Profile, material, printer
from morph.print.repair import repaired
from morph.print.sliced import Sliced
from morph.print.slicer import find_slicer
from morph.print.weight import Weight
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.print_mass
  python -m experiments.print_mass robots/quadruped_printed/meshes --infill 0.3 --json"""

DUCK = "open_duck_mini_v2/urdf"
"""Printed parts that the estimate was not fitted to."""

COLUMNS = {
    "solid_g": "solid g",
    "infill_g": "x infill g",
    "sliced_g": "sliced g",
    "estimate_g": "estimate g",
    "mass_percent": "error %",
    "com_mm": "centre mm",
    "inertia_percent": "inertia %",
    "solid_com_mm": "solid's centre mm",
    "solid_inertia_percent": "scaled inertia %",
}
"""What the table shows of each part."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One part."""

    path: str
    """Its file."""
    infill: float
    """Part of the inside that is filled."""
    as_given: bool
    """Whether it is printed as it is drawn, not as the search turns it."""
    printer: str
    """Name of the printer."""
    material: str
    """Name of the plastic."""

    @property
    def profile(self) -> Profile:
        """How it is printed."""
        return Profile(
            printer=printer(self.printer), material=material(self.material), infill=self.infill
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Slice and estimate every part, and print what each says."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.print_mass",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_part_options(parser, default="Open Duck Mini")
    parser.add_argument("--infill", type=float, default=0.15)
    parser.add_argument("--as-given", action="store_true", help="do not turn the parts")
    add_engine_options(parser, out="out/print_mass")
    parser.add_argument("--json", action="store_true", help="print every number as JSON")
    given, save = parse_and_save(parser, arguments, module="experiments.print_mass")
    if find_slicer() is None:
        print("PrusaSlicer is not installed: apt-get install prusa-slicer", file=sys.stderr)
        return 2
    try:
        folders = given.meshes or [need_robots("open_duck_mini_v2") / DUCK]
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    cases = [
        Case(
            path=str(path),
            infill=given.infill,
            as_given=given.as_given,
            printer=given.printer,
            material=given.material,
        )
        for path in stl_files(folders, given.skip)
    ]
    profile = cases[0].profile
    cells = [cells_of(row, [case], data=[Path(case.path)])[0] for case in cases]
    rows = rows_of(cells, given, name="print_mass")
    done = [each for each in rows if "why" not in each]
    if save:
        save(**headline(rows, done))
    if given.json:
        print(json.dumps({"parts": rows, "profile": asdict(profile), "mean": summary(done)}))
        return 0
    _show(rows, done)
    return 0


def row(case: Case) -> JSON:
    """Return what the slicer, the estimate and the solid say of one part."""
    name, profile = Path(case.path).stem, case.profile
    slicer = find_slicer()
    try:
        mesh = repaired(read(Path(case.path)), where=name).mesh
        part = Part(name="part", kind="printed", mesh=mesh, placements=())
        lies = orient(mesh, profile)
        if case.as_given:
            lies = type(lies)(**{**vars(lies), "turn": np.eye(3)})
        began = process_time()
        ours = estimated(part, lies, profile)
        seconds = process_time() - began
        if slicer is None:
            raise FileNotFoundError("PrusaSlicer")
        theirs = slicer.sliced(part, lies, profile)
    except PrintError as error:
        return {"part": name, "why": error.what}
    return {
        "part": name,
        **compared(ours, theirs, solid(mesh, profile), profile),
        "estimate_s": seconds,
        "warnings": list(theirs.warnings),
    }


def compared(ours: Sliced, theirs: Sliced, full: Weight, profile: Profile) -> JSON:
    """Return the masses, and how far the others are from the slicer's."""
    truth = theirs.weight
    return {
        "solid_g": 1e3 * full.mass,
        "infill_g": 1e3 * full.mass * profile.infill,
        "sliced_g": 1e3 * truth.mass,
        "estimate_g": 1e3 * ours.weight.mass,
        "mass_percent": 100.0 * (ours.weight.mass / truth.mass - 1.0),
        "com_mm": 1e3 * float(np.linalg.norm(ours.weight.com - truth.com)),
        "inertia_percent": _apart(ours.weight.inertia, truth.inertia),
        "solid_com_mm": 1e3 * float(np.linalg.norm(full.com - truth.com)),
        "solid_inertia_percent": _apart(full.scaled(truth.mass).inertia, truth.inertia),
        "away_g": 1e3 * theirs.support_kg,
        "away_estimate_g": 1e3 * ours.support_kg,
        "hours": theirs.seconds / 3600.0,
        "hours_estimate": ours.seconds / 3600.0,
    }


def solid(mesh: Mesh, profile: Profile) -> Weight:
    """Return a mesh filled with plastic, by trimesh's integrals."""
    shape = mesh.trimesh
    density = profile.material.density
    return Weight(
        mass=density * float(shape.volume) * 1e-9,
        com=np.asarray(shape.center_mass) * 1e-3,
        inertia=density * np.asarray(shape.moment_inertia) * 1e-15,
    )


def headline(rows: Sequence[JSON], done: Sequence[JSON]) -> JSON:
    """Return what a result file holds: errors beside those of what needs no estimate."""
    told = summary(done)
    controls = {
        "solid plastic": {"grams": told["solid_g"], "com_mm": told["worst_solid_com_mm"]}
        | {"inertia_percent": told["worst_solid_inertia_percent"]},
        "volume times infill": {"grams": told["infill_g"]},
    }
    figures = {"left_out": len(rows) - len(done)} | told
    return {"figures": figures, "controls": controls, "rows": rows}


def summary(rows: Sequence[JSON]) -> JSON:
    """Return sums, means and the worst of all parts."""
    if not rows:
        return {}
    numbers = {key: np.array([float(each[key]) for each in rows]) for key in COLUMNS}
    absolute = (
        "mass_percent",
        "com_mm",
        "inertia_percent",
        "solid_com_mm",
        "solid_inertia_percent",
    )
    grams = ("solid_g", "infill_g", "sliced_g", "estimate_g")
    sums = ("away_g", "away_estimate_g", "hours", "hours_estimate", "estimate_s")
    return {
        "parts": len(rows),
        **{key: float(numbers[key].sum()) for key in grams},
        **{key: float(sum(float(each[key]) for each in rows)) for key in sums},
        **{f"mean_{key}": float(np.abs(numbers[key]).mean()) for key in absolute},
        **{f"worst_{key}": float(np.abs(numbers[key]).max()) for key in absolute},
        "warned": sum(bool(each["warnings"]) for each in rows),
    }


def _apart(ours: Array, theirs: Array) -> float:
    """Return how far two inertias are apart, by the Frobenius norm, in per cent."""
    return 100.0 * float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs))


def _show(rows: Sequence[JSON], done: Sequence[JSON]) -> None:
    table = Table("part", *COLUMNS.values())
    for each in done:
        table.add_row(each["part"], *(f"{each[key]:.2f}" for key in COLUMNS))
    Console(width=150).print(table)
    for each in rows:
        if "why" in each:
            print(f"left out: {each['part']}: {each['why']}")
    for name, value in summary(done).items():
        print(f"{name}: {value:.2f}")


if __name__ == "__main__":
    sys.exit(main())
