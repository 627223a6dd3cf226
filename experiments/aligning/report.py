"""Tables of manifold alignment on bodies of the shelf, and its sweep as a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table

from experiments.aligning.ways import FAMILY, GOAL, RIDGE
from morph.arrays import JSON


def pair_table(line: JSON) -> Table:
    """Return the scores of every way on one pair of bodies."""
    title = f"{line['source']} > {line['target']}, {line['level']:g} landmarks"
    table = Table(title=f"{title}, {line['seeds']} seeds")
    for name in ("way", "score [95 %]", "solved", "refused", "agreement", "over shuffled",
                 "over landmarks alone"):  # fmt: skip
        table.add_column(name)
    for name, way in line["ways"].items():
        gain, more = (
            f"{way[each][0]:+.2f} [{way[each][1]:.2f}, {way[each][2]:.2f}]" if each in way else ""
            for each in ("gain", "more")
        )
        score = way["score"]
        agreed = f"{way['agreement']:.2f}" if "agreement" in way else ""
        table.add_row(name, f"{score[0]:.2f} [{score[1]:.2f}, {score[2]:.2f}]",
                      f"{way['solved']:.2f}", str(way["refused"]), agreed, gain, more)  # fmt: skip
    return table


def against_ridge(lines: Sequence[JSON]) -> Table:
    """Return the scores of each method beside those of ridge on the same landmarks.

    A star: surely above ridge; a cross: surely below it, by the 95 % interval over seeds.
    """
    table = Table(title="score beside ridge on the same landmarks (* surely above, x below)")
    names = [each.name for each in FAMILY]
    for title in ("bodies", "ridge", *names, "shuffled at best", "no source", "oracle"):
        table.add_column(title)
    for line in lines:
        if line["source"] == "formula":
            continue
        ways = line["ways"]
        cells = []
        for name in names:
            _, low, high = ways[name]["more"]
            mark = "*" if low > 0.0 else "x" if high < 0.0 else ""
            cells.append(f"{ways[name]['score'][0]:.2f}{mark}")
        shuffled = max(ways[f"{name}, shuffled"]["score"][0] for name in names)
        table.add_row(
            f"{line['source']} > {line['target']} ({line['level']:g})",
            f"{ways[RIDGE]['score'][0]:.2f}",
            *cells,
            f"{shuffled:.2f}",
            *(f"{ways[name]['score'][0]:.2f}" for name in ("no source", "oracle")),
        )
    return table


def drawn(lines: Sequence[JSON]) -> str:
    """Return the sweep as a page: score against what changes, one panel each."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    sweep = [line for line in lines if line["source"] == "formula"]
    factors = list(dict.fromkeys(line["target"] for line in sweep))
    figure = make_subplots(rows=1, cols=max(len(factors), 1), subplot_titles=factors)
    names = (*GOAL, RIDGE, "manifold, shuffled", "manifold_free", "features")
    colours = ("#0072b2", "#009e73", "#d55e00", "#999999", "#000000", "#cc79a7", "#e69f00")
    for at, factor in enumerate(factors, start=1):
        mine = sorted((ln for ln in sweep if ln["target"] == factor), key=lambda ln: ln["level"])
        for name, colour in zip(names, colours, strict=True):
            score = np.array([line["ways"][name]["score"] for line in mine])
            figure.add_trace(
                go.Scatter(
                    x=[str(line["level"]) for line in mine],
                    y=score[:, 0],
                    error_y={"array": score[:, 2] - score[:, 0],
                             "arrayminus": score[:, 0] - score[:, 1]},
                    name=name, legendgroup=name, showlegend=at == 1, line={"color": colour},
                ), row=1, col=at,
            )  # fmt: skip
    figure.update_yaxes(range=[0, 1.05], title_text="score", col=1)
    figure.update_layout(title="Where two bodies share a manifold, and where not", height=480)
    return str(figure.to_html(include_plotlyjs=True, full_html=True))
