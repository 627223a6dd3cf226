"""Chains of gaits: what a swimming stroke keeps from three links to six paddles, or a real snake.

The score of a body is its speed over the best that long searches find on it, computed first and
kept by the body's hash. Each seed runs each chain once, with the same trials for every control,
and learns the last body directly from nothing by CMA-ES, servo by servo in water and by the names
of the servos on a floor, with three step sizes, of which the best over all seeds is taken. A
sample is a control period of 20 ms on a target.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from experiments.gaits_chained.cases import CHAINS, FULL, QUICK, Size, job, key_of
from experiments.gaits_chained.summary import summary
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.chains_gait --seeds 100:102 --quick
  python -m experiments.chains_gait --seeds 10 --kept out/gaits.jsonl --json out/gaits.json"""


def run(
    chains: Sequence[str], seeds: range, real: str, size: Size, kept: Path | None, workers: int
) -> list[dict[str, Any]]:
    """Return every case, those that were kept before included, and keep what is finished."""
    done = {each["case"]: each for each in _read(kept)}
    names = dict.fromkeys(name for chain in chains for name in CHAINS[chain])
    jobs: list[tuple[Any, ...]] = [
        ("best", name, 0, real, size)
        for name in names
        if done.get(f"best {name}", {}).get("key") != key_of(name, real, size)
    ]
    jobs += [
        ("case", chain, seed, real, size)
        for seed in seeds
        for chain in chains
        if f"{chain} {seed}" not in done
    ]
    for found in _results(jobs, workers):
        done[found["case"]] = found
        print(f"  {found['case']}: {found.get('failed', 'done')}", file=sys.stderr, flush=True)
        if kept is not None:
            with kept.open("a") as out:
                out.write(json.dumps(found) + "\n")
    return list(done.values())


def _results(jobs: list[tuple[Any, ...]], workers: int) -> Iterator[dict[str, Any]]:
    if workers < 2 or len(jobs) < 2:
        yield from map(job, jobs)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for each in as_completed([pool.submit(job, what) for what in jobs]):
            yield each.result()


def _read(kept: Path | None) -> list[dict[str, Any]]:
    if kept is None or not kept.exists():
        return []
    return [json.loads(line) for line in kept.read_text().splitlines() if line.strip()]


def shown(figures: Mapping[str, Any], console: Console) -> None:
    """Print the figures of a chain as a table."""
    table = Table(title=f"chain {figures['chain']}: {figures['seeds']} seeds")
    table.add_column("figure")
    table.add_column("value")
    for name, value in figures.items():
        if name == "after":
            for trials, each in value.items():
                for label, figure in each.items():
                    table.add_row(f"after {trials} trials, {label}", _said(figure))
        elif name != "chain":
            table.add_row(name, _said(value))
    console.print(table)


def _said(value: Any) -> str:
    if isinstance(value, dict) and "iqm" in value:
        return f"{value['iqm']:.3g} [{value['low']:.3g}, {value['high']:.3g}]"
    if isinstance(value, dict):
        return ", ".join(f"{name} {each:.3g}" for name, each in value.items())
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _seeds(text: str) -> range:
    first, _, last = text.rpartition(":")
    return range(int(first or 0), int(last))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.chains_gait",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=_seeds, default=range(10), metavar="A:B")
    parser.add_argument("--chains", nargs="+", default=list(CHAINS), choices=list(CHAINS))
    parser.add_argument("--robots", default="", metavar="DIR", help="folder of real robots")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures")
    parser.add_argument("--kept", type=Path, metavar="FILE", help="finished cases, to resume from")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--quick", action="store_true", help="one seed, few trials")
    given = parser.parse_args(arguments)
    size, seeds = (QUICK, given.seeds[:1]) if given.quick else (FULL, given.seeds)
    chains = [each for each in given.chains if each != "urma" or given.robots]
    if len(chains) < len(given.chains):
        print("no --robots: the real snake is left out", file=sys.stderr)
    found = run(chains, seeds, given.robots, size, given.kept, given.workers)
    figures = [summary(found, chain) for chain in chains]
    console = Console()
    for each in figures:
        shown(each, console)
    if given.json is not None:
        write_whole(given.json, json.dumps(figures, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
