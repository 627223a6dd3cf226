"""Benchmark of the study engine: overhead, scaling, and robustness to killed workers.

`overhead`: time a cell beside that of its function. `speedup`: two workers against one, on cells
that compute; needs a quiet machine. `curve`: 1 to 64 workers on cells that sleep, in place of
machines that we do not have; the processor time of the study's own process per cell limits how
many workers it can feed. `kills`: workers SIGKILLed at random moments; rows must all be right.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from experiments.dask_cluster import start_cluster, worker_pids
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.study.cell import Cell, cells_of
from morph.study.engine import EngineOptions
from morph.study.progress import Progress
from morph.study.run import run
from morph.study.store import Result

CURVE = (1, 2, 4, 8, 16, 32, 64)
"""Numbers of workers of the curve."""


def nothing(number: int) -> JSON:
    """Return at once."""
    return {"number": number}


def compute(number: int, rounds: int) -> JSON:
    """Return a number that takes one core a while: a linear congruential generator's state."""
    state = number
    for _ in range(rounds):
        state = (6364136223846793005 * state + 1442695040888963407) % 2**64
    return {"state": state}


def sleep(number: int, seconds: float) -> JSON:
    """Sleep."""
    time.sleep(seconds)
    return {"number": number}


class Clock:
    """Times at which the cells of a run ended, on the clock of `time.perf_counter`, s."""

    def __init__(self) -> None:
        self.ends: list[float] = []

    def __call__(self, progress: Progress, result: Result | None) -> None:
        """Record the time of a cell's end."""
        if result is not None:
            self.ends.append(time.perf_counter())


def time_run(cells: Sequence[Cell], engine: EngineOptions, *, skip: int) -> JSON:
    """Return the cells, the wall seconds and the own processor seconds a cell of a run.

    Args:
        cells: Cells to run.
        engine: Engine that runs them.
        skip: Cells that end before the clock starts, so that every worker has started.
    """
    clock = Clock()
    with tempfile.TemporaryDirectory() as folder:
        cpu = time.process_time()
        run(cells, folder=Path(folder), options=engine, watch=clock)
        cpu = time.process_time() - cpu
    ended = clock.ends[skip:]
    wall = ended[-1] - clock.ends[skip - 1]
    return {"cells": len(ended), "seconds": wall, "own_cpu_a_cell": cpu / len(cells)}


def overhead(count: int) -> JSON:
    """Return the time of a cell that does nothing, its result file included, on one worker."""
    cells = cells_of(nothing, [{"number": number} for number in range(count + 10)])
    took = time_run(cells, EngineOptions(workers=1), skip=10)
    return {"ms_a_cell": 1e3 * took["seconds"] / took["cells"], **took}


def speedup(count: int, rounds: int) -> JSON:
    """Return the wall time of one worker over that of two, on cells that compute."""
    seconds = {}
    for workers in (1, 2):
        cases = [{"number": number, "rounds": rounds} for number in range(count + 2)]
        took = time_run(cells_of(compute, cases), EngineOptions(workers=workers), skip=2)
        seconds[workers] = took["seconds"]
    return {"seconds": seconds, "times": seconds[1] / seconds[2], "load": os.getloadavg()[0]}


def curve(each: float, rounds: int) -> list[JSON]:
    """Return cells a second by the number of workers, absolute and over the ideal rate.

    Args:
        each: Seconds that a cell sleeps.
        rounds: Cells a worker, after the first.
    """
    rows = []
    for workers in CURVE:
        count = workers * (rounds + 1)
        cells = cells_of(sleep, [{"number": n, "seconds": each} for n in range(count)])
        took = time_run(cells, EngineOptions(workers=workers), skip=workers)
        rate = took["cells"] / took["seconds"]
        rows.append(
            {
                "workers": workers,
                "cells_a_second": rate,
                "of_ideal": rate * each / workers,
                "own_cpu_a_cell": took["own_cpu_a_cell"],
            }
        )
    return rows


def limit(rows: Sequence[JSON], workers: int) -> JSON:
    """Return the shortest cell, s, that keeps a number of workers busy, by extrapolation.

    The study's process submits cells and writes results one after the other, so that its
    processor time a cell bounds the rate of any number of workers.

    Args:
        rows: As `curve` returns them.
        workers: Number of workers to extrapolate to.
    """
    cost = max(row["own_cpu_a_cell"] for row in rows)
    return {"workers": workers, "own_cpu_a_cell": cost, "shortest_cell": workers * cost}


