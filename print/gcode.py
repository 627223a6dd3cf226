"""G-code as arrays: where plastic was laid, how much of it, and as what type of line."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array, Integers, Mask
from morph.print.errors import SlicerError

MOVES = (b"G0", b"G1")
"""Straight moves."""
REFUSED = {
    b"G2": "an arc (G2), while only straight moves are weighed",
    b"G3": "an arc (G3), while only straight moves are weighed",
    b"G5": "a spline (G5), while only straight moves are weighed",
    b"G20": "inches (G20), while only millimetres are read",
}
"""Commands that would change what the moves mean, and why they are not read."""
REMARKS = (b"TYPE", b"WIDTH", b"HEIGHT")
"""What PrusaSlicer says of the lines that follow."""
AXES = b"XYZE"
BLANK = np.isin(np.arange(256), np.frombuffer(b" \t\n\r\v\f", dtype=np.uint8))
"""Which bytes separate words: those at which `bytes.split` divides."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ExtrusionLines:
    """Every straight line along which plastic was laid, in the order of printing."""

    start: Array
    """Where the nozzle began, mm, shape (n, 3)."""
    end: Array
    """Where it ended, mm, shape (n, 3)."""
    filament: Array
    """Length of filament pushed, mm, shape (n,)."""
    width: Array
    """Width of the line, mm; nan where the G-code does not say, shape (n,)."""
    height: Array
    """Height of the line, mm; nan where the G-code does not say, shape (n,)."""
    feature: Integers
    """Which of `features` it belongs to, shape (n,)."""
    features: tuple[str, ...]
    """Types of lines by the slicer's names; the first is empty: before any was named."""


