"""Plant every mutant in a copy of the working tree, and report which ones the tests kill."""

from __future__ import annotations

import argparse
import fnmatch
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from experiments.engine_options import add_engine_options, results_of
from experiments.figures.__main__ import close_pipe
from experiments.figures.save_options import parse_and_save
from experiments.mutants.mutant import Area, MutantError, load_areas
from experiments.mutants.trial import EXCLUDED, Row, try_area
from morph.arrays import JSON
from morph.errors import MorphError
from morph.study.cell import Cell, cells_of

EXAMPLE = """examples:
  .venv/bin/python -m experiments.mutants --list
  .venv/bin/python -m experiments.mutants --area guard
  .venv/bin/python -m experiments.mutants --workers 2 --resume
"""
LISTS = Path(__file__).resolve().parent
ROOT = LISTS.parents[1]
GOAL = 0.95
"""Share of the mutants that the tests must kill."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status: 1 if too many mutants survive."""
    options, save = parse_and_save(_parser(), arguments, module="experiments.mutants.__main__")
    try:
        lists, root = options.mutants or LISTS, options.root or ROOT
        areas = load_areas(lists, options.area)
        if options.list:
            show_list(areas)
            sys.stdout.flush()
            return 0
        check_applied(areas, root)
        cells = [cell_of(area, lists, root, options.timeout) for area in areas]
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        return close_pipe()
    by_area = []
    for result in results_of(cells, options, name="mutants"):
        if result.status != "done":
            refusal = result.error or {}
            parts = [str(refusal.get(part, "")) for part in ("where", "what", "fix")]
            print(MutantError(parts[1], where=parts[0], fix=parts[2]), file=sys.stderr)
            return 2
        by_area.append(result.row)
    rows = [Row(**row) for area in by_area for row in area["mutants"]]
    report(rows)
    if save:
        save(**headline(by_area))
    return 0 if killed(rows) >= GOAL * len(rows) else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.mutants",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--area", help="one area instead of all")
    parser.add_argument("--list", action="store_true", help="show the mutants and run nothing")
    parser.add_argument(
        "--timeout", type=float, help="seconds after which tests hang (default: 8 times as usual)"
    )
    parser.add_argument("--mutants", type=Path, help="folder of the lists (default: these)")
    parser.add_argument("--root", type=Path, help="repository that is copied (default: this)")
    add_engine_options(parser, out="out/mutants")
    return parser


def check_applied(areas: Sequence[Area], root: Path) -> None:
    """Check that every mutant applies to a repository.

    Raises:
        MutantError: A file is missing, or a text does not occur exactly once.
    """
    for mutant in (mutant for area in areas for mutant in area.mutants):
        try:
            source = (root / mutant.file).read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            raise MutantError(
                f"cannot be read: {getattr(error, 'strerror', None) or error}",
                where=str(root / mutant.file),
                fix="let --root name a repository that has the files of the lists",
            ) from error
        mutant.apply(source)


def cell_of(area: Area, lists: Path, root: Path, timeout_s: float | None) -> Cell:
    """Return the cell of an area, with every file of the tree and its list as data."""
    case = {
        "root": str(root.resolve()),
        "lists": str(lists.resolve()),
        "area": area.name,
        "timeout_s": timeout_s,
    }
    files = [lists / f"{area.name}.toml", *tree_files(root)]
    return cells_of(try_area, [case], data=files)[0]


def tree_files(root: Path) -> Iterator[Path]:
    """Yield the files of a repository that `copy_tree` copies."""
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(name for name in folders if not _excluded(name))
        paths = (Path(folder, name) for name in sorted(files) if not _excluded(name))
        yield from (path for path in paths if path.is_file())


def _excluded(name: str) -> bool:
    return any(fnmatch.fnmatch(name, pattern) for pattern in EXCLUDED)


def headline(by_area: Sequence[JSON]) -> JSON:
    """Return figures, controls and rows: kills and survivors, in all and by area.

    Args:
        by_area: Rows of `try_area`.
    """
    rows = [Row(**row) for area in by_area for row in area["mutants"]]
    figures: JSON = {
        "mutants": len(rows),
        "killed": killed(rows),
        "survived": len(rows) - killed(rows),
        "hung": sum(row.outcome == "hangs" for row in rows),
        "killed_percent": 100.0 * killed(rows) / len(rows),
        "cpu_minutes": sum(row.cpu_s for row in rows) / 60.0,
    }
    baseline: JSON = {}
    for area in by_area:
        own = [row for row in rows if row.area == area["area"]]
        figures |= {f"{area['area']}_mutants": len(own), f"{area['area']}_killed": killed(own)}
        # Tests that fail without a mutant are refused: the kills without a mutant are 0.
        baseline[area["area"]] = {"killed": 0} | area["baseline"]
    controls = {"no mutant": {"killed": 0, "areas": len(by_area)} | baseline}
    return {"figures": figures, "controls": controls, "rows": [vars(row) for row in rows]}


def killed(rows: Sequence[Row]) -> int:
    """Return the number of mutants killed, those that hang included."""
    return sum(row.outcome != "survived" for row in rows)


def show_list(areas: Sequence[Area]) -> None:
    """Print every mutant."""
    for area in areas:
        print(f"{area.name}: {len(area.mutants)} mutants")
        for mutant in area.mutants:
            print(f"  {mutant.file}: {mutant.breaks}")


def report(rows: Sequence[Row]) -> None:
    """Print a table by area, the mutants that survived or hung, and the sum."""
    print(f"{'area':12} {'killed':>9} {'CPU min':>8}")
    for name in dict.fromkeys(row.area for row in rows):
        own = [row for row in rows if row.area == name]
        minutes = sum(row.cpu_s for row in own) / 60.0
        print(f"{name:12} {f'{killed(own)}/{len(own)}':>9} {minutes:8.1f}")
    _report_some(rows, lambda row: row.outcome == "survived", "survived")
    _report_some(rows, lambda row: row.outcome == "hangs", "killed by the timeout alone")
    print(f"{killed(rows)} of {len(rows)} mutants killed")


def _report_some(rows: Sequence[Row], condition: Callable[[Row], bool], title: str) -> None:
    some = [row for row in rows if condition(row)]
    if some:
        print(f"{title}:")
    for row in some:
        print(f"  {row.area}, {row.file}: {row.breaks}")


if __name__ == "__main__":
    sys.exit(main())
