"""The main job on data of our own: conceal a piece of physics, diagnose it, open the seal.

Example: python -m experiments.demo --seed 3 --out out/demo
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from experiments.conceal import conceal, make_cases, open_seal
from experiments.conceal.__main__ import in_words as truth_in_words
from morph.errors import MorphError
from morph.files import sha256, write_whole

ROOT = Path(__file__).parent.parent


def main(arguments: list[str] | None = None) -> int:
    """Run the demonstration and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.demo",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, default=8, help="of what is concealed (default 8)")
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="where results go")
    asked = parser.parse_args(arguments)
    console = Console()
    try:
        case = _recorded(asked.seed, asked.out, console)
        report = _diagnosed(case, asked.out, console)
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; run `make demo` again to go on\n")
        return 130
    console.print()
    console.print((asked.out / "answer.txt").read_text().rstrip(), highlight=False, soft_wrap=True)
    # Only now, with the answer written, is the seal opened.
    console.print(
        f"\n[bold]Truth, unsealed only now[/]: {truth_in_words(open_seal(case))}",
        highlight=False,
        soft_wrap=True,
    )
    console.print(f"Open the report in a browser: {report.resolve()}", soft_wrap=True)
    console.print(
        "Next, a minute: a policy that fails on a body with sealed differences, and what\n"
        "becomes of it: .venv/bin/morph loop swing-up --robot cartpole --sealed 108 --out out/loop",
        highlight=False,
        soft_wrap=True,
    )
    return 0


def _recorded(seed: int, out: Path, console: Console) -> Path:
    """Return the folder of a case; it is made once."""
    case = make_cases(1, seed, clean=False)[0]
    folder = out / "case" / case.name
    if not (folder / "sealed" / "truth.sealed.json").exists():
        with console.status("Recording a robot with a hidden flaw (its truth is sealed) ..."):
            conceal(case, folder)
    said = f"1. Recorded: {folder}/recordings; the truth is sealed beside it"
    console.print(said, soft_wrap=True)
    return folder


def _diagnosed(case: Path, out: Path, console: Console) -> Path:
    """Return the report's path; a diagnosis that stands is not made again."""
    from morph.app.cli.diagnose import in_words
    from morph.app.report.files import write_diagnosis
    from morph.body.load import load as load_robot
    from morph.inference.diagnose import diagnose
    from morph.record.binding import load_binding
    from morph.record.load import load as load_recordings

    binding = case / "recordings" / "recording.toml"
    stamp, report = out / "stamp", out / "diagnosis" / "report.html"
    now = sha256(*sorted((ROOT / "morph").rglob("*.py")), binding)
    if stamp.exists() and stamp.read_text() == now and report.exists():
        console.print("2. Diagnosed before, and nothing has changed since.")
        return report
    robot = load_robot(str(load_binding(binding).robot))
    recordings = load_recordings(binding, robot=robot)
    columns = (TextColumn("   {task.description}"), BarColumn(), TimeElapsedColumn())
    began = time.monotonic()
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("diagnosing", total=1.0)
        found = diagnose(
            robot,
            recordings,
            progress=lambda what, share: progress.update(task, description=what, completed=share),
        )
    command = f"morph diagnose {robot.name} {binding} --out DIR --seed 0"
    found = replace(found, provenance={**found.provenance, "command": command})
    write_diagnosis(found, report.parent)
    write_whole(out / "answer.txt", in_words(found, report.parent))
    write_whole(stamp, now)
    seconds = time.monotonic() - began
    console.print(f"2. Diagnosed in {seconds:.0f} s; findings: {len(found.findings)}")
    return report


if __name__ == "__main__":
    sys.exit(main())
