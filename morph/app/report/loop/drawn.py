"""What the page of a loop draws: the losses of its trials, and what each model foresees of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.app.report.learn.plots import Plot, PlottedLine
from morph.app.report.loop.outcome import LoopOutcome
from morph.arrays import Array
from morph.errors import SimulationFailed
from morph.search.target import Experience
from morph.sim.closed_loop import closed_loop
from morph.sim.simulator import Simulator

WINDOW = 0.5
"""Seconds after which a prediction begins anew."""

MOST_PLOTS = 6
"""Joints that are drawn of each trial."""


@dataclass(frozen=True, kw_only=True)
class TrialPrediction:
    """One joint in one trial, and how far each model errs there."""

    plot: Plot
    """Observed, and predicted by each model."""
    described: float | None
    """Root mean square error of the model as described; None if it cannot run."""
    repaired: float | None
    """The same of the repaired model; None if there is none."""
    unit: str
    """Of both."""


def losses(outcome: LoopOutcome) -> tuple[Plot, ...]:
    """Return the loss of each trial, beside what it is to be compared with."""
    if not outcome.rounds:
        return ()
    loss = np.array([run.loss for run in outcome.runs])
    rules = [] if outcome.own is None else [(outcome.own, "source at home")]
    if outcome.judged is not None:
        rules.append((outcome.judged.still.mean, "holding still"))
        if outcome.judged.oracle is not None:
            rules.append((outcome.judged.oracle.mean, "oracle"))
    number = np.arange(1.0, len(loss) + 1.0)
    return (
        Plot(
            title="loss of each trial",
            x_title="trial",
            lines=(PlottedLine(x=number, y=loss, dots=True),),
            rules=tuple(rules),
            counted=True,
        ),
    )


def true_states(outcome: LoopOutcome, number: int) -> Array:
    """Return the states of a run that are taken for the true ones, shape (samples, nq + nv).

    Those that the repaired model makes of it, or else the observed ones. From noisy ones
    a body that balances would part from any prediction.

    Args:
        outcome: What was found.
        number: Which run, counted from 0.
    """
    run = outcome.runs[number]
    if outcome.repair is not None:
        states = outcome.repair.explained.inferred.states
        # A repair goes by the latest runs.
        at = number - (len(outcome.runs) - len(states))
        if at >= 0 and len(states[at]) == len(run.position):
            return states[at]
    return np.concatenate([run.position, run.velocity], axis=1)


def foretold(outcome: LoopOutcome, number: int) -> tuple[TrialPrediction, ...]:
    """Return every joint of a run as observed and as each model predicts it."""
    task, run, states = outcome.task, outcome.runs[number], true_states(outcome, number)
    described = task.simulator()
    before = predicted(described, run, states)
    after = None
    if outcome.repair is not None:
        after = predicted(outcome.repair.model.simulator, run, states)
    model: Any = described.model
    results: list[TrialPrediction] = []
    for joint in task.robot.joints:
        if joint.kind not in {"hinge", "slide"} or len(results) == MOST_PLOTS:
            continue
        at = int(model.joint(joint.name).qposadr[0])
        results.append(_joint(run, at, (before, after), f"{joint.name}, {joint.unit}", joint.unit))
    return tuple(results)


def _joint(
    run: Experience, at: int, models: Sequence[Array | None], title: str, unit: str
) -> TrialPrediction:
    time: Array = run.period * np.arange(len(run.position), dtype=np.float64)
    seen = run.position[:, at]
    lines = [PlottedLine(x=time, y=seen, look="observed")]
    errors: list[float | None] = []
    for look, states in zip(("described", "main"), models, strict=True):
        if states is None:
            errors.append(None)
            continue
        # A gap after each window: what follows begins anew.
        x, y = _gapped(time, states[..., at])
        lines.append(PlottedLine(x=x, y=y, look=look))
        errors.append(_error(states[..., at], seen))
    low, high = seen.min(), seen.max()
    room = max(0.5 * (high - low), 1e-3)
    kept = tuple(_within(line, low - room, high + room) for line in lines)
    described, repaired = errors
    return TrialPrediction(
        plot=Plot(title=title, x_title="time, s", lines=kept),
        described=described,
        repaired=repaired,
        unit=unit,
    )


def _within(line: PlottedLine, low: float, high: float) -> PlottedLine:
    """Return a line without what is far beyond what was observed: it would flatten the rest."""
    inside = (line.y >= low) & (line.y <= high)
    return PlottedLine(x=line.x, y=np.where(inside, line.y, np.nan), look=line.look, dots=line.dots)


def _gapped(time: Array, windows: Array) -> tuple[Array, Array]:
    count, length = windows.shape
    x, y = [], []
    for row in range(count):
        first = row * (length - 1)
        span = time[first : first + length]
        x += [*span, np.nan]
        y += [*windows[row, : len(span)], np.nan]
    return np.array(x), np.array(y)


def _error(windows: Array, seen: Array) -> float:
    """Return the root mean square of what predictions are off by, their starts left out."""
    count, length = windows.shape
    off = [
        windows[row, at] - seen[row * (length - 1) + at]
        for row in range(count)
        for at in range(1, length)
        if row * (length - 1) + at < len(seen)
    ]
    return float(np.sqrt(np.mean(np.square(off))))


def predicted(
    simulator: Simulator, run: Experience, states: Array, window: float = WINDOW
) -> Array | None:
    """Return where a model says that a run goes, anew from a known state each window.

    What an effect remembers, such as a command on its way, is forgotten where a window begins.

    Args:
        simulator: The model.
        run: Its commands.
        states: Where it was, shape (samples, nq + nv).
        window: Length of each prediction, s.

    Returns:
        Positions, shape (windows, periods + 1, nq); beyond the end of the run the last command is
        held. None if the model cannot run from there.
    """
    length = min(max(1, round(window / run.period)), len(run.command))
    starts = np.arange(0, len(run.command), length)

    def act(q: Array, v: Array, time: float) -> Array:
        return run.command[np.minimum(starts + round(time / run.period), len(run.command) - 1)]

    try:
        loop = closed_loop(
            simulator,
            act,
            states[starts, : run.position.shape[1]],
            states[starts, run.position.shape[1] :],
            period=run.period,
            seconds=length * run.period,
        )
    except SimulationFailed:
        return None
    return np.where(loop.stable[:, None, None], loop.position, np.nan)
