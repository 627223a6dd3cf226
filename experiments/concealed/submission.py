"""A solver's answer to one case: made, checked and read."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.concealed.errors import BenchmarkError

SCHEMA = "concealed.submission/1"
CASE_SCHEMA_FILE = Path(__file__).with_name("case.schema.json")
SCHEMA_FILE = Path(__file__).with_name("submission.schema.json")
JSON = dict[str, Any]


def submission(
    case: str,
    solver: str,
    *,
    seconds: float = 0.0,
    none: float = 0.0,
    unknown: float = 0.0,
    findings: Sequence[JSON] = (),
    rivals: Sequence[JSON] = (),
    changes: Sequence[JSON] = (),
    predicted: Mapping[str, Sequence[float | None]] | None = None,
) -> JSON:
    """Return an answer as `submission.schema.json` wants it."""
    answer: JSON = {
        "schema": SCHEMA, "case": case, "solver": solver, "seconds": seconds, "none": none,
        "unknown": unknown, "findings": list(findings), "rivals": list(rivals),
    }  # fmt: skip
    if changes:
        answer["changes"] = list(changes)
    if predicted is not None:
        answer["predicted"] = {name: list(values) for name, values in predicted.items()}
    return answer


def check(answer: JSON, *, where: str) -> JSON:
    """Return an answer that the schema allows.

    Raises:
        BenchmarkError: It breaks the schema; the message names the first place.
    """
    # A library of the development tools: a solver that writes JSON needs none of it.
    import jsonschema  # type: ignore[import-untyped]

    schema = json.loads(SCHEMA_FILE.read_text())
    wrong = next(jsonschema.Draft202012Validator(schema).iter_errors(answer), None)
    if wrong is not None:
        raise BenchmarkError(
            f"{wrong.json_path}: {wrong.message[:300]}",
            where=where,
            fix=f"write it as {SCHEMA_FILE.name} states",
        )
    return dict(answer)


def load_submission(path: Path) -> JSON:
    """Return the answer in a file.

    Raises:
        BenchmarkError: The file cannot be read, is no JSON or breaks the schema.
    """
    try:
        answer = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise BenchmarkError(
            f"cannot read: {error}", where=str(path), fix="write one JSON file for each case"
        ) from error
    return check(answer, where=str(path))
