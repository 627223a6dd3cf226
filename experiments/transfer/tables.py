"""What many cases of transfer say together: success, trials, harm, time, and figure 8."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from rich.table import Table
from scipy.stats import trim_mean

from morph.arrays import JSON, Array

SURE = 0.95
"""Share of judging runs that reach every goal in a policy that counts as successful."""

NEAR = 1.1
"""Within how much of the target's own optimum a loss must be to count as near."""

SOLVABLE = 0.5
"""Share of judging runs that the target's own plan must reach for a target to count as solvable."""

BOOTSTRAPS = 2000
"""Draws of an interval."""

COLOURS = {
    "loop": "#1f6f8b",
    "adjusted": "#d9822b",
    "unadjusted": "#8a8f98",
    "own plan": "#2a9d5c",
}
"""Of each arm in figure 8."""

TITLE = "Loss on the target by trial (IQM, 95 % interval); dotted: the source's own"

Grouped = dict[str, dict[str, list[JSON]]]


def grouped(lines: Sequence[JSON]) -> Grouped:
    """Return the lines by case, and then by who tried."""
    found: Grouped = defaultdict(lambda: defaultdict(list))
    for line in lines:
        if "why" not in line["lines"][0]:
            found[line["case"]][line["arm"]].append(line)
    return found


