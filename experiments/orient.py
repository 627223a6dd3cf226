"""What turning a part saves: support and time by PrusaSlicer, as given, turned, and by chance.

Meshes are taken in millimetres; those of less than 2 mm are metres. A part that a slicer cannot
print as it lies (it is off the bed) is left out of all three, and said so.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
import trimesh
from rich.console import Console
from rich.table import Table

from experiments.figures.save_options import parse_and_save
from experiments.needs import need_robots
from morph.arrays import JSON
from morph.errors import MorphError
from morph.print.arrays import Array
from morph.print.bed import about_up, hull
from morph.print.errors import PrintError
from morph.print.job import Orientation
from morph.print.mesh import Mesh
from morph.print.orient import orient
from morph.print.part import Part, Placement
from morph.print.printer import Profile, material, printer
from morph.print.slicer import Slicer, find_slicer

EXAMPLE = """example:
  python -m experiments.orient --skip bms board cell"""


DUCK, OURS = "open_duck_mini_v2/urdf", Path("robots/quadruped_printed/meshes")
"""Folders of printed parts: one of the published robots, and one of the shelf."""

HEADS = ("part", "search s", "given g", "turned g", "chance g", "given h", "turned h", "chance h")
"""Seconds that the search took; support and skirt in grams, and hours, each way."""


@dataclass(frozen=True, kw_only=True)
class Tried:
    """One part in one orientation, as the slicer sees it."""

    support_g: float
    """Support, skirt and brim, g."""
    seconds: float
    """Time of the print."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Slice every mesh in three orientations, and print what each costs."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.orient",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_part_options(parser, default="our quadruped and Open Duck Mini")
    parser.add_argument("--seed", type=int, default=0, help="of the random orientations")
    given, save = parse_and_save(parser, arguments, module="experiments.orient")
    slicer = find_slicer()
    if slicer is None:
        print("PrusaSlicer is not installed: apt-get install prusa-slicer", file=sys.stderr)
        return 2
    profile = Profile(printer=printer(given.printer), material=material(given.material))
    rng = np.random.default_rng(given.seed)
    table = Table(*HEADS)
    rows = []
    try:
        meshes = given.meshes or [OURS, need_robots("open_duck_mini_v2") / DUCK]
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for path in stl_files(meshes, given.skip):
        try:
            rows.append(_row(path, slicer, profile, rng, table))
        except PrintError as error:
            print(f"{path.stem}: {error.what}", file=sys.stderr)
    _total(rows, table)
    Console().print(table)
    if save:
        save(**headline(rows), seeds=[given.seed])
    return 0


def headline(rows: Sequence[tuple[Tried, Tried, Tried]]) -> JSON:
    """Return what a result file holds: support, g, and hours in all, each way."""
    ways = {
        name: {
            "support_g": sum(row[place].support_g for row in rows),
            "hours": sum(row[place].seconds for row in rows) / 3600.0,
        }
        for place, name in enumerate(("as drawn", "turned", "by chance"))
    }
    turned = ways.pop("turned")
    drawn = {f"as_drawn_{key}": value for key, value in ways["as drawn"].items()}
    chance = {f"by_chance_{key}": value for key, value in ways["by chance"].items()}
    return {
        "figures": {"parts": len(rows)} | turned | drawn | chance,
        "controls": ways,
        "rows": [
            {"as_drawn": asdict(row[0]), "turned": asdict(row[1]), "by_chance": asdict(row[2])}
            for row in rows
        ],
    }


def add_part_options(parser: argparse.ArgumentParser, *, default: str) -> None:
    """Add the options of a study of parts: the meshes, those left out, printer and plastic.

    Args:
        parser: The study's.
        default: What is read without meshes, in words.
    """
    parser.add_argument(
        "meshes", nargs="*", type=Path, help=f"STL files or folders; by default {default}"
    )
    parser.add_argument("--skip", nargs="*", default=(), help="names of files to leave out")
    parser.add_argument("--printer", default="mk4")
    parser.add_argument("--material", default="pla")


def stl_files(paths: Sequence[Path], skip: Sequence[str]) -> list[Path]:
    """Return the STL files of folders, and files themselves, but those whose stems are skipped."""
    found = [each for path in paths for each in (sorted(path.glob("*.[sS][tT][lL]")) or [path])]
    return [path for path in found if path.stem not in skip]


def _row(
    path: Path, slicer: Slicer, profile: Profile, rng: np.random.Generator, table: Table
) -> tuple[Tried, Tried, Tried]:
    mesh = read(path)
    here = Placement(link="part", pose=np.eye(4), world=np.eye(4))
    part = Part(name=path.stem.lower(), kind="printed", mesh=mesh, placements=(here,))
    begun = perf_counter()
    turned = orient(mesh, profile)
    took = perf_counter() - begun
    ways = (np.eye(3), turned.turn, by_chance(mesh, profile, rng))
    as_given, chosen, chance = (_tried(part, way, slicer, profile) for way in ways)
    _line(table, part.name, f"{took:.2f}", (as_given, chosen, chance))
    print(part.name, as_given, chosen, chance, file=sys.stderr)
    return as_given, chosen, chance


def read(path: Path) -> Mesh:
    """Return the mesh of a file in millimetres, its coinciding corners one."""
    shape = trimesh.load_mesh(path)
    vertices = np.asarray(shape.vertices, dtype=np.float64)
    scale = 1000.0 if np.ptp(vertices, axis=0).max() < 2.0 else 1.0
    return Mesh(vertices=vertices * scale, faces=np.asarray(shape.faces, dtype=np.int64))


def by_chance(mesh: Mesh, profile: Profile, rng: np.random.Generator) -> Array:
    """Return a random rotation under which a mesh fits the bed."""
    outline = hull(mesh)
    for _ in range(1000):
        turn = np.array(trimesh.transformations.random_rotation_matrix(rng.random(3)))[:3, :3]
        upright = about_up(outline @ turn.T, profile)
        if upright is not None:
            return np.asarray(upright @ turn)
    return np.eye(3)


def _tried(part: Part, turn: Array, slicer: Slicer, profile: Profile) -> Tried:
    lies = Orientation(turn=turn, support_mm3=0.0, first_support_mm3=0.0, height_mm=0.0)
    found = slicer.sliced(part, lies, profile)
    return Tried(support_g=1e3 * found.support_kg, seconds=found.seconds)


def _total(rows: Sequence[tuple[Tried, Tried, Tried]], table: Table) -> None:
    total = [
        Tried(support_g=sum(each.support_g for each in way), seconds=sum(e.seconds for e in way))
        for way in zip(*rows, strict=True)
    ]
    if total:
        table.add_section()
        _line(table, f"all {len(rows)}", "", (total[0], total[1], total[2]))


def _line(table: Table, name: str, took: str, ways: tuple[Tried, Tried, Tried]) -> None:
    table.add_row(
        name,
        took,
        *(f"{each.support_g:.2f}" for each in ways),
        *(f"{each.seconds / 3600.0:.2f}" for each in ways),
    )


if __name__ == "__main__":
    raise SystemExit(main())
