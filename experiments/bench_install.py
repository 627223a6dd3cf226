"""What an installation takes, and whether every command starts from it, away from the repository.

For each Python that is found, the wheel is built from this checkout and installed in a new
environment, without extras and with all of them; an empty environment is the control. Sizes are
those of all files, with the bytecode that pip makes. `--help` of every command is timed in seconds
of the processor, and a few lines of each extra are run.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.extras import DISTRIBUTION

EXAMPLE = """example:
  python -m experiments.bench_install --pythons python3.11 --save-as out/install.json"""

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("python3.11", "python3.12", "python3.13")

CORE = (
    "list robots",
    "inspect so101",
    "convert pendulum --to urdf --out converted",
    "simulate pendulum --seconds 4 --start hinge=1 --out run.csv --quiet",
    "compare pendulum run.csv",
    "diagnose pendulum run.csv --out report --quiet",
    "excite pendulum --for-everything --out plan --quiet",
)
ALL = (
    "learn balance --robot cartpole --out learned --quiet",
    "align cartpole rider_rigid_driven --quiet",
    "transfer --from learned --chain cartpole rider_rigid_driven --out carried --quiet",
    "loop balance --robot cartpole --policy learned/policy --change weight:pole=1.2"
    " --out looped --quiet",
    "simulate pendulum --seconds 1 --video run.mp4 --quiet",
    "view pendulum --html view.html",
    "print quadruped_printed --printer mk4 --material pla --out package --quiet",
    "weigh package P-01=20",
)
"""What needs an extra; lines run one after the other in one folder."""
NAMES = (
    *("align", "compare", "convert", "diagnose", "excite", "inspect", "learn", "list", "loop"),
    *("print", "simulate", "study", "transfer", "view", "weigh"),
)


def megabytes(folder: Path) -> float:
    """Return the size of all files in a folder, MB of 10^6 bytes."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if not path.is_dir()) / 1e6


def processor_seconds(command: list[str], folder: Path, home: Path) -> tuple[float, str]:
    """Return the seconds of the processor that a program took, and its message if it failed."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    before = os.times()
    done = subprocess.run(
        command, cwd=folder, env={**environment, "HOME": str(home)}, capture_output=True, text=True
    )
    after = os.times()
    used = sum(after[2:4]) - sum(before[2:4])
    return used, "" if done.returncode == 0 else (done.stderr or done.stdout)[-400:]


def installed(python: str, wheel: Path | None, extra: str, folder: Path) -> Path:
    """Return a new environment with the wheel and one of its extras; without a wheel, an empty one.

    Raises:
        RuntimeError: pip cannot install it.
    """
    subprocess.run([python, "-m", "venv", str(folder)], check=True)
    if wheel is not None:
        pip = [str(folder / "bin" / "python"), "-m", "pip", "install", "--quiet"]
        what = f"{wheel}[{extra}]" if extra else str(wheel)
        done = subprocess.run([*pip, what], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stderr[-1000:])
    return folder


def measure(python: str, wheel: Path, folder: Path) -> list[JSON]:
    """Return one row for an empty environment, one without extras and one with all of them."""
    rows: list[JSON] = []
    for name, extra, lines in (
        ("empty", "", ()),
        ("core", "", CORE),
        ("all", "all", (*CORE, *ALL)),
    ):
        place = folder / f"{python}_{name}"
        home = place / "home"
        installed(python, None if name == "empty" else wheel, extra, place)
        row: JSON = {"python": python, "installed": name, "megabytes": megabytes(place)}
        home.mkdir()
        morph = str(place / "bin" / "morph")
        failed: dict[str, str] = {}
        for line in lines:
            _, error = processor_seconds([morph, *line.split()], home, home)
            failed |= {line: error} if error else {}
        if lines:
            helps = {each: processor_seconds([morph, each, "--help"], home, home) for each in NAMES}
            failed |= {f"{each} --help": error for each, (_, error) in helps.items() if error}
            row["help_processor_s"] = processor_seconds([morph, "--help"], home, home)[0]
            row["start_processor_s"] = max(used for used, _ in helps.values())
        rows.append({**row, "ran": len(lines), "failed": failed})
        print(json.dumps(rows[-1]), flush=True)
        shutil.rmtree(place)
    return rows


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_install",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--pythons", nargs="+", default=list(PYTHONS), help="those on the path")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_install")
    # A shim of pyenv is on the path for versions that are not active, and only says so.
    there = [[each, "-c", "pass"] for each in asked.pythons if shutil.which(each)]
    pythons = [
        words[0] for words in there if not subprocess.run(words, capture_output=True).returncode
    ]
    if not pythons:
        print(f"error: none of {', '.join(asked.pythons)} is on the path", file=sys.stderr)
        return 2
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", name, "."]
        copy = folder / "source"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(copy)], check=True)
        subprocess.run(build, cwd=copy, check=True, capture_output=True)
        (wheel,) = folder.glob(f"{DISTRIBUTION.replace('-', '_')}-*.whl")
        for python in pythons:
            rows += measure(python, wheel, folder)
    if save:
        kinds = {
            name: [row for row in rows if row["installed"] == name]
            for name in ("empty", "core", "all")
        }
        figures = {
            "pythons": len(pythons),
            "failed": sum(len(row["failed"]) for row in rows),
            **{f"{name}_gb": max(row["megabytes"] for row in kinds[name]) / 1e3 for name in kinds},
            # By whether the index has torch's CPU wheel for that Python.
            "all_least_gb": min(row["megabytes"] for row in kinds["all"]) / 1e3,
            "help_processor_s": max(row["help_processor_s"] for row in kinds["core"]),
            "start_processor_s": max(row["start_processor_s"] for row in kinds["core"]),
        }
        save(figures=figures, controls={"empty": {"gb": figures.pop("empty_gb")}}, rows=rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
