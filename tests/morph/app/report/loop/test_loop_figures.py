"""Losses and counts of a loop as its report tells them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from morph.app.report.loop.verdict import summary
from morph.app.report.loop.words import ordinal, trials_said


def outcome(losses: list[float], kept: int) -> Any:
    """Return what a loop found, as far as its first sentence reads it."""
    return cast(
        Any,
        SimpleNamespace(
            transferred=SimpleNamespace(seconds=12.34, foreseen=None),
            runs=[SimpleNamespace(loss=loss) for loss in losses],
            kept=kept,
            experience=3.0 * len(losses),
            judged=None,
        ),
    )


@pytest.mark.parametrize(
    ("losses", "kept", "said"),
    [
        ([40.5, 17.25, 12.125], 3, "In three trials of 9 s together the loss went from 40.5 to 12"),
        ([40.5, 12.125, 17.25], 2, "In three trials of 9 s together the loss went from 40.5 to 12"),
        ([12.125, 40.5], 1, "Of two trials of 6 s together that of the source's policy was the"),
        ([40.5], 1, "In one trial of 3 s the source's policy cost 40.5"),
    ],
)
def test_the_loss_is_told_from_the_first_trial_to_the_one_that_is_kept(
    losses: list[float], kept: int, said: str
) -> None:
    (line,) = summary(outcome(losses, kept))
    assert line.startswith(said)
    assert line.endswith("; computing took 12.3 s.")


def test_trials_are_counted_from_the_first() -> None:
    assert [ordinal(n) for n in (1, 2, 9, 10)] == ["first", "second", "ninth", "10th"]
    assert trials_said(1, 3.0) == "one trial of 3 s"
