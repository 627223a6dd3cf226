"""Runs that a model does not follow, and sets that leave most of the force missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.errors import RecordingError
from morph.inference import refit
from morph.inference.observed import Observed
from morph.inference.refit import ESTIMATES, HOPELESS, Refit, refitted, seen
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.joint.viscous_friction import ViscousFriction


@pytest.mark.parametrize(("force", "estimates"), [(0.9 * HOPELESS, ESTIMATES), (1.1 * HOPELESS, 1)])
def test_a_set_that_leaves_most_of_the_force_missing_is_not_refitted_to_the_end(
    pendulum: Robot, monkeypatch: pytest.MonkeyPatch, force: float, estimates: int
) -> None:
    nominal = Hypothesis(robot=pendulum, step=0.004, knobs=())
    origin = Refit(hypothesis=nominal, point=np.zeros(0), runs=[], evidence=0.0, rank=0)
    whole, done = nominal.adding(ViscousFriction(joint="hinge")), []

    def descended(best: Refit, *rest: Any) -> Refit:
        done.append(best)
        return best

    def likelier(*given: Any) -> Refit:
        # Each estimate of the disturbance gains: only force that is missing ends the refit.
        return replace(origin, evidence=1e6 * (1 + len(done)))

    def none(*given: Any) -> Sequence[Any]:
        return []

    monkeypatch.setattr(refit, "_descended", descended)
    monkeypatch.setattr(refit, "_judged", likelier)
    monkeypatch.setattr(refit, "seen", none)
    monkeypatch.setattr(refit, "readings", lambda runs: 100)
    monkeypatch.setattr(refit, "missing", lambda runs: force)
    refitted(whole, whole.start, [], origin=origin)
    assert len(done) == estimates


def test_a_run_that_no_motion_comes_near_is_refused_and_a_candidate_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Angles in degrees drive the linearised model to infinity."""
    lost = SimpleNamespace(about=SimpleNamespace(velocity=np.full((2, 1), np.nan)))
    monkeypatch.setattr("morph.inference.refit.observed", lambda *given, **more: lost)
    monkeypatch.setattr("morph.inference.refit.acting", lambda *given: (None, []))
    run = cast(Episode, SimpleNamespace(name="swing"))
    nominal = cast(Hypothesis, SimpleNamespace(robot=None))
    with pytest.raises(RecordingError, match="no finite motion") as refusal:
        seen(nominal, np.zeros(0), [run])
    assert "swing" in str(refusal.value)
    assert seen(nominal, np.zeros(0), [run], [cast(Observed, lost)]) == [lost]
