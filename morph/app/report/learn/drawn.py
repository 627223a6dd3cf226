"""What the page draws: the learning curve, and what joints and commands do in the judged runs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from morph.app.report.learn.outcome import LearnOutcome
from morph.app.report.learn.plots import GoalBand, Plot, PlottedLine
from morph.app.report.learn.words import NAMED
from morph.arrays import Array
from morph.body.robot import Joint
from morph.policy.policy import UNLIMITED, actions_of
from morph.record.quantities import XYZ
from morph.task.quantity import AngleSum, JointPositions

MOST_RUNS = 12
"""Runs that are drawn faintly behind the typical one."""

MOST_PLOTS = 12
"""Joints that are drawn, and commands."""


def learning(outcome: LearnOutcome) -> tuple[Plot, ...]:
    """Return the loss against the trial, the experience, where there is any, and the seconds."""
    trials = outcome.trials
    if not trials:
        return ()
    loss = np.array([trial.loss for trial in trials])
    rules = [(float(outcome.judged.loss.mean()), "judged")]
    rules += [
        (score.mean, NAMED.get(name, name))
        for name, score in outcome.judged.controls.items()
        if name == "nothing"
    ]
    by = {
        "trial" if outcome.experience > 0.0 else "round": [trial.number for trial in trials],
        "experience, s": [trial.experience for trial in trials],
        "seconds": [trial.seconds for trial in trials],
    }
    return tuple(
        Plot(
            title="loss",
            x_title=title,
            lines=(PlottedLine(x=np.array(x, dtype=float), y=loss, dots=len(loss) <= 40),),
            rules=tuple(rules),
            from_zero=True,
        )
        for title, x in by.items()
        if title != "experience, s" or outcome.experience > 0.0
    )


def joints(outcome: LearnOutcome) -> tuple[Plot, ...]:
    """Return where each joint is in the judged runs, with its range and what is to be reached."""
    model = outcome.judged.moved.model
    plots = []
    for joint in outcome.task.robot.joints:
        first = int(model.joint(joint.name).qposadr[0])
        if joint.kind in {"hinge", "slide"}:
            title = f"{joint.name}, {joint.unit}"
            bands = tuple(_bands(outcome, joint, first))
            plots.append(_plot(outcome, first, title, joint.limits or (), bands))
        elif joint.kind == "free":
            plots += [
                _plot(outcome, first + at, f"{joint.link} {axis}, m") for at, axis in enumerate(XYZ)
            ]
    return tuple(plots)


def commands(outcome: LearnOutcome) -> tuple[Plot, ...]:
    """Return what each actuator is told in the judged runs, with its bounds."""
    judged = outcome.judged
    plots = []
    for at, action in enumerate(actions_of(outcome.task.robot)):
        bounds = tuple(each for each in (action.low, action.high) if abs(each) < UNLIMITED)
        unit = f", {action.unit}" if action.unit else ""
        lines = tuple(
            _held(judged.moved.time, judged.moved.command[row, :, at], look)
            for row, look in _rows(outcome)
        )
        plots.append(
            Plot(title=f"{action.actuator}{unit}", x_title="time, s", lines=lines, bounds=bounds)
        )
    return tuple(plots)


def _plot(
    outcome: LearnOutcome,
    column: int,
    title: str,
    bounds: tuple[float, ...] = (),
    bands: tuple[GoalBand, ...] = (),
) -> Plot:
    moved = outcome.judged.moved
    lines = tuple(
        PlottedLine(x=moved.time, y=moved.position[row, :, column], look=look)
        for row, look in _rows(outcome)
    )
    return Plot(title=title, x_title="time, s", lines=lines, bounds=bounds, bands=bands)


def _rows(outcome: LearnOutcome) -> Iterator[tuple[int, str]]:
    """Yield the runs that are drawn: some of all faintly, then the typical one."""
    rows, typical = outcome.judged.rows, outcome.judged.typical
    for row in np.unique(np.linspace(0, rows - 1, min(rows, MOST_RUNS)).round().astype(int)):
        if row != typical:
            yield int(row), "faint"
    yield typical, "main"


def _bands(outcome: LearnOutcome, joint: Joint, column: int) -> Iterator[GoalBand]:
    """Yield where a joint must be to the end, for goals that ask for it by itself."""
    moved = outcome.judged.moved
    end = float(moved.time[-1])
    last = float(moved.position[outcome.judged.typical, -1, column])
    for goal in outcome.task.goals:
        requested = goal.quantity
        alone = isinstance(requested, AngleSum) and requested.joints == (joint.name,)
        if not math.isfinite(goal.within) or goal.beyond:
            continue
        if alone or (isinstance(requested, JointPositions) and joint.name in requested.joints):
            at = 0 if alone else getattr(requested, "joints", ()).index(joint.name)
            middle = goal.target[at]
            if joint.kind == "hinge":
                # Upright is upright after any number of turns: the band lies at the nearest.
                middle += math.tau * round((last - middle) / math.tau)
            yield GoalBand(x=(end - goal.last, end), y=(middle - goal.within, middle + goal.within))


def _held(time: Array, command: Array, look: str) -> PlottedLine:
    """Return a command as the stairs that it is."""
    return PlottedLine(x=np.repeat(time, 2)[1:], y=np.repeat(command, 2)[:-1], look=look)
