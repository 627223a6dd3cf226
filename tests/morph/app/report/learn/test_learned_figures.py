"""Counts and costs of a search as its report tells them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.app.report.learn.words import summary


def outcome(reached: int, still: float, chance: float) -> Any:
    """Return what a search found, as far as its sentences read it."""

    def control(mean: float, reached: int) -> Any:
        return SimpleNamespace(mean=mean, loss=np.full(50, mean), success=np.arange(50) < reached)

    return cast(
        Any,
        SimpleNamespace(
            judged=SimpleNamespace(
                success=np.arange(50) < reached,
                rows=50,
                loss=np.full(50, 12.5),
                goals={"up": reached / 50.0},
                controls={"nothing": control(still, 0), "random": control(chance, 3)},
            ),
            search=SimpleNamespace(name="ddp"),
            count=4,
            seconds=6.0,
            experience=0.0,
        ),
    )


@pytest.mark.parametrize(("reached", "many"), [(50, "All of 50"), (49, "49 of 50"), (0, "0 of 50")])
def test_as_many_runs_reach_the_goal_as_did(reached: int, many: str) -> None:
    first, spent, _ = summary(outcome(reached, 60.0, 80.0))
    assert first == (
        f"{many} noisy runs that the search never saw reach the goal; the mean loss is 12.5."
    )
    assert spent == "The search ddp took 6 s, four rounds."


@pytest.mark.parametrize(
    ("still", "chance", "said"),
    [
        (60.0, 80.0, "doing nothing, costs 60 and reaches the goal in 0 of 50 runs."),
        (80.0, 60.0, "random commands, costs 60 and reaches the goal in 3 of 50 runs."),
    ],
)
def test_the_better_control_is_the_one_that_costs_less(
    still: float, chance: float, said: str
) -> None:
    assert summary(outcome(50, still, chance))[-1].endswith(f"the better control, {said}")
