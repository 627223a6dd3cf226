"""Refits of sets that leave most of the force missing; nothing is simulated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.inference import refit
from morph.inference.refit import ESTIMATES, HOPELESS, Refit, refitted
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