def iqm(values: Sequence[float]) -> tuple[float, float, float]:
    """Return the interquartile mean, and a 95 % interval by bootstrap.

    Source: Agarwal and others 2021, Deep RL at the edge of the statistical precipice.
    """
    data = np.asarray(values, dtype=float)
    rng = np.random.default_rng(0)
    drawn = rng.choice(data, size=(BOOTSTRAPS, len(data)))
    means = trim_mean(drawn, 0.25, axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return float(trim_mean(data, 0.25)), float(low), float(high)


def own_loss(arms: dict[str, list[JSON]]) -> float:
    """Return the least loss of plans on the true body, or of any policy that did better."""
    lines = [each for arm in arms.values() for line in arm for each in line["lines"]]
    return min((each["loss"] for each in lines if each["success"] >= SURE), default=math.inf)


def solvable(arms: dict[str, list[JSON]]) -> bool:
    """Return whether a plan on the true body reaches the goals, or any policy does."""
    lines = [each for arm in arms.values() for line in arm for each in line["lines"]]
    return max((each["success"] for each in lines), default=0.0) >= SOLVABLE


def trials_to(line: JSON, loss: float) -> float:
    """Return how many trials it took until a policy was this good; infinite if none was."""
    tried = [each for each in line["lines"] if each.get("origin") != "kept"]
    for number, each in enumerate(tried, start=1):
        if each["loss"] <= loss:
            return number
    return math.inf


def summary(lines: Sequence[JSON]) -> Table:
    """Return a table with a row for each case and arm."""
    table = Table(title="Success by 64 judging runs each; losses as interquartile means")
    for name in ("case", "who", "seeds", "trial 2 reached", "policies sure", "oracle sure"):
        table.add_column(name)
    for name in ("loss", "95 %", "oracle's loss"):
        table.add_column(name)
    table.add_column("trials to 10 % of own optimum")
    table.add_column("s to transfer")
    for case, arms in grouped(lines).items():
        best = own_loss(arms)
        said = case if solvable(arms) else f"{case} (beyond its own plan)"
        oracle = [each["lines"][-1] for each in arms.get("own plan", ())]
        sure = f"{sum(each['success'] >= SURE for each in oracle)}/{len(oracle)}"
        optimum = f"{iqm([each['loss'] for each in oracle])[0]:.2f}" if oracle else "-"
        for arm, tried in arms.items():
            last = [each["lines"][-1] for each in tried]
            mean, low, high = iqm([each["loss"] for each in last])
            second = [each["lines"][1] for each in tried if len(each["lines"]) > 1]
            reached = [each["reached"] for each in second if "reached" in each]
            count = [trials_to(each, NEAR * best) for each in tried]
            spent = [each["lines"][0].get("seconds") for each in tried]
            timed = [each for each in spent if each]
            table.add_row(
                said,
                arm,
                str(len(tried)),
                f"{sum(reached)}/{len(reached)}" if reached else "-",
                f"{sum(each['success'] >= SURE for each in last)}/{len(last)}",
                sure if oracle else "-",
                f"{mean:.2f}",
                f"{low:.2f} to {high:.2f}",
                optimum,
                f"{np.median(count):g}",
                f"{np.median(timed):.1f}, {max(timed):.1f}" if timed else "-",
            )
            said = ""
    return table


def missed(lines: Sequence[JSON]) -> list[JSON]:
    """Return every case and seed in which a plan on the true body works and the loop's does not.

    A policy works surely if it reaches the goals in `SURE` of the judging runs, and hardly if it
    does in `SOLVABLE` of them; the loop misses a case if it stays below one that the plan reaches.
    """
    found = []
    for case, arms in grouped(lines).items():
        loops = {line["seed"]: line["lines"][-1] for line in arms.get("loop", ())}
        for line in arms.get("own plan", ()):
            best, ours = line["lines"][-1], loops.get(line["seed"])
            if ours is not None and any(
                ours["success"] < level <= best["success"] for level in (SOLVABLE, SURE)
            ):
                found.append(
                    {
                        "case": case,
                        "seed": line["seed"],
                        "loop_success": ours["success"],
                        "loop_loss": ours["loss"],
                        "oracle_success": best["success"],
                        "oracle_loss": best["loss"],
                    }
                )
    return found


def compared(lines: Sequence[JSON]) -> int:
    """Return in how many cases and seeds both the loop and a plan on the true body were run."""
    return sum(
        len({line["seed"] for line in arms["loop"]} & {line["seed"] for line in arms["own plan"]})
        for arms in grouped(lines).values()
        if "loop" in arms and "own plan" in arms
    )


def gains_of(lines: Sequence[JSON], arm: str) -> list[tuple[float, float]]:
    """Return by how much an arm's policy costs more than the source's, and in standard errors."""
    before = {
        (line["case"], line["seed"]): line["lines"][0]
        for line in lines
        if line["arm"] == "unadjusted" and "why" not in line["lines"][0]
    }
    return [
        _gain(before[line["case"], line["seed"]], line["lines"][-1])
        for line in lines
        if line["arm"] == arm
        and "why" not in line["lines"][0]
        and (line["case"], line["seed"]) in before
    ]


def harm(lines: Sequence[JSON]) -> Table:
    """Return a table of how often the loop ended worse than the policy that it began with."""
    table = Table(title="Harm: the policy kept against the source's, three standard errors")
    for name in ("who", "cases", "better", "alike", "worse", "worst"):
        table.add_column(name)
    for arm in ("loop", "adjusted"):
        found = gains_of(lines, arm)
        if found:
            score = np.array(found)
            table.add_row(
                arm,
                str(len(score)),
                str(int((score[:, 1] < -3.0).sum())),
                str(int((np.abs(score[:, 1]) <= 3.0).sum())),
                str(int((score[:, 1] > 3.0).sum())),
                f"{score[:, 0].max():+.2f}",
            )
    return table


def _gain(first: JSON, last: JSON) -> tuple[float, float]:
    """Return how much loss was added, and that in standard errors of the difference."""
    added = last["loss"] - first["loss"]
    error = math.hypot(last["error"], first["error"])
    return added, 0.0 if added == 0.0 else added / max(error, 1e-9)


def figure8(lines: Sequence[JSON]) -> str:
    """Return figure 8 as a page: losses over trials, a panel for each parameter and factor."""
    import plotly.graph_objects as graph
    from plotly.subplots import make_subplots

    cases = {name: arms for name, arms in grouped(lines).items() if " x" in name}
    names = sorted({_figure(name) for name in cases})
    factors = sorted({_factor(name) for name in cases})
    page = make_subplots(
        rows=len(names),
        cols=len(factors),
        shared_yaxes=True,
        subplot_titles=[f"{name} x{factor:g}" for name in names for factor in factors],
    )
    source = [line["lines"][0]["loss"] for line in lines if line["case"].endswith("unchanged")]
    for name, arms in cases.items():
        row, column = 1 + names.index(_figure(name)), 1 + factors.index(_factor(name))
        for arm, tried in arms.items():
            mean, low, high = np.array([iqm(each) for each in _by_trial(tried)]).T
            number = np.arange(1.0, len(mean) + 1)
            shown = {"row": row, "col": column}
            page.add_trace(_band(graph, number, low, high, COLOURS[arm]), **shown)
            drawn = _line(graph, number, mean, arm, first=row + column == 2)
            page.add_trace(drawn, **shown)
        if source:
            page.add_hline(y=float(trim_mean(source, 0.25)), line_dash="dot", row=row, col=column)
    page.update_yaxes(range=[0, 65])
    page.update_xaxes(dtick=1, range=[0.8, 5.2])
    page.update_layout(
        height=210 * len(names) + 120,
        title=TITLE,
        template="plotly_white",
    )
    return str(page.to_html(include_plotlyjs="cdn"))


def _by_trial(tried: Sequence[JSON], most: int = 5) -> list[list[float]]:
    """Return the losses of each trial; a policy that was kept goes on as it was."""
    rows = []
    for line in tried:
        losses = [each["loss"] for each in line["lines"] if each.get("origin") != "kept"]
        rows.append((losses + [line["lines"][-1]["loss"]] * most)[:most])
    return [list(column) for column in zip(*rows, strict=True)]


def _band(graph: object, number: Array, low: Array, high: Array, colour: str) -> object:
    x = np.concatenate([number, number[::-1]])
    return graph.Scatter(  # type: ignore[attr-defined]
        x=x,
        y=np.concatenate([high, low[::-1]]),
        fill="toself",
        line={"width": 0},
        fillcolor=colour,
        opacity=0.25,
        showlegend=False,
        hoverinfo="skip",
    )


def _line(graph: object, number: Array, mean: Array, arm: str, *, first: bool) -> object:
    return graph.Scatter(  # type: ignore[attr-defined]
        x=number,
        y=mean,
        name=arm,
        mode="lines+markers",
        line={"color": COLOURS[arm]},
        showlegend=first,
    )


def _figure(name: str) -> str:
    return name.partition(": ")[2].partition(" x")[0]


def _factor(name: str) -> float:
    return float(name.partition(" x")[2])
