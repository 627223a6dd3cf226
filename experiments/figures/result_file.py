"""Result files: figures of a study with controls, rows, settings, code and machine, as JSON."""

from __future__ import annotations

import json
import math
import os
import platform
import re
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from experiments.engine_options import study_hash
from experiments.figures.result_schema import SCHEMA, check_content, digest, with_digest
from morph.arrays import JSON
from morph.errors import StudyError
from morph.files import write_whole
from morph.regular_file import read_regular

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "experiments" / "results"
"""Folder of the result files whose figures the documentation states."""
RUN_AGAIN = "run its study with --save; `make results` prints the command"
MAX_BYTES = 400_000
"""Bytes of a result file; it is committed, so large arrays stay out."""
GENERATED = ("experiments/results", "README.md", "experiments/README.md", "experiments/notes")
"""Paths that a study or `make figures` writes: changes there do not count as a dirty tree."""


@dataclass(frozen=True, kw_only=True)
class Start:
    """Code and clocks at the start of a study."""

    module: str
    """Module of the study, dotted; a package's is `experiments.gate.__main__`."""
    code_hash: str
    """Hash of the code that its figures depend on (`study_hash`)."""
    commit: str | None
    """Commit of the tree; None outside a git repository."""
    dirty: bool | None
    """Whether files other than generated ones differ from the commit."""
    wall: float
    """Monotonic clock, s."""
    cpu: float
    """Processor time of this process and of its finished children so far, s."""
    resumed: bool = False
    """Whether some rows are of an earlier run of the same code; the seconds are of the last run."""

    @classmethod
    def now(cls, module: str) -> Start:
        """Return the start of a study, to be taken before it measures anything.

        Raises:
            StudyError: There is no such module.
        """
        commit = _git("rev-parse", "HEAD")
        changed = _git("status", "--porcelain", "--", ".", *(f":!{path}" for path in GENERATED))
        return cls(
            module=module,
            code_hash=study_hash(module),
            commit=commit,
            dirty=None if commit is None else bool(changed),
            wall=time.monotonic(),
            cpu=_cpu(),
        )


def save_result(
    to: str | Path,
    *,
    start: Start,
    command: str,
    settings: Mapping[str, Any],
    seeds: Sequence[int],
    figures: Mapping[str, Any],
    controls: Mapping[str, Any],
    rows: Sequence[Mapping[str, Any]] = (),
) -> Path:
    """Write a result file and return its path.

    Floats are rounded to 6 significant digits; infinity becomes the string `infinite`.

    Args:
        to: A name, for `experiments/results/NAME.json`, or the path of another file.
        start: `Start.now(module)`, taken before the first measurement.
        command: Command that runs the study again, from `experiments.` on.
        settings: Every setting that decides what is measured.
        seeds: Random seeds; empty if nothing is drawn.
        figures: Headline figures, flat: numbers and short strings by name.
        controls: Baselines and opposite errors by name, each with its figures; not empty.
        rows: Data that the figures were computed from, one row a case.

    Raises:
        StudyError: A value is NaN or no plain data, a figure is nested, there are no figures or
            no controls, or the file would be too large to commit.
        OutputError: The file cannot be written.
    """
    path = to if isinstance(to, Path) else result_path(to)
    body = {
        "schema": SCHEMA,
        "command": command,
        "module": start.module,
        "settings": settings,
        "seeds": list(seeds),
        "figures": figures,
        "controls": controls,
        "commit": start.commit,
        "dirty": start.dirty,
        "code_hash": start.code_hash,
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "wall_seconds": time.monotonic() - start.wall,
        "cpu_seconds": _cpu() - start.cpu,
        "resumed": start.resumed,
        "machine": machine(),
        "rows": list(rows),
    }
    plain: JSON = _plain(body, str(path))
    check_content(plain, str(path))
    text = encode(with_digest(plain))
    if len(text.encode()) > MAX_BYTES:
        raise StudyError(
            f"would take {len(text.encode())} bytes, more than {MAX_BYTES}",
            where=str(path),
            fix="keep in rows only what the figures are computed from",
        )
    return write_whole(path, text)


