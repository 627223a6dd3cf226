"""What commands cost: `morph inspect` of 52 meshes, `morph compare` of 29 joints, `morph diagnose`.

Seconds on the clock and of the processor, and the most memory, of the whole process: its start,
its imports and its report are in them. The controls are processes that do nothing but start
Python, and but import MuJoCo: what no command of this kind can go below.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings, need_robots
from morph.arrays import JSON
from morph.errors import MorphError

EXAMPLE = """example:
  python -m experiments.bench_commands --only inspect --save-as out/inspect.json"""

HUMANOID = "erd_simple_humanoid/urdf/simple_humanoid.urdf"
MINUTE = "minute.parquet"
"""A simulated minute of its 29 joints."""
POPPY = "poppy_humanoid/robots/Poppy_Humanoid.URDF"
RIG = "dfki_double_pendulum"
BINDING = "experiments/bindings/dfki_c0.toml"
CALL = "from morph.app.cli.main import entry; entry()"
"""The command `morph` of this very Python."""
LAUNCH = """
import os, sys, time
nothing = os.open(os.devnull, os.O_WRONLY)
began = time.perf_counter()
child = os.posix_spawn(
    sys.argv[1], sys.argv[1:], os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, nothing, 1)]
)
_, status, used = os.wait4(child, 0)
seconds = time.perf_counter() - began
processor_s = used.ru_utime + used.ru_stime
# Linux counts kB of 1024 bytes.
memory_mb = used.ru_maxrss * 1024e-6
print(f'{{"seconds": {seconds}, "processor_s": {processor_s}, "memory_mb": {memory_mb}}}')
sys.exit(os.waitstatus_to_exitcode(status) != 0)
"""
"""A small process that starts the program: Linux counts the memory of whoever starts a process as
that process's own."""
PARTS = ("inspect", "compare", "diagnose")
FLOORS = {"python started": "pass", "mujoco imported": "import mujoco"}
"""Controls: programs that a command cannot be cheaper than."""
MEASURED = ("seconds", "processor_s", "memory_mb")


def words_of(part: str, out: Path) -> list[str]:
    """Return the words of a command.

    Raises:
        DataMissing: What it reads is not there.
    """
    if part == "inspect":
        return ["inspect", str(need_robots("poppy_humanoid") / POPPY), "--json"]
    if part == "compare":
        robot, run = str(need_robots("erd_simple_humanoid") / HUMANOID), out.parent / MINUTE
        if not run.exists():
            simulate = ["simulate", robot, "--seconds", "60", "--out", str(run), "--quiet"]
            measured(CALL, *simulate)
        return ["compare", robot, str(run), "--quiet"]
    root = need_recordings(RIG) / RIG
    return ["diagnose", "double_pendulum", BINDING, "--root", str(root), "--out", str(out)]


def measured(code: str, *words: str) -> JSON:
    """Return what a Python program takes: seconds on the clock and of the processor, and MB.

    Args:
        code: The program.
        words: Its arguments.

    Raises:
        RuntimeError: The program failed.
    """
    ran = subprocess.run(
        [sys.executable, "-S", "-c", LAUNCH, sys.executable, "-c", code, *words],
        capture_output=True,
        check=False,
    )
    if ran.returncode:
        raise RuntimeError(ran.stderr.decode())
    return dict(json.loads(ran.stdout))


def least(runs: Sequence[JSON]) -> JSON:
    """Return the least of each measured quantity over repeated runs."""
    return {key: min(run[key] for run in runs) for key in MEASURED}


def measure_floors(repeats: int) -> tuple[list[JSON], dict[str, JSON]]:
    """Return the rows of the controls, and the least of each."""
    rows = [
        {"command": name, **measured(code)} for name, code in FLOORS.items() for _ in range(repeats)
    ]
    return rows, {name: least([row for row in rows if row["command"] == name]) for name in FLOORS}


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_commands",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", choices=PARTS, nargs="+", default=list(PARTS))
    parser.add_argument("--repeats", type=int, default=2, help="the least of so many is told")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_commands")
    rows, controls = measure_floors(asked.repeats)
    for row in rows:
        print(json.dumps(row), flush=True)
    figures: JSON = {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            for part in asked.only:
                for at in range(asked.repeats):
                    found = measured(CALL, *words_of(part, Path(folder) / f"{part}{at}"))
                    rows.append({"command": part, **found})
                    print(json.dumps(rows[-1]), flush=True)
                mine = [row for row in rows if row["command"] == part]
                figures |= {f"{part}_{key}": value for key, value in least(mine).items()}
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if save:
        save(figures=figures, controls=controls, rows=rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