def kills(engine: str, times: int, count: int, each: float, seed: int) -> JSON:
    """Return the rows, statuses and deaths of a run whose workers are killed.

    Args:
        engine: `local` or `dask`.
        times: Workers to kill.
        count: Cells.
        each: Seconds that a cell sleeps.
        seed: Random seed of the moments and of the victims.
    """
    cells = cells_of(sleep, [{"number": number, "seconds": each} for number in range(count)])
    deaths = [0]

    def watch(progress: Progress, result: Result | None) -> None:
        deaths[0] = progress.worker_deaths

    with two_workers(engine) as (options, pids), tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        with kill_at_random(pids, times=times, seed=seed) as killed:
            results = run(cells, folder=Path(folder), options=options, watch=watch)
        seconds = time.perf_counter() - start
    right = sum(result.row == {"number": number} for number, result in enumerate(results))
    return {
        "engine": engine,
        "killed": len(killed),
        "worker_deaths": deaths[0],
        "cells": count,
        "right_rows": right,
        "statuses": dict(Counter(result.status for result in results)),
        "errors": [result.error for result in results if result.error],
        "seconds": seconds,
        "seconds_without": count * each / 2,
    }


@contextmanager
def kill_at_random(pids: Callable[[], list[int]], *, times: int, seed: int) -> Iterator[list[int]]:
    """SIGKILL one of the processes every 0.1 to 1.5 s, and yield the list of those killed."""
    killed: list[int] = []
    end = threading.Event()

    def kill() -> None:
        rng = random.Random(seed)
        while len(killed) < times and not end.wait(rng.uniform(0.1, 1.5)):
            running = pids()
            if running:
                killed.append(rng.choice(running))
                os.kill(killed[-1], signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        yield killed
    finally:
        end.set()
        thread.join()


@contextmanager
def two_workers(engine: str) -> Iterator[tuple[EngineOptions, Callable[[], list[int]]]]:
    """Yield the options of an engine with two workers, and a function that returns their pids."""
    if engine == "local":
        yield EngineOptions(workers=2), local_pids
        return
    with start_cluster(workers=2) as scheduler:
        address = scheduler.address
        yield EngineOptions(engine="dask", scheduler=address), lambda: worker_pids(address)


def local_pids() -> list[int]:
    """Return the processes of the local engine's workers."""
    import psutil

    children = psutil.Process().children()
    return [child.pid for child in children if "popen_loky_posix" in " ".join(child.cmdline())]


WHAT = ("overhead", "speedup", "curve", "kills")
"""Measurements; the curve includes the limit for 1000 workers, extrapolated."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print JSON, and return the exit status: 0, or 1 if a row was lost."""
    parser = _parser()
    options, save = parse_and_save(parser, arguments, module="experiments.bench_study")
    if unknown := [each for each in options.what if each not in WHAT]:
        parser.error(f"unknown: {', '.join(unknown)}; choose from {', '.join(WHAT)}")
    if save and "kills" not in options.what:
        parser.error("a result needs the controls of `kills`: measure it too")
    report: JSON = {"cores": os.cpu_count()}
    if "overhead" in options.what:
        report["overhead"] = overhead(options.cells)
    if "speedup" in options.what:
        report["speedup"] = speedup(20, options.rounds)
    if "curve" in options.what:
        report["curve"] = curve(10 * options.each, 4)
        report["limit"] = limit(report["curve"], 1000)
    if "kills" in options.what:
        report["kills"] = [
            kills(engine, options.kills, options.cells, options.each, options.seed)
            for engine in options.engines
        ]
    print(json.dumps(report, indent=1))
    if save:
        killed = {one["engine"]: one for one in report.get("kills", [])}
        controls = {name: {"seconds": one["seconds_without"]} for name, one in killed.items()}
        save(figures=flat(report | killed), controls=controls, rows=report.get("curve", []))
    lost = any(one["right_rows"] < one["cells"] for one in report.get("kills", []))
    return 1 if lost else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m experiments.bench_study", description=__doc__)
    parser.add_argument(
        "what",
        nargs="*",
        default=["overhead", "curve", "kills"],
        help=f"measurements: {', '.join(WHAT)}",
    )
    parser.add_argument("--cells", type=int, default=500, help="cells of overhead and of kills")
    parser.add_argument("--each", type=float, default=0.1, help="seconds that a cell sleeps")
    parser.add_argument(
        "--rounds", type=int, default=3_000_000, help="rounds of a cell that computes"
    )
    parser.add_argument("--kills", type=int, default=20, help="workers to kill")
    parser.add_argument("--seed", type=int, default=1, help="random seed of the kills")
    parser.add_argument(
        "--engines", nargs="*", default=["dask", "local"], help="engines whose workers are killed"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
