"""A tracked body's channels in the forms and frames in which recordings keep them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.record.column import Column
from morph.record.frames import CANONICAL, quaternion, turn
from morph.record.quantities import WXYZ
from morph.record.read.table import Table
from morph.record.recording import Note

UNIT_QUATERNION = 1e-3
"""How far a quaternion's length may be from 1 before scaling it counts as a repair."""


def in_canonical_frames(
    blocks: dict[str, Array], columns: Mapping[str, Column], table: Table
) -> tuple[Note, ...]:
    """Write orientations as unit quaternions, then turn velocities into their frames.

    Args:
        blocks: Each channel's values in SI, shape (samples, axes); changed in place.
        columns: What the binding says of each channel.
        table: The file, for errors.

    Returns:
        What was repaired.

    Raises:
        RecordingError: A quaternion is none, or a velocity's frame needs an
            orientation that is not bound.
    """
    notes: list[Note] = []
    for name, column in columns.items():
        if column.form:
            blocks[name], repaired = _unit(quaternion(blocks[name], column.form), name, table)
            notes += repaired
    for name, column in columns.items():
        if column.name is None or not column.frame:
            continue
        into = CANONICAL[column.name.quantity.name]
        if column.frame == into:
            continue
        orientation = blocks.get(f"{column.name.part}.orientation")
        if orientation is None or orientation.shape[1] != len(WXYZ):
            raise RecordingError(
                f"{name} is in the {column.frame} frame and is kept in the {into} frame, "
                "which needs the body's orientation",
                where=column.where,
                fix=f"bind {column.name.part}.orientation as a list of columns with its form",
            )
        blocks[name] = turn(blocks[name], orientation, into=into)
    return tuple(notes)


def _unit(values: Array, name: str, table: Table) -> tuple[Array, list[Note]]:
    """Return quaternions of length 1, and a note if one had another length."""
    length = np.linalg.norm(values, axis=1)
    off = np.abs(length - 1.0)
    rows = np.flatnonzero(off > UNIT_QUATERNION)
    if (off > 0.1).any():
        row = int(np.flatnonzero(off > 0.1)[0])
        raise RecordingError(
            f"{name} is no orientation: its quaternion has length {length[row]:.3g}",
            where=table.place(row),
            fix="correct the columns, their order, or the form",
        )
    scaled = values / np.where(length > 0.0, length, 1.0)[:, None]
    if not len(rows):
        return scaled, []
    note = Note(
        what=f"{name}: {len(rows)} quaternions were not of length 1 and are scaled to it",
        where=table.place(*rows.tolist()),
        repaired=len(rows),
    )
    return scaled, [note]
