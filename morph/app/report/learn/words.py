"""The sentences that a reader of a search's report meets first."""

from __future__ import annotations

import math

from morph.app.report.learn.outcome import LearnOutcome
from morph.app.report.words import counted

NAMED = {
    "nothing": "doing nothing",
    "random": "random commands",
}
"""What a control is called."""


def number(value: float) -> str:
    """Return a number with three figures or more; only beyond a million with an exponent."""
    if 1000.0 <= abs(value) < 1e6:
        return f"{value:.0f}"
    return f"{value:.3g}" if math.isfinite(value) else "none"


def headline(outcome: LearnOutcome) -> str:
    """Return the verdict."""
    task, robot = outcome.task.name, outcome.task.robot.name
    if outcome.succeeded:
        return f"{robot} has learned {task}"
    if outcome.judged.share > 0.0:
        return f"{robot} does {task} at times, and not reliably"
    return f"{robot} has not learned {task}"


def summary(outcome: LearnOutcome) -> tuple[str, ...]:
    """Return what it does and what it took, in two or three sentences."""
    judged = outcome.judged
    reached = int(judged.success.sum())
    goals = "the goal" if len(judged.goals) == 1 else "every goal"
    many = f"All of {judged.rows}" if reached == judged.rows else f"{reached} of {judged.rows}"
    runs = f"{many} noisy runs that the search never saw reach {goals}"
    lines = [f"{runs}; the mean loss is {number(float(judged.loss.mean()))}.", spent(outcome)]
    best = min(judged.controls, key=lambda name: judged.controls[name].mean, default="")
    if best:
        score = judged.controls[best]
        lines.append(
            f"From the same starts the better control, {NAMED.get(best, best)}, costs "
            f"{number(score.mean)} and reaches {goals} in {int(score.success.sum())} of "
            f"{len(score.loss)} runs."
        )
    return tuple(lines)


def spent(outcome: LearnOutcome) -> str:
    """Return what the search took."""
    count = counted(outcome.count, *_called(outcome))
    on_robot = (
        f" and {number(outcome.experience)} s of experience" if outcome.experience > 0.0 else ""
    )
    return f"The search {outcome.search.name} took {number(outcome.seconds)} s, {count}{on_robot}."


def _called(outcome: LearnOutcome) -> tuple[str, str]:
    return ("trial", "trials") if outcome.experience > 0.0 else ("round", "rounds")
