"""A design's figures as tables, beside those of the body as described."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from morph.app.viewer.content import CellTable
from morph.app.viewer.design.design_state import Bench
from morph.app.viewer.design.measure import Measures
from morph.arrays import Array
from morph.body.holding import least, margins

SHOWN = 6
"""Motors that are listed, those with the least left first."""

NOTHING = 1e-9
"""N m or N; less is what rounding leaves."""

PENDING = "…"
"""Stands for a figure that is being computed."""

NONE = "–"
"""Stands for a figure that there is not."""


def headline(bench: Bench, measures: Measures | None, original: Measures | None) -> str:
    """Return what changed most to a designer's eye, in one line of plain text."""
    before = bench.plan.robot.mass
    mass = bench.built.robot.mass
    lines = [f"{mass:.4g} kg{_against(mass, before)}"]
    if measures is not None and original is not None:
        change = _against(measures.reach, original.reach)
        lines.append(f"reach {measures.reach:.3g} m{change}")
    left, worst = least(bench.efforts(), bench.limits)
    if left is not None and worst is not None:
        lines.append(f"margin {_share(left)} ({bench.motors[worst].name})")
    return " · ".join(lines)


def figures(bench: Bench, measures: Measures | None, original: Measures | None) -> CellTable:
    """Return mass, reach, margins and size, beside those of the original.

    Args:
        bench: The design.
        measures: Its figures; None while they are being computed.
        original: Those of the body as described; None likewise.
    """
    mass, before = bench.built.robot.mass, bench.plan.robot.mass
    left, worst = least(bench.efforts(), bench.limits)
    rows = [
        ("mass (kg)", f"{mass:.4g}", f"{before:.4g}", _change(mass, before)),
        _row("reach (m)", [None if each is None else each.reach for each in (measures, original)]),
        ("margin here", _margin(bench, left, worst), "", ""),
        (
            f"margin, worst of {measures.poses if measures else PENDING} poses",
            *(_worst(each) for each in (measures, original)),
            _points(measures, original),
        ),
    ]
    for at, axis in enumerate("xyz"):
        both = [None if each is None else each.size[at] for each in (measures, original)]
        rows.append(_row(f"size {axis} (m)", both))
    for name, key in (("joints", "joints"), ("degrees of freedom", "freedoms")):
        now, was = (PENDING if m is None else str(getattr(m, key)) for m in (measures, original))
        rows.append((name, now, was, ""))
    return CellTable(title="Figures", head=("", "now", "as described", "change"), rows=tuple(rows))


def motors(bench: Bench, measures: Measures | None) -> CellTable:
    """Return what the motors hold that have the least left, here and at worst."""
    here = bench.efforts()
    worst = measures.efforts if measures is not None else np.full(len(here), np.nan)
    left = margins(np.fmax(np.abs(here), worst), bench.limits)
    order = np.argsort(np.where(np.isfinite(left), left, np.inf), kind="stable")[:SHOWN]
    rows = tuple(
        (
            bench.motors[at].name,
            _effort(here[at]),
            PENDING if measures is None else _effort(worst[at]),
            NONE if math.isnan(bench.limits[at]) else f"{bench.limits[at]:.3g}",
            NONE if math.isnan(left[at]) else _share(float(left[at])),
        )
        for at in order.tolist()
    )
    more = len(here) - len(rows)
    title = "Motors, the most loaded first" + (f"; {more} more have more left" if more else "")
    return CellTable(
        title=title, head=("N m (slides: N)", "here", "worst", "limit", "left"), rows=rows
    )


def _row(name: str, both: Sequence[float | None]) -> tuple[str, str, str, str]:
    now, was = both
    change = "" if now is None or was is None else _change(now, was)
    lines = [PENDING if each is None else f"{each:.3g}" for each in both]
    return name, lines[0], lines[1], change


def _change(now: float, was: float) -> str:
    if abs(now - was) <= 1e-9 * max(abs(now), abs(was)):
        return "="
    return f"{100.0 * (now / was - 1.0):+.1f} %" if was else f"{now - was:+.3g}"


def _against(now: float, was: float) -> str:
    change = _change(now, was)
    return "" if change == "=" else f" ({change})"


def _told(left: float, name: str) -> str:
    # A narrow column may break a name after its underscores.
    return f"{_share(left)} {name}".replace("_", "_\u200b")


def _effort(value: float) -> str:
    # What rounding leaves of nothing is nothing.
    return f"{abs(value):.3g}" if abs(value) > NOTHING else "0"


def _share(left: float) -> str:
    return f"{100.0 * left:.0f} %"


def _margin(bench: Bench, left: float | None, worst: int | None) -> str:
    return NONE if left is None or worst is None else _told(left, bench.motors[worst].name)


def _worst(measures: Measures | None) -> str:
    if measures is None:
        return PENDING
    left, worst = least(measures.efforts, measures.limits)
    if left is None or worst is None:
        return NONE
    return _told(left, measures.motors[worst].name)


def _points(measures: Measures | None, original: Measures | None) -> str:
    if measures is None or original is None:
        return ""
    now, was = measures.margin, original.margin
    if now is None or was is None:
        return ""
    return "=" if abs(now - was) < 1e-9 else f"{100.0 * (now - was):+.0f} points"


def limits_note(values: Array) -> str:
    """Return the sentence that says what margins are."""
    known = int(np.isfinite(values).sum())
    return (
        "A margin is the share of a motor's limit that is left when the body stands still, in "
        "air, its base held and nothing touched: gravity and springs alone. "
        f"{known} of {len(values)} motors have a known limit."
    )
