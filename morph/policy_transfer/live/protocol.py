"""What a live target and morph say to each other: one JSON object a line, read with distrust."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from morph.arrays import JSON
from morph.errors import TransferError

SCHEMA = "morph.live/1"
"""The schema that the first message of a target names."""

LONGEST_LINE = 2**16
"""Most bytes of a line; a longer one is thrown away whole."""

MOST_PARTS = 1000
"""Most channels, and most actuators."""

LONGEST_NAME = 200
"""Most characters of a name or a unit."""

LARGEST = 1e10
"""Greatest number that a target may say; the seconds since 1970 are below it."""

Clock = Literal["target", "none"]
"""Who keeps time: a target whose states come at a fixed rate, or nobody: it steps when told."""


@dataclass(frozen=True, kw_only=True)
class Signal:
    """A channel or an actuator as a target calls it."""

    name: str
    """Its name: `slide.position`, or `slide` for an actuator."""
    unit: str
    """Its unit: `m`, `rad/s`, `N`."""


@dataclass(frozen=True, kw_only=True)
class Hello:
    """What a target says of itself before anything moves."""

    channels: tuple[Signal, ...]
    """What it measures, in any order."""
    actuators: tuple[Signal, ...]
    """What it can be told, in any order."""
    period: float
    """Time from one state to the next, s; it holds each command that long."""
    clock: Clock = "target"
    """Who keeps time."""


def parsed(line: bytes) -> JSON | None:
    """Return the object that a line holds; None if it holds no such thing."""
    try:
        document = json.loads(line)
    # Brackets in their thousands exceed Python's own depth, digits in their thousands its patience.
    except (ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def line_of(message: Mapping[str, Any]) -> bytes:
    """Return a message as a line."""
    return json.dumps(message, allow_nan=False).encode() + b"\n"


def hello_of(message: Mapping[str, Any], *, where: str) -> Hello:
    """Return what the first message of a target says.

    Raises:
        TransferError: It is of another schema, or lacks a part.
    """
    if message.get("schema") != SCHEMA:
        raise _refused(f"its schema is {_short(message.get('schema'))}", where)
    period, clock = number(message.get("period_s")), message.get("clock", "target")
    if not 1e-4 <= period <= 10.0:
        raise _refused(
            f"its period_s is {_short(message.get('period_s'))}, not 1e-4 to 10 s", where
        )
    if clock not in get_args(Clock):
        raise _refused(
            f"its clock is {_short(clock)}, not one of {', '.join(get_args(Clock))}", where
        )
    return Hello(
        channels=_signals(message, "channels", where),
        actuators=_signals(message, "actuators", where),
        period=period,
        clock=clock,
    )


def hello_said(hello: Hello) -> JSON:
    """Return the first message of a target."""
    return {
        "schema": SCHEMA,
        "channels": [vars(each) for each in hello.channels],
        "actuators": [vars(each) for each in hello.actuators],
        "period_s": hello.period,
        "clock": hello.clock,
    }


def number(value: object) -> float:
    """Return a number up to `LARGEST`; nan for anything else, `null` and `NaN` among it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    return float(value) if abs(value) <= LARGEST else math.nan


def _signals(message: Mapping[str, Any], key: str, where: str) -> tuple[Signal, ...]:
    listed = message.get(key)
    if not isinstance(listed, list) or not 0 < len(listed) <= MOST_PARTS:
        raise _refused(f"its {key} are {_short(listed)}, not a list of 1 to {MOST_PARTS}", where)
    results = []
    for each in listed:
        name, unit = (each.get("name"), each.get("unit")) if isinstance(each, dict) else (0, 0)
        if not (isinstance(name, str) and isinstance(unit, str)):
            raise _refused(f"of its {key}, {_short(each)} lacks a name or a unit", where)
        if max(len(name), len(unit)) > LONGEST_NAME:
            raise _refused(f"of its {key}, {_short(name)} is too long a name or unit", where)
        results.append(Signal(name=name, unit=unit))
    names = [each.name for each in results]
    if len(set(names)) < len(names):
        twice = sorted({name for name in names if names.count(name) > 1})
        raise _refused(f"its {key} name {', '.join(twice)} twice", where)
    return tuple(results)


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= LONGEST_NAME else f"{text[:LONGEST_NAME]}..."


def _refused(what: str, where: str) -> TransferError:
    return TransferError(
        what,
        where=where,
        fix=f'begin with {{"schema": "{SCHEMA}", "channels": [{{"name": ..., "unit": ...}}], '
        '"actuators": [...], "period_s": ...}, as docs/live.md says',
    )
