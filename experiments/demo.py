"""The main job on data of our own: conceal a piece of physics, diagnose it, open the seal.

Example: python -m experiments.demo --seed 3 --out out/demo
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import time
from dataclasses import replace
from itertools import count
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from experiments.concealed.case import Case, draw_case
from experiments.concealed.errors import BenchmarkError
from experiments.concealed.generate import write_case
from experiments.concealed.seal import CASES, TRUTHS, Sealed, open_seal
from experiments.concealed.suites import SUITES
from morph.app.cli.view import open_browser
from morph.errors import MorphError
from morph.files import sha256, write_whole

ROOT = Path(__file__).parent.parent
SUITE = "development"
SMALL = ("pendulum", "cart_pole", "double_pendulum")
"""Mechanisms whose diagnosis takes less than a minute."""


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
    if asked.seed < 0:
        parser.error("--seed must not be negative")
    console = Console()
    try:
        case = _recorded(asked.seed, asked.out, console)
        report = _diagnosed(case, asked.out, console)
        # Only now, with the answer written, is the seal opened.
        truth = _in_words(open_seal(case))
        page = _drawn_page(case, report.parent, asked.out)
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; run `make demo` again to go on\n")
        return 130
    console.print()
    console.print((asked.out / "answer.txt").read_text().rstrip(), highlight=False, soft_wrap=True)
    console.print(f"\n[bold]Truth, unsealed only now[/]: {truth}", highlight=False, soft_wrap=True)
    console.print(f"Report: {report.resolve()}", soft_wrap=True)
    console.print(f"What moved, beside its simulation: {page.resolve()}", soft_wrap=True)
    if not open_browser(page.resolve().as_uri()):
        console.print("Open the two in a browser; there is none with a window here.")
    console.print(
        "Next, a minute: a policy that fails on a body with sealed differences, and what\n"
        "becomes of it: .venv/bin/morph loop swing-up --robot cartpole --sealed 108 --out out/loop",
        highlight=False,
        soft_wrap=True,
    )
    return 0


def _drawn_page(case: Path, diagnosis: Path, out: Path) -> Path:
    """Return the page of the recording beside the simulation, with the findings.

    Raises:
        MorphError: It cannot be made.
    """
    from morph.app.cli.view import run_view
    from morph.app.cli.view_arguments import ViewCommand

    page = out / "mismatch.html"
    if not page.exists() or page.stat().st_mtime < (diagnosis / "report.html").stat().st_mtime:
        recordings = sorted((case / "recordings").iterdir())
        run_view(
            ViewCommand(
                robots=(str(case / "robot.xml"),),
                recording=tuple(str(each) for each in recordings),
                diagnosis=str(diagnosis),
                html=str(page),
                first="mismatch",
                quiet=True,
            )
        )
    return page


def _recorded(seed: int, out: Path, console: Console) -> Path:
    """Return the folder of a case; it is made once."""
    folder = out / "case"
    made = sorted((folder / CASES).glob(f"{SUITE}_{seed}_*/case.json"))
    if made:
        case = made[0].parent
    else:
        with console.status("Recording a robot with a hidden flaw (its truth is sealed) ..."):
            case = write_case(_drawn(seed), folder)
    said = f"1. Recorded: {case}/recordings; the truth is sealed in {folder / TRUTHS}"
    console.print(said, soft_wrap=True)
    return case


def _drawn(seed: int) -> Case:
    """Return the first case of a seed with one effect of the library and a small mechanism."""
    numbers = (number for number in count() if SUITES[SUITE].count(seed, number) == 1)
    cases = (draw_case(SUITE, seed, number) for number in numbers)
    # A law that does nothing without another is left out together with it.
    return next(
        case for case in cases if len(case.truth.effects) == 1 and case.mechanism.family in SMALL
    )


def _in_words(sealed: Sealed) -> str:
    """Return the truth of a case in one sentence."""
    effects = []
    for effect in sealed.about["effects"]:
        where, figures = effect["where"], effect["figures"]
        sizes = ", ".join(f"{name} = {figures[name]:.3g}" for name in effect["scored"])
        effects.append(
            f"{effect['effect']} at {where['kind']} {where['name']} ({sizes}), "
            f"{effect['effect_to_noise']:.1f} times the noise"
        )
    return f"{sealed.about['family']}: {'; '.join(effects)}"


def _vary(case: Path) -> dict[str, float]:
    """Return by how much a case says that its description may be wrong."""
    path = case / "case.json"
    try:
        return {
            str(kind): float(share) for kind, share in json.loads(path.read_text())["vary"].items()
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise BenchmarkError(
            f"the case cannot be read: {error}", where=str(path), fix="remove its folder"
        ) from error


def _diagnosed(case: Path, out: Path, console: Console) -> Path:
    """Return the report's path; a diagnosis that stands is not made again."""
    from morph.app.cli.diagnose import in_words
    from morph.app.report.files import write_diagnosis
    from morph.body.load import load as load_robot
    from morph.inference.diagnose import diagnose
    from morph.record.load import load_recordings

    stamp, report = out / "stamp", out / "diagnosis" / "report.html"
    description, recorded = case / "robot.xml", case / "recordings"
    given = sorted(path for path in case.rglob("*") if path.is_file())
    now = sha256(*sorted((ROOT / "morph").rglob("*.py")), *given)
    if stamp.exists() and stamp.read_text() == now and report.exists():
        console.print("2. Diagnosed before, and nothing has changed since.")
        return report
    vary = _vary(case)
    robot = load_robot(str(description))
    recordings = load_recordings(recorded, robot=robot)
    columns = (TextColumn("   {task.description}"), BarColumn(), TimeElapsedColumn())
    began = time.monotonic()
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("diagnosing", total=1.0)
        found = diagnose(
            robot,
            recordings,
            vary=vary,
            progress=lambda what, share: progress.update(task, description=what, completed=share),
        )
    told = [f"{kind}={share:g}" for kind, share in vary.items()]
    said = ["morph", "diagnose", str(description), str(recorded), "--out", "DIR", "--vary", *told]
    command = shlex.join([*said, "--seed", "0"])
    found = replace(found, provenance={**found.provenance, "command": command})
    write_diagnosis(found, report.parent)
    write_whole(out / "answer.txt", in_words(found, report.parent))
    write_whole(stamp, now)
    seconds = time.monotonic() - began
    console.print(f"2. Diagnosed in {seconds:.0f} s; findings: {len(found.findings)}")
    return report


if __name__ == "__main__":
    sys.exit(main())
