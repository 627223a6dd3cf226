"""The cost of the fluid against the number of bodies: is it a straight line, and its picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import JSON, Array


def straightness(bodies: Sequence[int], seconds: Array) -> float:
    """Return how far times lie from their best line, at most, as a part of their range."""
    line = np.polyval(np.polyfit(bodies, seconds, 1), bodies)
    return float(np.abs(seconds - line).max() / np.ptp(seconds))


def drawn(links: JSON) -> str:
    """Return a page with the time of a step against the number of links, dry and wet."""
    # Loads a library that only the picture needs.
    import plotly.graph_objects as go

    figure = go.Figure()
    for name, key, colour in (("in water", "wet_s", "#1f6f8b"), ("dry", "dry_s", "#9a9a9a")):
        times = 1e6 * np.array(links[key])
        figure.add_scatter(
            x=links["bodies"], y=times, name=name, mode="lines+markers", line={"color": colour}
        )
    figure.update_layout(
        title="A floating body with limbs of three links: time of a step of 5 ms, one core",
        xaxis_title="links",
        yaxis_title="microseconds a step",
        template="plotly_white",
        font={"size": 15},
    )
    return str(figure.to_html(include_plotlyjs=True, full_html=True))
