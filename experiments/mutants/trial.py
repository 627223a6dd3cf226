"""Runs of the tests on a copy of the repository, with or without a mutant."""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from experiments.mutants.mutant import Area, Mutant, MutantError, load_areas
from morph.arrays import JSON

Outcome = Literal["killed", "hangs", "survived"]

EXCLUDED = (".git", ".venv*", "out", "build", "dist", "__pycache__", ".*_cache")
"""Names that are not copied."""
TIMEOUT_FACTOR, MIN_TIMEOUT_S = 8.0, 120.0
"""Timeout of the tests as a multiple of their time without a mutant, and its lower bound, s: on a
slow machine no mutant is killed by the timeout alone."""
BASELINE_TIMEOUT_S = 3600.0
"""Timeout of the tests without a mutant, s."""


@dataclass(frozen=True, kw_only=True)
class PytestRun:
    """One run of pytest."""

    status: int | None
    """Its exit status; None if it was killed at its timeout."""
    failed: str
    """The first test that failed; empty for none."""
    wall_s: float
    """Wall time, s."""
    cpu_s: float
    """Processor time of pytest and its children, s."""
    tail: str
    """The last 2000 characters of its output."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """Outcome of one mutant."""

    area: str
    file: str
    breaks: str
    outcome: Outcome
    """`hangs` counts as killed: by the timeout."""
    by: str
    """First test that failed; empty for none."""
    wall_s: float
    cpu_s: float


def try_area(*, root: str, lists: str, area: str, timeout_s: float | None) -> JSON:
    """Return the outcome of every mutant of an area; the function of the study's cells.

    The repository is copied, and only the copy is edited.

    Args:
        root: The repository.
        lists: Folder of the lists of mutants.
        area: Name of the area.
        timeout_s: Timeout of the tests, s; None for a multiple of their time without a mutant.

    Raises:
        MutantError: Tests fail without a mutant, a mutant does not apply, or pytest cannot run.
    """
    (mutants_of,) = load_areas(Path(lists), area)
    with tempfile.TemporaryDirectory(prefix="morph-mutants-") as folder:
        copy = copy_tree(Path(root), Path(folder))
        baseline = run_baseline(mutants_of, copy, Path(root))
        timeout = timeout_s or max(MIN_TIMEOUT_S, TIMEOUT_FACTOR * baseline.wall_s)
        if not timeout >= 2.0 * baseline.cpu_s:
            raise MutantError(
                f"a timeout of {timeout:g} s would kill them all: without a mutant its tests take "
                f"{baseline.cpu_s:.1f} s of processor",
                where=f"area {area}",
                fix="leave out --timeout, or give several times as much",
            )
        rows = [try_mutant(mutant, copy, Path(root), timeout) for mutant in mutants_of.mutants]
    return {
        "area": area,
        "baseline": {"wall_s": baseline.wall_s, "cpu_s": baseline.cpu_s},
        "mutants": [asdict(row) for row in rows],
    }


def copy_tree(root: Path, into: Path) -> Path:
    """Copy a repository, but for `EXCLUDED`, and return the path of the copy.

    Args:
        root: The repository; it is never edited.
        into: An empty folder.
    """
    copy = into / root.name
    shutil.copytree(root, copy, ignore=shutil.ignore_patterns(*EXCLUDED), symlinks=True)
    return copy


def run_baseline(area: Area, copy: Path, root: Path) -> PytestRun:
    """Return the run of an area's tests without a mutant.

    Raises:
        MutantError: A test fails, so that it could tell nothing of a mutant.
    """
    run = run_tests(copy, root, area.tests, BASELINE_TIMEOUT_S)
    if run.status != 0:
        raise MutantError(
            f"its tests fail without a mutant:\n{run.tail}",
            where=f"area {area.name}",
            fix="make these tests pass first",
        )
    return run


def run_tests(copy: Path, root: Path, tests: Sequence[str], timeout_s: float) -> PytestRun:
    """Return the run of tests in a copy, up to the first that fails.

    Args:
        copy: The copy; its packages are imported before those that are installed.
        root: The repository, for `../shared` with recordings and robots beside it.
        tests: Arguments for pytest.
        timeout_s: Timeout, s.
    """
    environment = {**os.environ, "PYTHONPATH": str(copy), "OMP_NUM_THREADS": "1"}
    for name, folder in (("MORPH_RECORDINGS", "recordings"), ("MORPH_ROBOTS", "robots")):
        environment.setdefault(name, str(root.parent / "shared" / folder))
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    start, cpu_before = time.monotonic(), _children_cpu()
    with subprocess.Popen(
        command,
        cwd=copy,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            output, _ = process.communicate(timeout=timeout_s)
            status: int | None = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            output, status = process.communicate()[0], None
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
    return PytestRun(
        status=status,
        failed=failed[1] if failed else "",
        wall_s=time.monotonic() - start,
        cpu_s=_children_cpu() - cpu_before,
        tail=output[-2000:],
    )


def try_mutant(mutant: Mutant, copy: Path, root: Path, timeout_s: float) -> Row:
    """Return the outcome of one mutant; the copy is restored.

    Raises:
        MutantError: The mutant does not apply, or pytest could not run the tests.
    """
    path = copy / mutant.file
    source = path.read_text(encoding="utf-8")
    try:
        _write(path, mutant.apply(source))
        # `first` kills most mutants, without importing the other tests.
        steps = [run_tests(copy, root, mutant.first, timeout_s)] if mutant.first else []
        if mutant.rest and not (steps and steps[0].status != 0):
            steps.append(run_tests(copy, root, mutant.rest, timeout_s))
    finally:
        _write(path, source)
    last = steps[-1]
    # pytest's status 1: a test failed; 2: a test module could not be imported.
    if last.status not in (None, 0, 1, 2):
        raise MutantError(
            f"pytest ended with {last.status}:\n{last.tail}",
            where=f"the tests of area {mutant.area}",
            fix=f"mend the tests named in experiments/mutants/{mutant.area}.toml",
        )
    status = last.status
    outcome: Outcome = "hangs" if status is None else "killed" if status else "survived"
    return Row(
        area=mutant.area,
        file=mutant.file,
        breaks=mutant.breaks,
        outcome=outcome,
        by=last.failed,
        wall_s=round(sum(step.wall_s for step in steps), 1),
        cpu_s=round(sum(step.cpu_s for step in steps), 1),
    )


def _write(path: Path, source: str) -> None:
    path.write_text(source, encoding="utf-8")
    # Python compares bytecode with its source by size and whole seconds, and would miss an edit.
    for stale in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        stale.unlink()


def _children_cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
