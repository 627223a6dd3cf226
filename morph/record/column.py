"""One line of `[columns]`: where a canonical channel stands in a file, and in which unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.errors import RecordingError
from morph.nearest import nearest
from morph.record.entry import Entry
from morph.record.quantities import ChannelName, parse_channel
from morph.record.read.table import Table
from morph.record.units import Unit, unit

FORMS = ("euler-xyz", "quaternion-wxyz", "quaternion-xyzw")
"""How an orientation may be written; the angles are roll, pitch and yaw."""
FRAMES = ("body", "world")
"""The frames that a tracked body's velocity may be written in."""


@dataclass(frozen=True, kw_only=True)
class Column:
    """Where one channel, or all axes of one quantity, stands in a file."""

    sources: tuple[tuple[str | int, int | None], ...]
    """Column by name or number, and element within its cells; one per axis."""
    name: ChannelName | None
    """The channel's name taken apart; None for `time`."""
    factor: float = 1.0
    """What one of its unit is in SI."""
    dimension: str = ""
    """What that unit measures, as `N m`; empty where none is given."""
    scale: float = 1.0
    """What one raw count is in the unit."""
    offset: float = 0.0
    """Added after scaling, in the unit."""
    form: str = ""
    """One of `FORMS`, for an orientation; else empty."""
    frame: str = ""
    """One of `FRAMES`, for a velocity given by its axes; else empty."""
    where: str
    """File and line of the binding, for errors."""

    def values(self, table: Table) -> Array:
        """Return the values in SI, shape (samples, axes)."""
        raw = [table.column(column, element) for column, element in self.sources]
        if len({len(one) for one in raw}) > 1:
            raise RecordingError(
                f"the columns of one channel differ in length: {[len(one) for one in raw]}",
                where=f"{self.where}, for {table.path}",
                fix="bind columns of one length",
            )
        # What overflows becomes infinite, and is refused as that with its line.
        with np.errstate(over="ignore", invalid="ignore"):
            return (np.stack(raw, axis=1) * self.scale + self.offset) * self.factor


def read_column(name: str, entry: Entry) -> Column:
    """Return one line of `[columns]`, checked.

    Args:
        name: The canonical channel, or `time`.
        entry: Its table: column, element, unit, scale, offset, form, frame.

    Raises:
        RecordingError: A key is unknown or wrong, the unit does not fit the
            channel, or the number of columns does not.
    """
    entry.allow("column", "element", "unit", "scale", "offset", "form", "frame")
    sources = _sources(entry)
    whole = len(sources) > 1
    channel = None if name == "time" else parse_channel(name, where=entry.where(), whole=whole)
    scale, offset = entry.ratio("scale"), entry.number("offset")
    if scale == 0.0:
        raise entry.error("scale is 0, so every sample would be the same", "scale", "correct it")
    form = _form(entry, channel, len(sources))
    _check_count(entry, channel, len(sources), form)
    measure = _unit(entry, channel, form)
    return Column(
        sources=sources,
        name=channel,
        factor=1.0 if measure is None else measure.factor,
        dimension="" if measure is None else measure.dimension,
        scale=1.0 if scale is None else scale,
        offset=0.0 if offset is None else offset,
        form=form,
        frame=_frame(entry, channel, whole),
        where=entry.where(),
    )


def _sources(entry: Entry) -> tuple[tuple[str | int, int | None], ...]:
    column, element = entry.table.get("column"), entry.table.get("element")
    columns: list[Any] = column if isinstance(column, list) else [column]
    elements: list[Any] = element if isinstance(element, list) else [element]
    if not columns or not all(
        isinstance(one, str | int) and not isinstance(one, bool) for one in columns
    ):
        raise entry.error(
            f"column is {column!r}",
            "column",
            "write a name in quotes, a number from 0, or a list of these",
        )
    if not elements or not all(
        one is None or (isinstance(one, int) and not isinstance(one, bool)) for one in elements
    ):
        raise entry.error(f"element is {element!r}", "element", "write a number from 0")
    if len(elements) > 1 and len(columns) > 1:
        raise entry.error("both column and element are lists", "element", "keep one list")
    return tuple((one, which) for one in columns for which in elements)


def _form(entry: Entry, channel: ChannelName | None, count: int) -> str:
    form = entry.text("form") or ""
    orientation = channel is not None and channel.quantity.name == "orientation" and count > 1
    if form and (not orientation or form not in FORMS):
        raise entry.error(
            f"form is {form!r}" if orientation else "form is only for a whole orientation",
            "form",
            f"for <body>.orientation write one of {', '.join(FORMS)}",
        )
    if orientation and not form:
        raise entry.error(
            "an orientation needs its form", "", f"add form = one of {', '.join(FORMS)}"
        )
    return form


def _check_count(entry: Entry, channel: ChannelName | None, count: int, form: str) -> None:
    if channel is None and count > 1:
        raise entry.error("time needs one column", "column", "name one column")
    if channel is None or count == 1:
        return
    wanted = 3 if form == "euler-xyz" else len(channel.quantity.axes)
    if count != wanted:
        raise entry.error(
            f"{channel.quantity.name} needs {wanted} columns, {count} are given",
            "column",
            f"list {wanted} columns, in the order of the axes",
        )


def _unit(entry: Entry, channel: ChannelName | None, form: str) -> Unit | None:
    """Return the unit of a column; None of one that needs none and names none."""
    symbol = entry.text("unit")
    if channel is None:
        allowed: tuple[str, ...] = ("s",)
    elif channel.quantity.name == "orientation":
        allowed = ("rad",) if form == "euler-xyz" else ("1",)
    else:
        allowed = channel.quantity.dimensions
    if symbol is None:
        # A command has the actuator's own unit; a quaternion has none.
        if not allowed or allowed == ("1",):
            return None
        raise entry.error(
            "the column has no unit", "", f'add unit = "{allowed[0]}", or the one it is written in'
        )
    result = unit(symbol, where=entry.where("unit"))
    if allowed and result.dimension not in allowed:
        raise entry.error(
            f"the unit {symbol!r} does not fit: this channel is in {' or '.join(allowed)}",
            "unit",
            "correct the unit or the channel's name",
        )
    return result


def _frame(entry: Entry, channel: ChannelName | None, whole: bool) -> str:
    frame = entry.text("frame") or ""
    turns = whole and channel is not None and channel.quantity.name.endswith("_velocity")
    if frame and frame not in FRAMES:
        raise entry.error(
            f"frame is {frame!r}", "frame", f"the nearest is {nearest(frame, FRAMES)}"
        )
    if frame and not turns:
        raise entry.error(
            "frame is only for a body's velocity given by its three columns",
            "frame",
            "remove it, or bind <body>.linear_velocity or .angular_velocity as a list",
        )
    return frame
