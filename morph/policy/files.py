"""The files of a policy, read with distrust: bounded, no pickles, only finite numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from morph.arrays import JSON, Array
from morph.errors import PolicyError
from morph.policy.fields import most_of, whole_of
from morph.regular_file import read_regular

FILES = ("weights.safetensors", "policy.json")
"""What a policy consists of; the last makes it one."""

EXPORTED = "policy.onnx"
"""What a policy is exported to, if it is, in the same folder."""

MOST_BYTES = {"policy.json": 2**20, "weights.safetensors": 2**26}
"""Largest file of each name."""


def read_json(path: Path) -> JSON:
    """Return the object that a JSON file holds.

    Raises:
        PolicyError: It is missing, too large, or no object in JSON.
    """
    content = _read(path)
    try:
        document = json.loads(content)
    # Brackets in their thousands exceed Python's own depth.
    except (ValueError, RecursionError) as error:
        raise PolicyError(
            f"it is not JSON: {most_of(str(error))}",
            where=str(path),
            fix="give a policy of morph's own",
        ) from error
    return whole_of(document, str(path))


def read_tensors(path: Path) -> dict[str, Array]:
    """Return the arrays of a safetensors file, finite, as float64.

    Raises:
        PolicyError: It is missing, too large, no safetensors file, or holds other numbers.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    content = _read(path)
    fix = "give a policy of morph's own"
    try:
        tensors = load(content)
    # Its reader knows formats of numbers that NumPy lacks, and says so by a KeyError.
    except (SafetensorError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise PolicyError(
            f"it is no safetensors file: {most_of(str(error))}", where=str(path), fix=fix
        ) from error
    for name, value in tensors.items():
        if value.dtype not in (np.float64, np.float32) or not np.isfinite(value).all():
            raise PolicyError(
                f"{most_of(name)} does not consist of finite floating-point numbers",
                where=str(path),
                fix=fix,
            )
    return {name: value.astype(float) for name, value in tensors.items()}


def _read(path: Path) -> bytes:
    most = MOST_BYTES[path.name]
    try:
        return read_regular(path, most)
    except FileNotFoundError as error:
        raise PolicyError(
            "there is no such file",
            where=str(path),
            fix=f"give a folder that holds {' and '.join(FILES)}",
        ) from error
    except OSError as error:
        raise PolicyError(
            f"cannot be read: {error.strerror or error}",
            where=str(path),
            fix="give a policy of morph's own, in plain files that can be read",
        ) from error
