"""What the page of a transfer draws: learning curves beside their controls."""

from __future__ import annotations

import numpy as np

from morph.app.report.learn.plots import Plot, PlottedLine
from morph.app.report.transfer.words import NAMED
from morph.policy_transfer.hop_result import Crossing, Curve
from morph.policy_transfer.relay_record import RelayRecord

LOOKS = {
    "transfer": "main",
    "no_source": "alone",
    "scratch": "scratch",
    "shuffled": "shuffled",
    "flipped": "flipped",
}
"""The class of each curve on the page."""

FAR = 3
"""So many times the transfer's own transitions are drawn at most."""

APART = 0.012
"""By how much the intervals of two curves are shifted, of the width, so that both are seen."""


def curves(hop: Crossing) -> tuple[Plot, ...]:
    """Return the learning curves of a hop, as shares of what the oracle gains."""
    shown = shown_of(hop)
    if not shown or hop.scores["oracle"] is None:
        return ()
    width = max(max(each.samples) for each in shown)
    lines: list[PlottedLine] = []
    # The transfer's own curve is drawn last, on top.
    for place, each in enumerate(reversed(shown)):
        lines += _lines(hop, each, APART * width * (place - 0.5 * (len(shown) - 1)))
    return (
        Plot(
            title="score by transitions of the target",
            x_title="transitions",
            lines=tuple(lines),
            rules=((0.0, "holding still"), (1.0, "oracle")),
            from_zero=True,
        ),
    )


def shown_of(hop: Crossing) -> list[Curve]:
    """Return the curves that fit on the axis of the transfer's own.

    Learning from scratch takes hundreds of times as many transitions: it is told in words.
    """
    ours = [each.samples[-1] for each in hop.curves if each.name == "transfer"]
    most = FAR * max(ours, default=0)
    return [each for each in hop.curves if each.name in LOOKS and each.samples[-1] <= most]


def _lines(hop: Crossing, curve: Curve, shift: float) -> list[PlottedLine]:
    at = np.array(curve.samples, dtype=float) + shift
    low, high = (hop.relative(each) for each in curve.interval)
    gap = np.full(len(at), np.nan)
    whiskers = PlottedLine(
        x=np.stack([at, at, gap], axis=1).ravel(),
        y=np.stack([low, high, gap], axis=1).ravel(),
        look=f"{LOOKS[curve.name]} whisker",
    )
    y = hop.relative(curve.mean)
    dots = curve.name == "transfer"
    return [whiskers, PlottedLine(x=at, y=y, look=LOOKS[curve.name], dots=dots)]


def key(record: RelayRecord) -> list[tuple[str, str]]:
    """Return the class and the name of every curve that is drawn."""
    there = {each.name for hop in record.hops for each in shown_of(hop)}
    return [(look, NAMED[name]) for name, look in LOOKS.items() if name in there]


def kept(record: RelayRecord) -> tuple[Plot, ...]:
    """Return what is kept along the chain, hop after hop; none for a single hop."""
    if len(record.hops) < 2:
        return ()
    number = np.arange(1.0, len(record.hops) + 1.0)
    named = (("zero_shot", "described"), ("final", "main"))
    lines = tuple(
        PlottedLine(
            x=number,
            y=np.array([np.nan if (s := h.scores[name]) is None else s for h in record.hops]),
            look=look,
            dots=name == "final",
        )
        for name, look in named
    )
    rules = ((0.0, "holding still"), (1.0, "oracle"))
    return (Plot(title="score at each hop", x_title="hop", lines=lines, rules=rules, counted=True),)
