"""What becomes of descriptions that other people published: loaded, repaired or refused.

Beside each stands what MuJoCo does with the file as it is, and whether Pinocchio's own
reading of it has the mass, the centre of mass and the joint-space inertia that morph
simulates.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

from experiments.corpus_masses import LOST, judge_masses, stated_masses
from experiments.corpus_repairs import AGREE, judge_difference
from experiments.corpus_summary import Row, headline, lost, summary
from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_packaged, need_robots
from experiments.plant.originals import packaged_root, robots_root
from morph.arrays import JSON
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.study.cell import Cell, cells_of

EXAMPLE = """example:
  python -m experiments.corpus
  python -m experiments.corpus --set packaged --list
  python -m experiments.corpus my_robots --fresh --json > corpus.json
"""

ENDINGS = (".urdf", ".xacro", ".xml")
"""Endings of descriptions."""


def descriptions(roots: Sequence[Path]) -> list[tuple[Path, Path]]:
    """Return every description below some folders, each with its folder."""
    found = []
    for root in roots:
        for path in sorted(root.rglob("*")):
            if path.suffix.lower() in ENDINGS and path.is_file() and _is_robot(path):
                found.append((root, path))
    return found


def _is_robot(path: Path) -> bool:
    # Parts that others include, sensors and packages are no descriptions of a robot.
    text = path.read_bytes()[:200_000]
    if path.suffix.lower() == ".xacro":
        return b"<xacro:macro" not in text and b"<robot" in text and b"<xacro:include" in text
    if path.suffix.lower() == ".xml":
        return b"<mujoco" in text and b"<worldbody" in text
    return b"<robot" in text


def row(task: tuple[Path, Path]) -> Row:
    """Return what becomes of one description."""
    logging.disable(logging.CRITICAL)
    root, path = task
    from morph.body.inspect import inspect_robot

    began = time.monotonic()
    try:
        found = inspect_robot(path)
    except Exception as error:  # The importer promises never to raise: that is a result too.
        return _crash(root, path, error)
    seconds = time.monotonic() - began
    refused = [finding for finding in found.findings if finding.severity == "refused"]
    robot, masses, differs, explained = found.robot, None, None, (False, "")
    if robot is not None:
        masses = judge_masses(path, robot, found.findings)
        differs = _differs(robot)
        if differs is not None and differs > AGREE:
            explained = judge_difference(path, robot, found.findings)
    return Row(
        file=str(path.relative_to(root)),
        verdict=found.verdict,
        codes=tuple((finding.code, finding.severity) for finding in found.findings),
        why=f"{refused[0].where.name}: {refused[0].what}" if refused else "",
        seconds=seconds,
        mass=masses.simulated if masses else None,
        stated=masses.stated if masses else None,
        named=masses.named if masses else 0,
        silent="; ".join(masses.silent) if masses else "",
        uncounted=masses.uncounted if masses else "",
        differs=differs,
        explained=explained[0],
        explained_by=explained[1],
        mujoco=mujoco_alone(path),
        bare=mujoco_alone(path, shapes=False),
    )


def described(root: str, file: str) -> Row:
    """Return what becomes of one description, for a worker."""
    return row((Path(root), Path(root, file)))


def cell_of(root: Path, path: Path) -> Cell:
    """Return the cell of one description; its meshes are not watched for changes."""
    case = {"root": str(root), "file": str(path.relative_to(root))}
    return cells_of(described, [case], data=[path])[0]


def _row(told: JSON) -> Row:
    codes = tuple((code, severity) for code, severity in told["codes"])
    return Row(**{field.name: told[field.name] for field in fields(Row)} | {"codes": codes})


def mujoco_alone(path: Path, *, shapes: bool = True) -> str:
    """Return what MuJoCo does with a file: `loads`, `loses mass` or `fails`.

    Args:
        path: The file.
        shapes: Whether with its shapes; without them no missing mesh is in its way.
    """
    import mujoco
    from lxml import etree

    from morph.body.quiet import quiet, silent

    try:
        with quiet(), silent():
            if shapes or path.suffix.lower() != ".urdf":
                model = mujoco.MjModel.from_xml_path(str(path))
            else:
                tree = etree.parse(path)
                for shape in tree.xpath("/robot/link/visual | /robot/link/collision"):
                    shape.getparent().remove(shape)
                model = mujoco.MjModel.from_xml_string(etree.tostring(tree).decode())
    except (ValueError, etree.XMLSyntaxError):
        return "fails"
    if path.suffix.lower() == ".urdf":
        stated = sum(stated_masses(path).values())
        if abs(model.body_mass.sum() - stated) > LOST * max(stated, 1e-9):
            return "loses mass"
    return "loads"


def _differs(robot: Robot) -> float | None:
    from morph.body.agreement import difference, read_by_mujoco, read_by_pinocchio

    try:
        return difference(read_by_mujoco(robot), read_by_pinocchio(robot))
    except MorphError:
        return None


def _crash(root: Path, path: Path, error: Exception) -> Row:
    return Row(
        file=str(path.relative_to(root)),
        verdict="crash",
        codes=(),
        why=repr(error),
        seconds=0.0,
        mass=None,
        stated=None,
        named=0,
        silent="",
        uncounted="",
        differs=None,
        explained=False,
        explained_by="",
        mujoco=mujoco_alone(path),
        bare=mujoco_alone(path, shapes=False),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status: 1 after a crash, a silent loss or difference."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.corpus",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", nargs="*", type=Path, help="folders with descriptions")
    parser.add_argument(
        "--set",
        choices=("real", "packaged"),
        default="real",
        help="without folders: the real robots, or those of PyPI's example-robot-data",
    )
    parser.add_argument("--list", action="store_true", help="show every description")
    parser.add_argument("--json", action="store_true", help="print JSON")
    add_engine_options(parser, out="out/corpus")
    asked, save = parse_and_save(parser, arguments, module="experiments.corpus")
    roots = asked.folder or [robots_root() if asked.set == "real" else packaged_root()]
    try:
        if not asked.folder:
            need_robots() if asked.set == "real" else need_packaged()
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    tasks = descriptions(roots)
    if not tasks:
        sys.stderr.write(
            f"error: no description below {', '.join(map(str, roots))}\n"
            "  fix: name folders, or the real robots' by MORPH_ROBOTS\n"
        )
        return 2
    began = time.monotonic()
    cells = [cell_of(root, path) for root, path in tasks]
    rows = [_row(told) for told in rows_of(cells, asked, name="corpus")]
    wall = time.monotonic() - began
    if save:
        save(**headline(rows))
    if asked.json:
        print(json.dumps({"seconds": wall, "rows": [asdict(one) for one in rows]}, indent=2))
    else:
        if asked.list:
            for one in rows:
                print(f"{one.verdict:9s} {one.seconds:6.2f} s  {one.file}")
        print(summary(rows))
        print(f"{wall:.1f} s in all, with {asked.workers} workers")
    apart = [one for one in rows if (one.differs or 0.0) > AGREE and not one.explained]
    bad = [one for one in rows if one.verdict == "crash"] + lost(rows) + apart
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
