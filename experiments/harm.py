"""Harm foreseen: policies carried to bodies drawn by chance, judged before they run, then run.

Each target is a body about one of the shelf with other lengths, masses, motors, noise and a push
of its own; some axes are mirrored, some hinges sprung, none has stops. Fifteen policies come to
it: of its kin as they are, by an old description, by maps learned of 20 or 60 transitions, by a
hop of the library, and six of these spoilt by a wrong sign, a shuffle or a wrong unit. The guard
sees at most 60 noisy transitions of the target. A policy is harmful if it then scores less than
holding still, from the same starts, and useful if it scores more by a tenth. Seeds 0 to 9 judge;
the weights of the guard's law were found on seeds from 100 on.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from rich.console import Console

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.kin.harms import harms
from experiments.kin.likeness import EACH
from experiments.kin.measures import CLEAR, Rows, accepted, area, calibration, lines_of, within
from morph.alignment.guard import SAFE, UNSAFE, WEIGHTS, odds
from morph.arrays import JSON, Array, Mask
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.harm --seeds 0:10 --resume --json out/harm.json
  python -m experiments.harm --quick"""

EDGES = (0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.01)
"""Bins of the probability in which the guard's calibration is shown."""


def report(lines: list[JSON]) -> JSON:
    """Return the figures of the study from the lines of its pairs."""
    told = [line for line in lines if "why" not in line]
    score, still = (np.array([line[name] for line in told]) for name in ("score", "still"))
    harmful, useful = score < still, score > still + CLEAR
    suspicions = _suspicions(told)
    probability = suspicions["guard"]
    return {
        "pairs": len(told),
        "targets": len({line["target"] for line in told}),
        "refused": len(lines) - len(told),
        "harmful": float(harmful.mean()),
        "useful": float(useful.mean()),
        "figures": {
            name: _figures(told, harmful, useful, each) for name, each in suspicions.items()
        },
        "calibration": calibration(harmful, probability, EDGES),
        "verdicts": _verdicts(told, harmful, useful),
        "sorts": _sorts(told, harmful, useful),
    }


def _suspicions(told: list[JSON]) -> dict[str, Array]:
    """Return how suspect each pair is to the guard and to every control, shape (pairs,) each."""
    looks = {
        name: np.array([odds(np.array(line[key])) for line in told])
        for name, key in (("guard", "features"), ("one body", "point"), ("shuffled", "shuffled"))
    }
    return {
        "guard": looks["guard"],
        "guard of the most probable body alone": looks["one body"],
        "guard of shuffled transitions": looks["shuffled"],
        "agreement of the map alone": -np.array([line["agreement"] for line in told]),
        "one step ahead alone": np.array([line["one step"] for line in told]),
        "always accept": np.zeros(len(told)),
    }


def _figures(told: list[JSON], harmful: Mask, useful: Mask, suspicion: Array) -> JSON:
    clear = harmful | useful
    groups = [line["target"] for line in told]

    def of(rows: Rows) -> float:
        kept = rows[clear[rows]]
        return area(harmful[kept], suspicion[kept])

    def took(rows: Rows) -> float:
        return accepted(harmful[rows], useful[rows], suspicion[rows])

    every = np.arange(len(told))
    return {
        "area": of(every),
        "area within": within(groups, of),
        "area, those between counted as harmless": area(harmful, suspicion),
        "useful accepted at 2 % harmful": took(every),
        "useful accepted within": within(groups, took),
    }


def _verdicts(told: list[JSON], harmful: Mask, useful: Mask) -> JSON:
    """Return how many pairs of each sort got each verdict."""
    named = np.array([_verdict(line) for line in told])
    return {
        verdict: {
            "pairs": int((named == verdict).sum()),
            "of the harmful": float((named[harmful] == verdict).mean()) if harmful.any() else 0.0,
            "of the useful": float((named[useful] == verdict).mean()) if useful.any() else 0.0,
        }
        for verdict in ("safe", "unsure", "unsafe")
    }


def _verdict(line: JSON) -> str:
    probability = odds(np.array(line["features"]))
    return "safe" if probability <= SAFE else "unsafe" if probability >= UNSAFE else "unsure"


def _sorts(told: list[JSON], harmful: Mask, useful: Mask) -> JSON:
    found = {}
    for name in dict.fromkeys(line["sort"] for line in told):
        held = np.array([line["sort"] == name for line in told])
        found[name] = {
            "pairs": int(held.sum()),
            "harmful": float(harmful[held].mean()),
            "useful": float(useful[held].mean()),
        }
    return found


def main(argv: list[str] | None = None) -> int:
    """Run the study, say what came of it, and write it."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.harm",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="0:10", metavar="A:B", help="which, or how many")
    parser.add_argument("--json", type=Path, help="write the figures here")
    add_engine_options(parser, out="out/harm")
    parser.add_argument("--quick", action="store_true", help="one target of one seed, for a test")
    asked, save = parse_and_save(parser, argv, module="experiments.harm")
    seeds = range(199, 200) if asked.quick else seeds_of(asked.seeds)
    each = 1 if asked.quick else EACH
    cases = [{"seed": seed, "number": number} for seed in seeds for number in range(each)]
    lines = lines_of(rows_of(cells_of(harms, cases), asked, name="harm"))
    found = report(lines)
    found["weights"] = list(WEIGHTS)
    if save:
        rivals = {name: each for name, each in found["figures"].items() if name != "guard"}
        figures = flat({**found, "figures": None}) | flat(found["figures"])
        save(figures=figures, controls=rivals, rows=found["calibration"], seeds=seeds)
    text = json.dumps(found, indent=1)
    if asked.json is not None:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(text + "\n")
    Console().print_json(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
