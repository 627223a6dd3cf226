"""Is the model good enough: how often the gate is right, at any moment, and how sure it is.

Simulated cart-poles with known truth: as described, a little off, ten percent off, three times
the friction, far off, or with an effect of the library concealed. One noisy 3 s run of a policy
planned on the model is all that the gate sees. Cases 0 to 999 judge; it was built on others.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from functools import cache
from pathlib import Path

from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.gate import report
from experiments.gate.asked import cost, in_model, policies, watched
from experiments.gate.controls import CONTROLS, DELTA
from experiments.gate.measures import as_row, of_row, summary
from experiments.gate.targets import drawn
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy.policy import Policy
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.gate
  python -m experiments.gate --seed 1000 --seeds 100 --costs 20 --json > out/gate.json
  python -m experiments.gate --quick"""

JUDGING = range(1000)
"""Cases that judge, with policies planned from seeds from 0 on."""

BUILT = 100
"""First seed of the policies of other cases."""

CALIBRATED = 500
"""First cases of which calibration and accuracy are told as well: study 4 of the thesis' list."""


@cache
def planned(first: int, plans: int) -> tuple[tuple[Policy, ...], tuple[float, ...]]:
    """Return policies planned from seeds, and what each costs in the model; once a process."""
    tried = policies(range(first, first + plans))
    return tuple(tried), tuple(in_model(each) for each in tried)


def one(seed: int, first: int, plans: int, controls: bool, costs: bool) -> JSON:
    """Return all that is asked of one case.

    Args:
        seed: Of the case.
        first: First seed of the policies.
        plans: How many policies there are.
        controls: Whether the controls answer too.
        costs: Whether costs are foretold.
    """
    tried, here = planned(first, plans)
    case = drawn(seed, tried)
    gate = watched(case)
    others = {name: as_row(way(case)) for name, way in CONTROLS.items()} if controls else {}
    return {
        "gate": as_row(gate),
        "controls": others,
        "cost": cost(case, tried, gate, here[case.policy]) if costs else None,
    }


def found_in(
    seeds: range, asked: argparse.Namespace, *, plans: int, controls: int, costs: int
) -> JSON:
    """Return the figures of all cases, the first few with controls and costs."""
    began = time.perf_counter()
    first = BUILT if seeds[0] >= len(JUDGING) else 0
    cases = [
        {"seed": seed, "first": first, "plans": plans}
        | {"controls": at < controls, "costs": at < costs}
        for at, seed in enumerate(seeds)
    ]
    rows = rows_of(cells_of(one, cases), asked, name="gate")
    gates = [of_row(row["gate"]) for row in rows]
    compared = [
        {name: of_row(row["controls"][name]) for name in CONTROLS}
        for row in rows
        if row["controls"]
    ]
    foretold = [row["cost"] for row in rows if row["cost"]]
    found: JSON = {
        "schema": "morph.gate/1",
        "seeds": [seeds[0], seeds[-1]],
        "delta": DELTA,
        "gate": summary(gates, DELTA),
        "first": summary(gates[:CALIBRATED], DELTA),
    }
    if compared:
        names = {"the gate itself": gates[: len(compared)]} | {
            name: [each[name] for each in compared] for name in CONTROLS
        }
        found["controls"] = {name: summary(cases, DELTA) for name, cases in names.items()}
    if foretold:
        found["cost"] = report.costs(foretold) | {"rows": foretold}
    return found | {"seconds": time.perf_counter() - began}


def headline(found: JSON) -> JSON:
    """Return what a result file holds: wrong answers at any moment, power, and calibration."""
    gate = found["gate"]
    figures = flat({name: of for name, of in gate.items() if isinstance(of, (int, float))})
    for name in (
        "false_accepts",
        "false_rejects",
        "accepted",
        "good_withheld",
        "rejected",
        "bad_not_rejected",
    ):
        figures |= flat(gate[name], name)
    off = [row for row in gate["families"] if row["family"].startswith("ten ")]
    figures["ten_percent_off"] = sum(row["cases"] for row in off if not row["truly_good"])
    figures["ten_percent_noticed"] = sum(row["right"] for row in off if not row["truly_good"])
    figures |= flat(found.get("cost", {}), "cost")
    kept = ("accepted", "rejected", "false_accepts", "calibration")
    controls = {
        name: flat({key: of[key] for key in kept}) for name, of in found.get("controls", {}).items()
    }
    controls["always accept"] = flat(gate["always_accept"])
    return {"figures": figures, "controls": controls, "rows": gate["families"]}


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.gate",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, default=0, help="the first case")
    parser.add_argument("--seeds", type=int, default=1000, help="how many cases")
    parser.add_argument("--controls", type=int, default=100, help="of these with controls")
    parser.add_argument("--costs", type=int, default=60, help="of these with foretold costs")
    add_engine_options(parser, out="out/gate")
    parser.add_argument("--quick", action="store_true", help="little of each: does it work at all")
    parser.add_argument("--plot", metavar="FILE.html", help="draw how true the probabilities are")
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.gate.__main__")
    count = 4 if asked.quick else max(1, asked.seeds)
    try:
        found = found_in(
            range(asked.seed, asked.seed + count),
            asked,
            plans=1 if asked.quick else 3,
            controls=2 if asked.quick else asked.controls,
            costs=1 if asked.quick else asked.costs,
        )
        if save:
            save(**headline(found), seeds=[asked.seed, asked.seed + count - 1])
        if asked.plot:
            write_whole(Path(asked.plot), report.page(found))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(found, indent=1))
    else:
        report.told(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
