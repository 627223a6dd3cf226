"""Memory and time that readers spend on malicious files (bombs) before they refuse them.

Each file is read in a forked process, after a good file of its kind has loaded the libraries,
whose memory is then not counted. Control: a good file of the same kind, read in the same way.
Example: .venv/bin/python -m experiments.bombs
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.bomb_files import BOMBS
from experiments.bomb_pieces import Bomb
from experiments.bomb_readers import READERS
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON

MAX_MEMORY = 3 * 2**30
"""Address space that a reader may add, bytes, so that a regression cannot exhaust the machine."""
MAX_SECONDS = 20
"""Processor seconds that a reader may take."""
GOAL_MB, GOAL_S = 300.0, 2.0
"""Memory, MB, and processor seconds that a bomb may cost."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of reading one file."""

    refused: str
    """Message of the refusal; empty if the file was read."""
    memory_mb: float
    """Growth of the peak resident memory of the process and its children, MB."""
    cpu_s: float
    """Processor time of the process and its children, s."""


def cost_of(bomb: Bomb, folder: Path) -> tuple[Cost, Cost]:
    """Return the costs of a bomb, written into a folder, and of a good file of its kind."""
    path = folder / bomb.name
    path.parent.mkdir(parents=True, exist_ok=True)
    # Made in a fork, too: heap that it leaves free here would hide growth of the reader.
    _forked(lambda: bomb.make(path) and None)
    with tempfile.TemporaryDirectory() as other:
        good = _good(path, Path(other))
        _refusal(bomb.reader, good)
        return _cost(bomb.reader, path, good), _cost(bomb.reader, good, good)


def _cost(reader: str, path: Path, good: Path) -> Cost:
    row = _forked(lambda: vars(_read_within_limits(reader, path, good)))
    return Cost(refused="", memory_mb=math.inf, cpu_s=math.inf) if row is None else Cost(**row)


def _forked(work: Callable[[], Any]) -> Any:
    """Return the result of a function called in a fork, as JSON data; None if the fork died."""
    read_end, write_end = os.pipe()
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        try:
            limit_memory()
            os.write(write_end, json.dumps(work()).encode())
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(0)
    os.close(write_end)
    with os.fdopen(read_end, "rb") as answer:
        content = answer.read()
    os.waitpid(child, 0)
    return json.loads(content) if content else None


def _read_within_limits(reader: str, path: Path, good: Path) -> Cost:
    """Read a file within limits of memory and time, and return the cost.

    Args:
        reader: Key of `READERS`.
        path: The file.
        good: A good file, read first: its child processes take what libraries take.
    """
    # A fork begins without children: those of earlier bombs would hide the growth of this one's.
    _refusal(reader, good)
    memory, spent = _used(resource.RUSAGE_SELF)
    children, their_spent = _used(resource.RUSAGE_CHILDREN)
    resource.setrlimit(resource.RLIMIT_CPU, (int(spent) + MAX_SECONDS,) * 2)
    refused = _refusal(reader, path)
    after, later = _used(resource.RUSAGE_SELF)
    their_after, their_later = _used(resource.RUSAGE_CHILDREN)
    return Cost(
        refused=refused,
        memory_mb=(after - memory + their_after - children) / 1e6,
        cpu_s=later - spent + their_later - their_spent,
    )


def _refusal(reader: str, path: Path) -> str:
    """Return the message with which a reader refuses a file; empty if it reads it."""
    from morph.alignment.errors import AlignError
    from morph.errors import MorphError

    try:
        READERS[reader](path)
    except (MorphError, AlignError) as error:
        return f"{error.what}; {error.fix}"
    return ""


def _used(who: int) -> tuple[float, float]:
    """Return the peak resident memory, bytes, and the processor time, s."""
    used = resource.getrusage(who)
    # Linux gives ru_maxrss in KiB.
    return used.ru_maxrss * 1024.0, used.ru_utime + used.ru_stime


