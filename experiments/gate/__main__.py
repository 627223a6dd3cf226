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
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from experiments.gate import report
from experiments.gate.asked import cost, in_model, policies, watched
from experiments.gate.controls import CONTROLS, DELTA
from experiments.gate.measures import Judged, summary
from experiments.gate.targets import drawn
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy.policy import Policy

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


def one(
    seed: int, tried: Sequence[Policy], here: Sequence[float], *, controls: bool, costs: bool
) -> JSON:
    """Return all that is asked of one case."""
    case = drawn(seed, tried)
    gate = watched(case)
    return {
        "gate": gate,
        "controls": {name: way(case) for name, way in CONTROLS.items()} if controls else {},
        "cost": cost(case, tried, gate, here[case.policy]) if costs else None,
    }


def found_in(
    seeds: range,
    *,
    plans: int,
    controls: int,
    costs: int,
    jobs: int,
    told: Callable[[str], None],
) -> JSON:
    """Return the figures of all cases, the first few with controls and costs."""
    began = time.perf_counter()
    first = BUILT if seeds[0] >= len(JUDGING) else 0
    tried = policies(range(first, first + plans))
    here = [in_model(each) for each in tried]
    told(f"{plans} policies planned in {time.perf_counter() - began:.0f} s")
    ask = {
        seed: partial(one, seed, tried, here, controls=at < controls, costs=at < costs)
        for at, seed in enumerate(seeds)
    }
    rows = []
    with ProcessPoolExecutor(max_workers=jobs) as pool:
        waiting = [pool.submit(each) for each in ask.values()]
        for number, each in enumerate(waiting, 1):
            rows.append(each.result())
            if number % 50 == 0 or number == len(waiting):
                told(f"{number} of {len(waiting)} cases, {time.perf_counter() - began:.0f} s")
    gates: list[Judged] = [row["gate"] for row in rows]
    compared = [row["controls"] for row in rows if row["controls"]]
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
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--quick", action="store_true", help="little of each: does it work at all")
    parser.add_argument("--plot", metavar="FILE.html", help="draw how true the probabilities are")
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked = parser.parse_args(arguments)
    count = 4 if asked.quick else max(1, asked.seeds)
    try:
        found = found_in(
            range(asked.seed, asked.seed + count),
            plans=1 if asked.quick else 3,
            controls=2 if asked.quick else asked.controls,
            costs=1 if asked.quick else asked.costs,
            jobs=1 if asked.quick else max(1, asked.jobs),
            told=lambda line: print(line, file=sys.stderr, flush=True),
        )
        if asked.plot:
            write_whole(Path(asked.plot), report.page(found))
    except MorphError as error:
        print(error, file=sys.stderr)
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
