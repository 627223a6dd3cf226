"""Making the files that studies read from those that are public."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from experiments.public.content import DataError
from morph.arrays import Array

COLUMNS = 19
"""Columns of a toss: position, quaternion, velocities, control."""


def tosses(folder: Path, inputs: Mapping[str, bytes]) -> bytes:
    """Return ContactNets' tosses as one NPZ, key = number, from a torch file for each.

    The torch files are pickles: `weights_only` reads tensors from them and refuses
    whatever else they hold, so that none of their code runs.

    Args:
        folder: Not used.
        inputs: Content of `<number>.pt`, by name; each a tensor of shape (samples, 19)
            or (1, samples, 19).

    Raises:
        DataError: A file holds anything but such a tensor.
    """
    arrays: dict[str, Any] = {
        PurePosixPath(name).stem: _toss(name, data) for name, data in inputs.items()
    }
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    return content.getvalue()


def _toss(name: str, data: bytes) -> Array:
    import torch

    fix = "fetch it again with python -m experiments.data"
    try:
        held = torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises errors of every kind for what it cannot read.
        first = str(error).split("\n")[0]
        raise DataError(f"is not a torch file of tensors: {first}", where=name, fix=fix) from error
    shape = tuple(getattr(held, "shape", ()))
    if not isinstance(held, torch.Tensor) or shape[-1:] != (COLUMNS,) or len(shape) not in (2, 3):
        what = f"holds {type(held).__name__} {shape} instead of a tensor (samples, {COLUMNS})"
        raise DataError(what, where=name, fix=fix)
    if len(shape) == 3 and shape[0] != 1:
        raise DataError(f"holds {shape[0]} tosses instead of one", where=name, fix=fix)
    return np.asarray(held.detach().numpy(), dtype=float).reshape(-1, COLUMNS)


def expand_xacro(folder: Path, inputs: Mapping[str, bytes]) -> bytes:
    """Return the URDF that a set's xacro expands to.

    Args:
        folder: The set's folder.
        inputs: The xacro's path in the set is the only key.

    Raises:
        RobotError: It cannot be expanded.
    """
    from morph.body.xacro.process import expand

    (path,) = inputs
    return expand(folder / path, folder)


CONVERTERS: dict[str, Callable[[Path, Mapping[str, bytes]], bytes]] = {
    "tosses": tosses,
    "xacro": expand_xacro,
}
"""How files are made, by the name that `data.toml` calls it by."""