def limit_memory() -> None:
    """Limit the address space of this process and its children to the present plus `MAX_MEMORY`."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + MAX_MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _good(path: Path, folder: Path) -> Path:
    """Write a good file of the kind of `path` into a folder, and return its path."""
    named = path.name in ("weights.safetensors", "card.toml", "state.npz")
    good = folder / (path.name if named else f"good{''.join(path.suffixes)}")
    if path.suffix == ".npz":
        np.savez(good, a=np.zeros(3))
    elif path.suffix in (".csv", ".gz"):
        good.write_text("time,a\n0,a\n1,2\n")
    elif path.suffix == ".parquet":
        import pyarrow
        from pyarrow import parquet

        parquet.write_table(pyarrow.table({"time": np.zeros(3), "q": [[1.0]] * 3}), good)
    elif path.suffix == ".h5":
        import h5py

        with h5py.File(good, "w") as file:
            file["time"] = np.zeros(3)
    elif path.suffix == ".xml":
        good.write_text(
            '<mujoco><worldbody><body><joint/><geom size="1"/></body></worldbody></mujoco>'
        )
    else:
        good.write_text("none")
    return good


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each bomb; return 1 if one costs too much or is not refused."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bombs",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="only bombs whose name holds TEXT"
    )
    parser.add_argument("--json", action="store_true", help="print a line of JSON for each bomb")
    options, save = parse_and_save(parser, arguments, module="experiments.bombs")
    bombs = [bomb for bomb in BOMBS if options.only in bomb.name]
    if not bombs:
        parser.error(f"no bomb's name holds {options.only!r}")
    if not options.json:
        print(f"{'file':22} {'bytes':>10} {'MB':>7} {'CPU s':>6}  refused", flush=True)
    rows = []
    for bomb in bombs:
        rows.append(row := measure(bomb))
        if options.json:
            print(json.dumps(row), flush=True)
        else:
            numbers = f"{row['bytes']:10} {row['memory_mb']:7.1f} {row['cpu_s']:6.2f}"
            print(f"{bomb.name:22} {numbers}  {row['refused'][:90] or 'read'}", flush=True)
    over = [row["name"] for row in rows if not row["holds"]]
    if not options.json:
        print(f"over {GOAL_MB:g} MB or {GOAL_S:g} s, or not refused: {', '.join(over) or 'none'}")
    if save:
        save(**headline(rows))
    return int(bool(over))


def measure(bomb: Bomb) -> JSON:
    """Return the row of one bomb: its cost, that of a good file, and whether it meets the goal."""
    with tempfile.TemporaryDirectory() as folder:
        cost, good = cost_of(bomb, Path(folder))
        size = (Path(folder) / bomb.name).stat().st_size
    cheap = cost.memory_mb <= GOAL_MB and cost.cpu_s <= GOAL_S
    return {
        "name": bomb.name,
        "reader": bomb.reader,
        "bytes": size,
        **vars(cost),
        "good_memory_mb": good.memory_mb,
        "good_cpu_s": good.cpu_s,
        "holds": cheap and bool(cost.refused) is not bomb.read,
    }


def headline(rows: Sequence[JSON]) -> JSON:
    """Return figures, controls and rows: the worst costs in all and by reader."""
    readers = {
        name: [row for row in rows if row["reader"] == name]
        for name in dict.fromkeys(row["reader"] for row in rows)
    }
    figures: JSON = {
        "bombs": len(rows),
        "over_or_not_refused": sum(not row["holds"] for row in rows),
        "goal_mb": GOAL_MB,
        "goal_s": GOAL_S,
    }
    for name, own in {"worst": rows, **readers}.items():
        figures[f"{name}_memory_mb"] = max(row["memory_mb"] for row in own)
        figures[f"{name}_cpu_s"] = max(row["cpu_s"] for row in own)
    controls = {
        f"a good file, {name}": {
            "memory_mb": max(row["good_memory_mb"] for row in own),
            "cpu_s": max(row["good_cpu_s"] for row in own),
        }
        for name, own in {"worst": rows, **readers}.items()
    }
    return {"figures": figures, "controls": controls, "rows": rows}


if __name__ == "__main__":
    sys.exit(main())
