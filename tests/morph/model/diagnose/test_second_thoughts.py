"""A wrong first impression is mended: needless findings go, and rivals take a finding's place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

from experiments.conceal.pendulum import Pendulum
from morph.body.load import load
from morph.model import search
from morph.model.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.model.trial import Tried

DELAY = 0.03
"""Seconds by which commands are late: that is all that is left out."""


@pytest.fixture(scope="module")
def late(recorded: Callable[..., Any]) -> Any:
    return recorded(
        Pendulum(), [("actuator_delay", 0, {"T": DELAY})], seeds=range(4), seconds=3.0
    ).recordings


def misled(recordings: Any, rounds: int) -> Diagnosis:
    """Return what is found where the first rounds are shown a lag of the motor alone."""
    asked: list[int] = []
    right = search.try_all

    def try_lag(*arguments: Any) -> Sequence[Tried]:
        asked.append(len(asked))
        tried = right(*arguments)
        if len(asked) > rounds:
            return tried
        return tuple(each for each in tried if each.effect.name == "actuator_lag")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "try_all", try_lag)
        found = diagnose(load("pendulum"), recordings, seed=0)
    assert asked
    return found


@pytest.mark.parametrize(
    "rounds",
    [
        # A lag is taken, then a delay beside it: the lag is needless then.
        1,
        # A delay is never proposed; it is a rival of the lag that was taken, and beats it.
        99,
    ],
)
def test_a_delay_alone_is_left_though_a_lag_was_taken_first(late: Any, rounds: int) -> None:
    found = misled(late, rounds)
    assert found.verdict == "mismatch"
    (finding,) = found.findings
    assert finding.effect.label == "actuator_delay@hinge"
    # As in a search that is not misled: 30.0 ms with an interval of 1 %.
    assert finding.parameters["T"].value == pytest.approx(DELAY, rel=0.05)
    assert finding.probability > 0.95
    lag = [each for each in finding.rivals if each.effect == "actuator_lag"]
    assert lag
    assert all(each.probability < 0.05 for each in lag)
