"""The units in which a recording's columns may be written, and what they are in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass

from morph.errors import RecordingError
from morph.nearest import nearest


@dataclass(frozen=True, kw_only=True)
class Unit:
    """One unit of measurement."""

    factor: float
    """What one of it is in the SI unit of its dimension."""
    dimension: str
    """What it measures, written as the SI unit: `rad`, `N m`; `1` for a ratio."""


def _units(dimension: str, **factors: float) -> dict[str, Unit]:
    return {name: Unit(factor=factor, dimension=dimension) for name, factor in factors.items()}


def _rates(dimension: str, **factors: float) -> dict[str, Unit]:
    """Return units, and each of them per second and per second squared."""
    table = _units(dimension, **factors)
    for name, factor in factors.items():
        table[f"{name}/s"] = Unit(factor=factor, dimension=f"{dimension}/s")
        for squared in ("s2", "s^2"):
            table[f"{name}/{squared}"] = Unit(factor=factor, dimension=f"{dimension}/s2")
    return table


DEGREE = math.pi / 180.0
"""One degree, rad."""

UNITS: dict[str, Unit] = {
    **_rates("rad", rad=1.0, mrad=1e-3, deg=DEGREE, rev=2.0 * math.pi),
    **_rates("m", m=1.0, cm=1e-2, mm=1e-3),
    **_units("s", s=1.0, ms=1e-3, us=1e-6, ns=1e-9, min=60.0),
    **_units("N", N=1.0, mN=1e-3, kN=1e3),
    **_units("N m", Nm=1.0, mNm=1e-3),
    "N m": Unit(factor=1.0, dimension="N m"),
    "mN m": Unit(factor=1e-3, dimension="N m"),
    "N cm": Unit(factor=1e-2, dimension="N m"),
    **_units("A", A=1.0, mA=1e-3),
    **_units("V", V=1.0, mV=1e-3),
    **_units("kg", kg=1.0),
    **_units("degC", degC=1.0),
    **_units("rad/s", **dict.fromkeys(("rpm", "1/min", "rev/min"), 2.0 * math.pi / 60.0)),
    # Standard gravity is exactly 9.80665 m/s2 (BIPM, The International System of Units, 2019).
    "g": Unit(factor=9.80665, dimension="m/s2"),
    "1": Unit(factor=1.0, dimension="1"),
    "%": Unit(factor=1e-2, dimension="1"),
}
"""Every unit by the symbol that a `recording.toml` may name; `g` is gravity, not the gram."""


def unit(symbol: str, *, where: str) -> Unit:
    """Return a unit by its symbol.

    Args:
        symbol: As written in the binding.
        where: File and line, for the error.

    Raises:
        RecordingError: The unit is unknown.
    """
    if symbol not in UNITS:
        raise RecordingError(
            f"the unit {symbol!r} is unknown; there are {', '.join(UNITS)}",
            where=where,
            fix=f"the nearest are {nearest(symbol, UNITS)}; or convert with scale and offset",
        )
    return UNITS[symbol]
