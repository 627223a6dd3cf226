"""The arrows of a map as SVG: which part of one body is which of another, without a script."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup, escape

from morph.policy_transfer.parts import Arrow, Parts

ROW, HEAD = 23.0, 22.0
"""Height of a row and of the titles, in units of the drawing; the page scales it."""

SPAN = 130.0
"""Over which the arrows run; names stand beyond."""

LETTER = 6.6
"""Width of a letter of a name, about."""

GAP = 8.0
"""Between a name and its arrows."""

SCALE = 1.2
"""Most pixels to a unit of the drawing."""

LETTERS = 23
"""Of a name that are shown; the whole of it is shown where the pointer rests."""

TIP = 7.0
"""Length of an arrow's tip."""


def drawn(parts: Parts, source: str, target: str) -> tuple[tuple[str, Markup], ...]:
    """Return the arrows of the states and of the commands, each with its title.

    Args:
        parts: The arrows.
        source: What the source is called; it stands on the left.
        target: What the target is called.
    """
    states = tuple(_turned(each) for each in parts.states)
    results = (
        (f"states of {target} as those of {source}", _svg(states, source, target, leftward=True)),
        (
            f"commands of {target} as those of {source}",
            _svg(parts.commands, source, target, leftward=False),
        ),
    )
    arrows = (parts.states, parts.commands)
    return tuple(each for each, there in zip(results, arrows, strict=True) if there)


def _turned(arrow: Arrow) -> Arrow:
    """Return an arrow the other way round: the source stands on the left, whichever way it goes."""
    return Arrow(begin=arrow.end, end=arrow.begin, weight=arrow.weight)


def _svg(arrows: Sequence[Arrow], source: str, target: str, *, leftward: bool) -> Markup:
    left = list(dict.fromkeys(arrow.begin for arrow in arrows))
    right = _ordered(arrows, left)
    a, c = _room([source, *left]), _room([target, *right])
    b, rows = a + SPAN, max(len(left), len(right))
    width, height, middle = b + c, HEAD + ROW * rows + 4.0, HEAD + 0.5 * ROW * rows
    at = {("l", name): middle + ROW * (k + 0.5 - 0.5 * len(left)) for k, name in enumerate(left)}
    at |= {("r", name): middle + ROW * (k + 0.5 - 0.5 * len(right)) for k, name in enumerate(right)}
    parts = [
        _text(a - GAP, 12.0, source, "end", "whose"),
        _text(b + GAP, 12.0, target, "start", "whose"),
    ]
    # The weak first, so that the strong lie on top.
    for arrow in sorted(arrows, key=lambda each: abs(each.weight)):
        ends = at[("l", arrow.begin)], at[("r", arrow.end)]
        parts.append(_line(arrow, (a, b), ends, leftward=leftward))
    parts += [_text(a - GAP, at[("l", name)] + 4.0, name, "end", "part") for name in left]
    parts += [_text(b + GAP, at[("r", name)] + 4.0, name, "start", "part") for name in right]
    whole = [_turned(arrow) if leftward else arrow for arrow in arrows]
    spoken = escape("; ".join(told(arrow) for arrow in whole))
    return Markup(
        f'<svg class="arrows" style="max-width:{SCALE * width:.0f}px" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" role="img" '
        f'aria-label="{spoken}">{"".join(parts)}</svg>'
    )


def _room(names: Sequence[str]) -> float:
    """Return how much room names take."""
    return LETTER * max(min(len(name), LETTERS) for name in names) + GAP + 4.0


def _ordered(arrows: Sequence[Arrow], left: Sequence[str]) -> list[str]:
    """Return the names on the right so that few arrows cross: each near what it is tied to."""
    names = list(dict.fromkeys(arrow.end for arrow in arrows))

    def height(name: str) -> float:
        tied = [(left.index(a.begin), abs(a.weight)) for a in arrows if a.end == name]
        return sum(place * weight for place, weight in tied) / sum(weight for _, weight in tied)

    return sorted(names, key=height)


def _line(arrow: Arrow, x: tuple[float, float], y: tuple[float, float], *, leftward: bool) -> str:
    (left, right), (begin, end) = x, y
    thick = 1.0 + 4.0 * abs(arrow.weight)
    look = "plus" if arrow.weight > 0.0 else "minus"
    whole = _turned(arrow) if leftward else arrow
    a, b = (left + TIP, right) if leftward else (left, right - TIP)
    bend = 0.5 * (a + b)
    tip, foot = (left, left + TIP + 1.0) if leftward else (right, right - TIP - 1.0)
    point = begin if leftward else end
    half = 2.2 + 0.6 * thick
    return (
        f'<g class="{look}"><title>{escape(told(whole))}</title>'
        f'<path d="M{a:.1f} {begin:.1f}C{bend:.1f} {begin:.1f} {bend:.1f} {end:.1f} '
        f'{b:.1f} {end:.1f}" stroke-width="{thick:.1f}"/>'
        f'<polygon points="{tip:.1f},{point:.1f} {foot:.1f},{point - half:.1f} '
        f'{foot:.1f},{point + half:.1f}"/></g>'
    )


def _text(x: float, y: float, name: str, anchor: str, look: str) -> str:
    short = name if len(name) <= LETTERS else f"{name[: LETTERS - 1]}\N{HORIZONTAL ELLIPSIS}"
    whole = "" if short == name else f"<title>{escape(name)}</title>"
    return (
        f'<text class="{look}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f"{whole}{escape(short)}</text>"
    )


def told(arrow: Arrow) -> str:
    """Return an arrow in words: its two ends, its sign and its share."""
    sign = "turned round, " if arrow.weight < 0.0 else ""
    return f"{arrow.begin} to {arrow.end}: {sign}{100.0 * abs(arrow.weight):.0f} %"
