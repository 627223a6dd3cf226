"""Generate a suite of cases, let a solver answer them, score the answers against the truths.

Cases lie in OUT_cases/SUITE/cases, what only the scorer reads in OUT_cases/SUITE/truth. With
--submissions no solver runs: the answers of another tool are scored, one JSON a case.

Example: python -m experiments.concealed --suite development --seed 1 --cases 20
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.generate import generate
from experiments.concealed.score import score, unheard
from experiments.concealed.seal import open_seal
from experiments.concealed.solvers import SOLVERS, solver_of
from experiments.concealed.submission import JSON, check, load_submission
from experiments.concealed.suites import SUITES
from experiments.concealed.summary import summarise
from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from morph.study.cell import Cell, cells_of


def answered(case: str, solver: str, seed: int) -> JSON:
    """Return the answer of a solver to the case in a folder."""
    return check(solver_of(solver)(Path(case), seed), where=case)


def cell_of(case: Path, solver: str, seed: int) -> Cell:
    """Return the cell of one answer, known by the files that a solver may read."""
    files = sorted(path for path in case.rglob("*") if path.is_file())
    about = {"case": str(case), "solver": solver, "seed": seed}
    return cells_of(answered, [about], data=files)[0]


def main(arguments: list[str] | None = None) -> int:
    """Generate, solve, score, print; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.concealed",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    parser.add_argument("--suite", choices=SUITES, default="development", help="kind of cases")
    parser.add_argument("--seed", type=int, default=1, help="random seed of the cases")
    parser.add_argument("--cases", type=int, default=20, help="how many")
    parser.add_argument(
        "--solver", choices=SOLVERS, nargs="+", default=["morph"], help="who answers, one or more"
    )
    parser.add_argument("--only-generate", action="store_true", help="write the cases and end")
    parser.add_argument(
        "--submissions", type=Path, metavar="DIR", help="score these answers: DIR/<case>.json"
    )
    add_engine_options(parser, out="out/concealed")
    parser.add_argument("--json", action="store_true", help="print rows and figures as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.concealed")
    folder = asked.out.with_name(f"{asked.out.name}_cases") / asked.suite
    try:
        sys.stderr.write(f"generating {asked.cases} cases in {folder} ...\n")
        numbers = range(asked.cases)
        cases = generate(asked.suite, asked.seed, numbers, folder, workers=asked.workers)
        if asked.only_generate:
            return 0
        if asked.submissions is not None:
            tables = {
                "submitted": [load_submission(asked.submissions / f"{c.name}.json") for c in cases]
            }
        else:
            cells = [cell_of(case, name, asked.seed) for name in asked.solver for case in cases]
            answers = rows_of(cells, asked, name="concealed")
            parts = (answers[at : at + len(cases)] for at in range(0, len(answers), len(cases)))
            tables = dict(zip(asked.solver, parts, strict=True))
        sealed = [open_seal(case) for case in cases]
        rows = {
            name: [score(answer, truth) for answer, truth in zip(answers, sealed, strict=True)]
            for name, answers in tables.items()
        }
    except BenchmarkError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    for answers in tables.values():
        for answer, truth in zip(answers, sealed, strict=True):
            if names := unheard(answer, truth):
                about = f"{answer['case']}: no case has such a law, or this one no such part"
                sys.stderr.write(f"warning: {about}: {', '.join(names)}\n")
    figures = {name: summarise(scored) for name, scored in rows.items()}
    first = next(iter(rows))
    if save:
        save(
            figures=_flat(figures[first]),
            controls={
                **{name: _flat(each) for name, each in figures.items() if name != first},
                **_controls(rows[first]),
            },
            rows=rows[first],
            seeds=[asked.seed],
        )
    if asked.json:
        print(json.dumps({"rows": rows, "figures": figures}, indent=1))
    else:
        report(rows[first], figures)
    return 0


def _flat(figures: JSON) -> JSON:
    """Return figures and ends of their intervals by names of their own, without what is none."""
    flat: JSON = {}
    for name, figure in figures.items():
        if isinstance(figure, dict):
            flat |= {name: figure["value"]}
            flat |= {f"{name}_{end}": figure[end] for end in ("low90", "high90")}
        elif figure is not None:
            flat[name] = figure
    return flat


def _controls(rows: list[JSON]) -> JSON:
    """Return how often the answers of other cases, shuffled by one, would name a law first."""
    effects = [row for row in rows if row["answer"] == "effects"]
    shifted = [*effects[1:], *effects[:1]]
    right = [
        bool(row["found"])
        and row["found"][0].split("@")[0] in {each.split("@")[0] for each in other["truth"]}
        for row, other in zip(effects, shifted, strict=True)
    ]
    return {"answers shuffled": {"first": sum(right) / max(len(right), 1)}}


def report(rows: list[JSON], figures: JSON) -> None:
    """Print every row of one solver, then every figure of all, its 90 % interval below it."""
    for row in rows:
        mark = "=" if row["exact"] else "1" if row["first"] else "3" if row["first_three"] else " "
        truth = ", ".join(
            f"{each} x{ratio:.3g}"
            for each, ratio in zip(row["truth"], row["effect_to_noise"], strict=True)
        )
        said = ", ".join(row["found"]) + (" unknown" if row["unknown"] else "")
        print(f"{mark} {row['case']} {row['family']}: {truth or 'none'} -> {said or 'none'}")
    print(f"{'':20}" + "".join(f"{name:>15}" for name in figures))
    for name in next(iter(figures.values())):
        values = [each[name] for each in figures.values()]
        print(f"{name:20}" + "".join(f"{_shown(value):>15}" for value in values))
        if any(isinstance(value, dict) for value in values):
            print(f"{'':20}" + "".join(f"{_interval(value):>15}" for value in values))


def _shown(value: Any) -> str:
    number = value["value"] if isinstance(value, dict) else value
    return "-" if number is None else f"{number:.3g}"


def _interval(value: Any) -> str:
    known = isinstance(value, dict)
    return f"{value['low90']:.2g} to {value['high90']:.2g}" if known else ""


if __name__ == "__main__":
    sys.exit(main())
