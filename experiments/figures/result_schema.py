"""Schema of a result file: fields and their types, flat finite figures, and a digest."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from types import NoneType
from typing import Any

from morph.arrays import JSON
from morph.errors import StudyError
from morph.files import sha256

SCHEMA = "morph.result/2"
FIELDS: Mapping[str, tuple[type, ...]] = {
    "schema": (str,),
    "command": (str,),
    "module": (str,),
    "settings": (dict,),
    "seeds": (list,),
    "figures": (dict,),
    "controls": (dict,),
    "commit": (str, NoneType),
    "dirty": (bool, NoneType),
    "code_hash": (str,),
    "date": (str,),
    "wall_seconds": (int, float),
    "cpu_seconds": (int, float),
    "resumed": (bool,),
    "machine": (dict,),
    "rows": (list,),
}
"""Every field but the digest, and its types."""
PATTERNS = {"commit": "[0-9a-f]{40}|[0-9a-f]{64}", "date": r"\d{4}-\d\d-\d\d"}
FIX = "correct what the study gives to save(), then run it with --save"


def check_content(result: Mapping[str, Any], where: str) -> None:
    """Check the fields of a result, except for its digest.

    Raises:
        StudyError: A field is missing, unknown or of another type, figures are nested or not
            finite, or there is no figure or no control.
    """
    if wrong := sorted({*FIELDS} ^ ({*result} - {"digest"})):
        state = "is missing" if wrong[0] in FIELDS else "is unknown"
        raise StudyError(f"field {wrong[0]!r} {state}", where=where, fix=FIX)
    for name, types in FIELDS.items():
        value = result[name]
        typed = isinstance(value, types) and (bool in types or not isinstance(value, bool))
        pattern = PATTERNS.get(name)
        if not typed or (pattern and value is not None and not re.fullmatch(pattern, value)):
            kind = type(value).__name__
            raise StudyError(f"field {name!r} is {_short(value)} ({kind})", where=where, fix=FIX)
    _check_figures(result["figures"], where)
    if not result["controls"]:
        raise StudyError(
            "there are no controls",
            where=where,
            fix="give the strongest rival, doing nothing, or the opposite error, by name",
        )
    for name in FIELDS:
        _check_finite(result[name], f"{where}: {name}")


def digest(result: Mapping[str, Any]) -> str:
    """Return the SHA-256 of all fields of a result but the digest itself.

    It reveals a figure that was changed by hand after the file was saved.
    """
    body = {key: value for key, value in result.items() if key != "digest"}
    return sha256(json.dumps(body, sort_keys=True, ensure_ascii=False))


def with_digest(result: Mapping[str, Any]) -> JSON:
    """Return a result with its digest, which replaces an earlier one."""
    body = {key: value for key, value in result.items() if key != "digest"}
    return body | {"digest": digest(body)}


def _check_figures(figures: Mapping[str, Any], where: str) -> None:
    nested = [
        name for name, value in figures.items() if not isinstance(value, (bool, int, float, str))
    ]
    if nested or not figures:
        raise StudyError(
            f"figures must be flat: {nested[0]!r} is nested or empty"
            if nested
            else "there are no figures",
            where=where,
            fix="give each number a name of its own, and put lists into rows",
        )


def _check_finite(value: Any, where: str) -> None:
    waiting = [value]
    while waiting:
        each = waiting.pop()
        if isinstance(each, float) and not math.isfinite(each):
            raise StudyError(f"{each} is no figure", where=where, fix=FIX)
        if isinstance(each, Mapping):
            waiting += each.values()
        elif isinstance(each, list):
            waiting += each


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