def encode(result: JSON) -> str:
    """Return the text of a result file, one line a row, so that diffs are readable."""
    head = {key: value for key, value in result.items() if key != "rows"}
    lines = ",".join(f"\n  {json.dumps(row)}" for row in result["rows"])
    body = json.dumps(head, indent=1, ensure_ascii=False)[:-2]
    return f'{body},\n "rows": [{lines}\n ]\n}}\n'


def result_path(name: str, folder: Path = RESULTS) -> Path:
    """Return the path of a study's result file."""
    return folder / f"{name}.json"


def load_result(name: str | Path, *, folder: Path = RESULTS) -> JSON:
    """Return a result by its name or from a file, checked as by `save_result`.

    Raises:
        StudyError: There is no such regular file, it is no result, or it was changed after it was
            saved.
    """
    path = name if isinstance(name, Path) else result_path(name, folder)
    try:
        result = json.loads(read_regular(path, MAX_BYTES), parse_constant=_refuse_constant)
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or error
        raise StudyError(f"cannot be read: {why}", where=str(path), fix=RUN_AGAIN) from error
    if not isinstance(result, dict) or result.get("schema") != SCHEMA:
        raise StudyError(f"is not a result of schema {SCHEMA}", where=str(path), fix=RUN_AGAIN)
    check_content(result, str(path))
    if result.get("digest") != digest(result):
        raise StudyError("was changed after it was saved", where=str(path), fix=RUN_AGAIN)
    return result


def is_stale(result: JSON) -> bool:
    """Return whether the code that made a result has changed since, or its module is gone."""
    try:
        return bool(study_hash(result["module"]) != result["code_hash"])
    except StudyError:
        return True


def figure_name(words: str) -> str:
    """Return a phrase as the name of a figure: `as MuJoCo comes` gives `as_mujoco_comes`."""
    return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")


def flat(figures: Mapping[str, Any], prefix: str = "") -> JSON:
    """Return nested figures flattened, their names joined by `_`; lists are left out.

    `{"hop": {"iqm": 1.0}}` gives `{"hop_iqm": 1.0}`.
    """
    flattened: JSON = {}
    for name, value in figures.items():
        own = figure_name(f"{prefix} {name}")
        if isinstance(value, Mapping):
            flattened |= flat(value, own)
        elif isinstance(value, (int, float, str, np.generic)):
            flattened[own] = value
    return flattened


def machine() -> JSON:
    """Return the processor, cores, memory (GiB) and versions that the figures depend on."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {
        "cpu": _cpu_model(),
        "cores": len(os.sched_getaffinity(0)),
        "ram_gib": round(memory / 2**30, 1),
        "python": platform.python_version(),
        "mujoco": version("mujoco"),
    }


def _cpu_model() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else platform.machine()


def _cpu() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def _git(*arguments: str) -> str | None:
    """Return the output of git; None where there is no git or no repository."""
    try:
        process = subprocess.run(
            ["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return process.stdout.strip()


def _refuse_constant(word: str) -> None:
    raise ValueError(f"{word} is no number")


def _plain(value: Any, where: str) -> Any:
    """Return a value as plain JSON data, floats rounded; refuse what JSON cannot hold."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each, f"{where}: {key}") for key, each in value.items()}
    if isinstance(value, (list, tuple, range, np.ndarray)):
        return [_plain(each, f"{where}[{place}]") for place, each in enumerate(value)]
    if isinstance(value, np.generic):
        return _plain(value.item(), where)
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, float):
        if math.isnan(value):
            raise StudyError(
                f"{value} is no figure",
                where=where,
                fix="leave it out, or say in words why there is no number",
            )
        return float(f"{value:.6g}") if math.isfinite(value) else "infinite"
    if value is None or isinstance(value, (bool, int, str)):
        return value
    raise StudyError(
        f"a {type(value).__name__} is no plain data",
        where=where,
        fix="save numbers, texts, lists and dictionaries",
    )
