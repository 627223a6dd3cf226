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
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

from experiments.plant.originals import packaged_root, robots_root
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.corpus
  python -m experiments.corpus --set packaged --list
  python -m experiments.corpus my_robots --json --out out/corpus.json
"""

ENDINGS = (".urdf", ".xacro", ".xml")
"""Endings of descriptions."""

LOST = 1e-9
"""Part of the mass that may go missing, as rounding."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One description."""

    file: str
    """Its path below the set's folder."""
    verdict: str
    """`ok`, `repaired`, `refused`, or `crash`."""
    codes: tuple[tuple[str, str], ...]
    """Code and severity of each finding."""
    why: str
    """Of a refusal or a crash: the first reason."""
    seconds: float
    """Time of one inspection, with Pinocchio's second opinion."""
    mass: float | None
    """kg, as morph simulates it."""
    stated: float | None
    """kg, the sum of the masses in the text, counted apart from morph's reader."""
    differs: float | None
    """Greatest relative difference to Pinocchio's reading; None if Pinocchio cannot read it."""
    explained: bool
    """Whether a repair explains a difference."""
    mujoco: str
    """What MuJoCo does with the file as it is: `loads`, `loses mass` or `fails`."""
    bare: str
    """The same without the file's shapes, so that no missing mesh is in its way."""


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
    from morph.body.agreement import EXPLAIN
    from morph.body.inspect import inspect_robot

    began = time.monotonic()
    try:
        found = inspect_robot(path)
    except Exception as error:  # The importer promises never to raise: that is a result too.
        return _crash(root, path, error)
    seconds = time.monotonic() - began
    refused = [finding for finding in found.findings if finding.severity == "refused"]
    repaired = {finding.code for finding in found.findings if finding.severity == "repaired"}
    differs = None if found.robot is None else _differs(found.robot)
    return Row(
        file=str(path.relative_to(root)),
        verdict=found.verdict,
        codes=tuple((finding.code, finding.severity) for finding in found.findings),
        why=f"{refused[0].where.name}: {refused[0].what}" if refused else "",
        seconds=seconds,
        mass=None if found.robot is None else found.robot.mass,
        stated=_stated(path),
        differs=differs,
        explained=bool(repaired & EXPLAIN),
        mujoco=_as_it_is(path),
        bare=_as_it_is(path, shapes=False),
    )


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
        differs=None,
        explained=False,
        mujoco=_as_it_is(path),
        bare=_as_it_is(path, shapes=False),
    )


def _stated(path: Path) -> float | None:
    """Return the sum of a URDF's masses, read by a library that shares nothing with morph."""
    if path.suffix.lower() != ".urdf":
        return None
    from lxml import etree

    try:
        masses = etree.parse(path).xpath("/robot/link/inertial/mass/@value")
        return float(sum(map(float, masses)))
    except (etree.XMLSyntaxError, ValueError):
        return None


def _as_it_is(path: Path, *, shapes: bool = True) -> str:
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
    stated = _stated(path)
    if stated is not None and abs(model.body_mass.sum() - stated) > LOST * max(stated, 1e-9):
        return "loses mass"
    return "loads"


def lost(rows: Iterable[Row]) -> list[Row]:
    """Return the descriptions whose mass differs from the text's, and no repair says so."""
    return [
        row
        for row in rows
        if row.mass is not None
        and row.stated is not None
        and abs(row.mass - row.stated) > LOST * max(row.stated, 1e-9)
        and not any(
            severity == "repaired" and code in ("mass-missing", "inertia-broken")
            for code, severity in row.codes
        )
    ]


def summary(rows: Sequence[Row]) -> str:
    """Return the table."""
    count = len(rows)
    verdicts = Counter(row.verdict for row in rows)
    lines = [f"{count} descriptions"]
    lines += [f"  {verdicts[name]:5d} {name}" for name in ("ok", "repaired", "refused", "crash")]
    for title, alone in (
        ("with the files as they are", Counter(row.mujoco for row in rows)),
        ("without their shapes", Counter(row.bare for row in rows)),
    ):
        shares = (
            f"{alone[name]} {name} ({alone[name] / max(count, 1):.0%})"
            for name in ("loads", "loses mass", "fails")
        )
        lines.append(f"MuJoCo alone, {title}: {', '.join(shares)}")
    silent = lost(rows)
    lines.append(f"mass lost or gained in silence: {len(silent)}")
    lines += [f"        {row.file}: {row.stated:g} kg, simulated {row.mass:g}" for row in silent]
    read = [row for row in rows if row.differs is not None]
    agree = sum(row.differs is not None and row.differs <= 1e-9 for row in read)
    explained = sum(
        row.differs is not None and row.differs > 1e-9 and row.explained for row in read
    )
    lines.append(
        f"Pinocchio reads {len(read)} of those that load: {agree} agree to 1e-9, "
        f"{explained} differ by a named repair, {len(read) - agree - explained} without one"
    )
    apart = [row.file for row in rows if any(code == "agreement" for code, _ in row.codes)]
    lines.append(
        f"of the rest, and of what is repaired, it reads what MuJoCo is given: "
        f"{len(rows) - verdicts['refused'] - len(read)} files that it cannot read itself, "
        f"{len(apart)} findings of agreement"
    )
    lines.append("findings (descriptions with it, in all):")
    per_code = Counter(key for row in rows for key in set(row.codes))
    total = Counter(key for row in rows for key in row.codes)
    for (code, severity), number in sorted(per_code.items()):
        lines.append(f"  {number:5d} {total[code, severity]:6d}  {code} ({severity})")
    seconds = sorted(row.seconds for row in rows)
    lines.append(
        f"seconds a description: middle {seconds[len(seconds) // 2]:.2f}, most {seconds[-1]:.2f}"
    )
    for row in rows:
        if row.verdict in ("refused", "crash"):
            lines.append(f"{row.verdict}: {row.file}\n    {row.why}")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status: 0 without crashes and silent losses, else 1."""
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
    parser.add_argument("--processes", type=int, default=2, help="how many at once")
    parser.add_argument("--list", action="store_true", help="show every description")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--out", type=Path, help="write the JSON there too")
    asked = parser.parse_args(arguments)
    roots = asked.folder or [robots_root() if asked.set == "real" else packaged_root()]
    tasks = descriptions(roots)
    if not tasks:
        sys.stderr.write(
            f"error: no description below {', '.join(map(str, roots))}\n"
            "  fix: name folders, or the real robots' by MORPH_ROBOTS\n"
        )
        return 2
    began = time.monotonic()
    rows = []
    with get_context("spawn").Pool(asked.processes) as pool:
        for done, one in enumerate(pool.imap(row, tasks, chunksize=4), start=1):
            rows.append(one)
            if sys.stderr.isatty():
                sys.stderr.write(f"\r{done} of {len(tasks)}")
    wall = time.monotonic() - began
    content = json.dumps({"seconds": wall, "rows": [asdict(one) for one in rows]}, indent=2)
    if asked.out:
        write_whole(asked.out, content + "\n")
    if asked.json:
        print(content)
    else:
        if asked.list:
            for one in rows:
                print(f"{one.verdict:9s} {one.seconds:6.2f} s  {one.file}")
        print(summary(rows))
        print(f"{wall:.1f} s in all, with {asked.processes} processes")
    bad = [one for one in rows if one.verdict == "crash"] + lost(rows)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