def lines(gcode: bytes, *, where: str = "G-code") -> ExtrusionLines:
    """Return the lines that a G-code lays; absolute and relative distances are both read.

    Homing (G28) brings an axis to 0. Retraction, and what undoes it, moves filament but not
    the nozzle, and lays nothing.

    Args:
        gcode: Text of the G-code, with the remarks `;TYPE:`, `;WIDTH:` and `;HEIGHT:` of
            PrusaSlicer if it has them.
        where: What to call it in an error.

    Raises:
        SlicerError: It has arcs, inches, numbers that are none, or lays nothing.
    """
    breaks = np.flatnonzero(np.frombuffer(gcode, dtype=np.uint8) == ord("\n"))
    words = _words(gcode, breaks, where)
    place, pushed = _followed(words)
    before = np.vstack([np.zeros((1, 3)), place[:-1]])
    laid = (pushed > 0) & words.moves & (np.abs(place - before).max(axis=1) > 0)
    if not laid.any():
        raise SlicerError(
            f"none of its {len(breaks)} lines lays plastic",
            where=where,
            fix="slice the part again, and look at what the slicer says of it",
        )
    at = words.line[laid]
    remarks = _remarks(gcode, breaks)
    feature, features = _features(remarks[b"TYPE"], at)
    return ExtrusionLines(
        start=before[laid],
        end=place[laid],
        filament=pushed[laid],
        width=_said(remarks[b"WIDTH"], at, where),
        height=_said(remarks[b"HEIGHT"], at, where),
        feature=feature,
        features=features,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Words:
    """Commands that move, set or home: one row each."""

    line: Integers
    """Line of the text that each stands on."""
    moves: Mask
    """Whether it is a straight move."""
    homes: Mask
    """Whether it homes."""
    value: Array
    """Number after X, Y, Z and E; nan where there is none, shape (n, 4)."""
    relative: Mask
    """Whether the axes, and the extruder, count from where they are, shape (n, 2)."""


def _words(gcode: bytes, breaks: Integers, where: str) -> _Words:
    """Return the commands that matter, read in one pass over all words of the text."""
    bare = re.sub(rb";[^\n]*", lambda remark: b" " * len(remark.group()), gcode)
    letters = np.frombuffer(bare, dtype=np.uint8)
    blank = BLANK[letters]
    starts = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    if not len(starts):
        return _Words(
            line=np.zeros(0, dtype=np.int64),
            moves=np.zeros(0, dtype=bool),
            homes=np.zeros(0, dtype=bool),
            value=np.zeros((0, 4)),
            relative=np.zeros((0, 2), dtype=bool),
        )
    texts = np.array(bare.split(), dtype="S16")
    line = np.searchsorted(breaks, starts)
    first = np.concatenate([[True], line[1:] != line[:-1]])
    command = texts[first]
    for name, why in REFUSED.items():
        if (command == name).any():
            raise SlicerError(
                f"line {line[first][command == name][0] + 1} is {why}",
                where=where,
                fix="switch arc fitting off in the slicer, and use millimetres",
            )
    moves, homes = np.isin(command, MOVES), command == b"G28"
    kept = moves | homes | (command == b"G92")
    rows = np.cumsum(kept) - 1
    row = rows[np.cumsum(first) - 1]
    number = ~first & kept[np.cumsum(first) - 1]
    value = np.full((int(kept.sum()), 4), np.nan)
    for axis, letter in enumerate(AXES):
        chosen = number & (letters[starts] == letter)
        value[row[chosen], axis] = _numbers(texts[chosen], where)
    return _Words(
        line=line[first][kept],
        moves=moves[kept],
        homes=homes[kept],
        value=value,
        relative=_modes(command)[kept],
    )


def _numbers(texts: Array, where: str) -> Array:
    """Return what stands after the letter of each word."""
    if not len(texts):
        return np.zeros(0)
    rest = texts.view("S1").reshape(len(texts), -1)[:, 1:].copy().view("S15").ravel()
    try:
        # `G28 X` homes X: a letter without a number. Python reads bytes faster than numpy.
        values = np.array([float(text or b"0") for text in rest.tolist()])
        if not np.isfinite(values).all():
            raise ValueError("not finite")
    except ValueError as error:
        raise SlicerError(
            f"a coordinate is no number ({error})",
            where=where,
            fix="slice the part again; the file may be cut short or mixed up",
        ) from error
    return values


def _modes(command: Array) -> Mask:
    """Return whether axes and extruder are relative at each command, shape (n, 2).

    G90 and G91 are for all, M82 and M83 for the extruder alone, as Marlin has it.
    """
    modes = np.zeros((len(command), 2), dtype=bool)
    for column, (on, off) in enumerate(
        (((b"G91",), (b"G90",)), ((b"G91", b"M83"), (b"G90", b"M82")))
    ):
        switch = np.where(np.isin(command, on), 1, np.where(np.isin(command, off), -1, 0))
        last = np.maximum.accumulate(np.where(switch != 0, np.arange(len(command)), -1))
        modes[:, column] = (last >= 0) & (switch[last] == 1)
    return modes


def _followed(words: _Words) -> tuple[Array, Array]:
    """Return where the nozzle is after each command, mm, and the filament that it pushed, mm."""
    place = np.zeros((len(words.line), 3))
    named = ~np.isnan(words.value)
    all_axes = words.homes & ~named[:, :3].any(axis=1)
    for axis in range(3):
        given = np.nan_to_num(words.value[:, axis])
        homed = words.homes & (named[:, axis] | all_axes)
        sets = (words.moves & named[:, axis] & ~words.relative[:, 0]) | homed
        sets |= ~words.moves & ~words.homes & named[:, axis]
        adds = words.moves & named[:, axis] & words.relative[:, 0]
        place[:, axis] = _counted(sets, adds, np.where(homed, 0.0, given))
    given = np.nan_to_num(words.value[:, 3])
    turns = words.moves & named[:, 3]
    adds = turns & words.relative[:, 1]
    sets = named[:, 3] & ~words.homes & ~adds
    counter = _counted(sets, adds, given)
    before = np.concatenate([[0.0], counter[:-1]])
    pushed = np.where(adds, given, np.where(turns, counter - before, 0.0))
    return place, pushed


def _counted(sets: Mask, adds: Mask, given: Array) -> Array:
    """Return a counter after each command: the last value set plus what was added since."""
    added = np.cumsum(np.where(adds, given, 0.0))
    last = np.maximum.accumulate(np.where(sets, np.arange(len(sets)), -1))
    base = np.where(last >= 0, given[last] - added[last], 0.0)
    counted: Array = base + added
    return counted


def _remarks(gcode: bytes, breaks: Integers) -> dict[bytes, tuple[Integers, list[bytes]]]:
    """Return on which lines each remark stands, and what it says there."""
    starts = np.concatenate([[0], breaks + 1])
    starts = starts[starts < len(gcode)]
    noted = np.flatnonzero(np.frombuffer(gcode, dtype=np.uint8)[starts] == ord(";"))
    results: dict[bytes, tuple[list[int], list[bytes]]] = {name: ([], []) for name in REMARKS}
    for line, start in zip(noted.tolist(), starts[noted].tolist(), strict=True):
        name, colon, _ = gcode[start + 1 : start + 8].partition(b":")
        if colon and name in results:
            end = gcode.find(b"\n", start)
            text = gcode[start : end if end >= 0 else len(gcode)]
            results[name][0].append(line)
            results[name][1].append(text.partition(b":")[2].strip())
    return {name: (np.array(at, dtype=np.int64), texts) for name, (at, texts) in results.items()}


def _said(remark: tuple[Integers, list[bytes]], at: Integers, where: str) -> Array:
    """Return the number that a remark gave last before each line; nan before the first."""
    lines_of, texts = remark
    try:
        values = np.array([np.nan, *(float(text) for text in texts)])
    except ValueError as error:
        raise SlicerError(
            f"the width or height of a line is no number ({error})",
            where=where,
            fix="slice the part again; the file may be cut short or mixed up",
        ) from error
    statement: Array = values[np.searchsorted(lines_of, at)]
    return statement


def _features(
    remark: tuple[Integers, list[bytes]], at: Integers
) -> tuple[Integers, tuple[str, ...]]:
    """Return which type each line is, and the types."""
    lines_of, texts = remark
    names = [text.decode("utf-8", "replace") for text in texts]
    features = ("", *dict.fromkeys(names))
    index = {name: number for number, name in enumerate(features)}
    types = np.array([0, *(index[name] for name in names)], dtype=np.int64)
    return types[np.searchsorted(lines_of, at)], features
