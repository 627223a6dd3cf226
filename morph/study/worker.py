"""Execution of one cell in a worker: JSON text in, JSON text out, the same on every engine."""

from __future__ import annotations

import json
import os
import platform
import sys
import time
import traceback
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from pkgutil import resolve_name

from threadpoolctl import threadpool_limits

from morph.arrays import JSON
from morph.errors import StudyError
from morph.study.code_hash import code_hash
from morph.study.encoding import decode_case, encode_row
from morph.study.isolation import isolated

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that limit the threads of numerical libraries."""

MAX_MESSAGE, MAX_TRACE = 2_000, 20_000
"""Letters that are saved: the first of an error's message, the last of its traceback."""


def run_cell(text: str) -> str:
    """Run one cell and return its result, as JSON.

    stdout of the cell goes to stderr: stdout is for the study's rows.

    Args:
        text: JSON with `function`, `case`, `path` (folders to import from), `code` (the hash
            that this machine's source must have, by module; empty where it is the sender's own),
            `ignore` (packages that the hash leaves out).

    Returns:
        JSON with `status` (`done`; `refused`: it raised an error in three parts; `failed`: it
        raised another; `other code`: this machine's source has another hash), `row`,
        `error`, `seconds`, `host`.
    """
    job = json.loads(text)
    sys.path[:0] = [folder for folder in job["path"] if folder not in sys.path]
    answer: JSON = {"host": platform.node(), "row": None, "error": None}
    start = time.perf_counter()
    try:
        differing = _differing(job)
        if differing:
            answer |= {"status": "other code", "error": {"what": differing}}
        else:
            with isolated():
                function, case = resolve_name(job["function"]), decode_case(job["case"])
                start = time.perf_counter()
                row = function(**case) if isinstance(case, Mapping) else function(case)
            answer |= {"status": "done", "row": encode_row(row)}
    except KeyboardInterrupt:  # Stops the study.
        raise
    except BaseException as error:  # SystemExit and asyncio.CancelledError are no Exception.
        parts = _three_parts(error)
        status = "refused" if parts else "failed"
        answer |= {"status": status, "error": parts or describe(error)}
    answer["seconds"] = time.perf_counter() - start
    return json.dumps(answer)


def run_cell_in_worker(text: str) -> str:
    """Run one cell as `run_cell` does, in a worker process with one thread a numerical library.

    Threads of many processes on few cores would wait for each other.
    """
    # Not undone: C code may buffer its output until the process ends.
    with suppress(OSError):
        os.dup2(2, 1)
    # For libraries loaded later; `threadpool_limits` limits those loaded already.
    os.environ.update(dict.fromkeys(THREADS, "1"))
    with threadpool_limits(1):
        return run_cell(text)


def ping() -> str:
    """Return the name of the worker's machine; tests whether a worker can run any call."""
    return platform.node()


def describe(error: BaseException) -> JSON:
    """Return an error's message and traceback, cut to the letters that are saved."""
    trace = "".join(traceback.format_exception(error))
    return {"what": f"{type(error).__name__}: {error}"[:MAX_MESSAGE], "trace": trace[-MAX_TRACE:]}


def _three_parts(error: BaseException) -> JSON | None:
    """Return `what`, `where` and `fix` of an error that has them, such as a `MorphError`.

    None for other errors, and for a `StudyError`: that is the engine's own, such as a row that
    cannot be encoded, and counts as a failure.
    """
    parts = {name: getattr(error, name, None) for name in ("what", "where", "fix")}
    texts = {name: part[:MAX_MESSAGE] for name, part in parts.items() if isinstance(part, str)}
    return texts if len(texts) == 3 and not isinstance(error, StudyError) else None


def _differing(job: JSON) -> str:
    """Return the names of the modules whose source differs from the sender's; empty for none."""
    path, ignore = [Path(each) for each in job["path"]], tuple(job["ignore"])
    return ", ".join(
        name
        for name, digits in job["code"].items()
        if code_hash(name, path=path, ignore=ignore) != digits
    )
