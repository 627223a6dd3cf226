"""Whether a slicer ended well, and what is to be read of what it said and wrote."""

from __future__ import annotations

import re
import signal
import tempfile

from morph.print.errors import SlicerError
from morph.print.run_with_timeout import Ran

TIME = re.compile(rb"^; estimated printing time \(normal mode\) = (.+)$", re.MULTILINE)
FILAMENT = re.compile(rb"^; filament used \[mm\] = ([0-9.]+)", re.MULTILINE)
END = b"; prusaslicer_config = end"
"""The last line of every G-code that PrusaSlicer finished."""
WARNING = re.compile(r"^(?:print|print_object) warning: (.+)$|^\[.*?\[(?:warning|error)\]\s*(.+)$")
SETTLED = ("Detected missing Voronoi vertex, input polygons will be rotated back and forth.",)
"""What it says while it helps itself; had that been in vain, it would say so in another line."""
AGREE = 0.005
"""Our sum of the filament and the slicer's own may differ by this part."""


def ended_well(ran: Ran, name: str, timeout_s: float, where: str) -> None:
    """Refuse an end by the clock, by a signal or with an error.

    Raises:
        SlicerError: The slicer hung, died or gave up; what it said last is quoted.
    """
    if ran.status is None:
        raise SlicerError(
            f"{name} did not end within {timeout_s:g} s and was killed; it said: {_last(ran)}",
            where=where,
            fix="give it more time, reduce the mesh, or go without the slicer",
        )
    if ran.status < 0:
        raise SlicerError(
            f"{name} died of {_signal(-ran.status)}; it said: {_last(ran)}",
            where=where,
            fix="see that there is enough memory and that the mesh is a clean solid",
        )
    if ran.status > 0:
        raise SlicerError(
            f"{name} ended with status {ran.status}; it said: {_last(ran)}",
            where=where,
            fix="put right what it complains of, or go without the slicer",
        )


def whole(gcode: bytes, ran: Ran, name: str, where: str) -> None:
    """Refuse a G-code that is missing or cut short: the slicer's status does not tell.

    Raises:
        SlicerError: There is none, or its end is missing.
    """
    if gcode and END in gcode[-200:] and FILAMENT.search(gcode):
        return
    result = f"{len(gcode)} bytes without the end of a G-code" if gcode else "no G-code"
    raise SlicerError(
        f"{name} ended as if all were well but wrote {result}; it said: {_last(ran)}",
        where=where,
        fix=f"see that {tempfile.gettempdir()} has room, and slice the part by hand to look at it",
    )


def agree(gcode: bytes, ours: float, where: str) -> None:
    """Refuse a G-code of which our sum of the filament is not the slicer's."""
    result = FILAMENT.search(gcode)
    theirs = float(result.group(1)) if result else 0.0
    if abs(ours - theirs) > AGREE * theirs:
        raise SlicerError(
            f"its lines use {ours:.1f} mm of filament, while its last lines say {theirs:.1f} mm",
            where=f"G-code of {where}",
            fix="slice the part again; should it stay, report the version of the slicer",
        )


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _last(ran: Ran) -> str:
    """Return the last lines that a slicer said, without its progress."""
    lines = [line for line in ran.said.splitlines() if line.strip() and "] [trace]" not in line]
    return " | ".join(line.strip()[:200] for line in lines[-4:]) or "nothing"


def seconds(gcode: bytes) -> float:
    """Return the slicer's estimate of the time, such as `1d 2h 3m 4s`, in seconds."""
    result = TIME.search(gcode)
    units = {"d": 86400.0, "h": 3600.0, "m": 60.0, "s": 1.0}
    text = result.group(1).decode() if result else ""
    return sum(float(count) * units[unit] for count, unit in re.findall(r"(\d+)([dhms])", text))


def warnings(text: str) -> tuple[str, ...]:
    """Return what a slicer warned of, each warning once."""
    results = (WARNING.match(line.strip()) for line in text.splitlines())
    words = (each.group(1) or each.group(2) for each in results if each)
    return tuple(dict.fromkeys(each for each in words if each not in SETTLED))
