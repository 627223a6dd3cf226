"""Which of two refitted sets of effects is better."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.inference.finalist import Finalist, better, gains, simplified
from morph.inference.quadratic import LogPosterior
from morph.inference.refit import Refit
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction


@pytest.mark.parametrize(("more", "gain", "taken"), [
    ("", 4.0, True), ("", 2.0, False), ("drag", 12.0, False), ("drag", 25.0, True),
    ("push", 16.0, True), ("push", 12.0, False),
])  # fmt: skip
def test_another_law_in_the_place_of_one_needs_less_evidence_than_one_more(
    monkeypatch: pytest.MonkeyPatch, more: str, gain: float, taken: bool
) -> None:
    for module in ("finalist", "explained"):
        monkeypatch.setattr(f"morph.inference.{module}.evidence_decides", lambda runs: True)
    # A push acts in few rollouts, and a little force may be missing beside it.
    monkeypatch.setattr("morph.inference.explained.missing", lambda runs: 0.05)
    judge: Any = SimpleNamespace(sure=lambda a, b: False, worse=lambda a, b: False)
    one, other = (SimpleNamespace(label=each, passing=each == "push") for each in ("law", more))
    before: Any = SimpleNamespace(evidence=0.0, losses=None, effects=(one,))
    after: Any = SimpleNamespace(
        evidence=gain, losses=None, fitted=None, refit=SimpleNamespace(runs=()),
        effects=(one, other) if more else (one,),
    )  # fmt: skip
    assert gains(before, after, judge) == taken


def test_what_one_run_alone_determines_is_not_refuted_by_leaving_it_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("morph.inference.finalist.evidence_decides", lambda runs: True)
    judge: Any = SimpleNamespace(sure=lambda a, b: b < a - 0.1, worse=lambda a, b: b > a + 0.1)
    refit = SimpleNamespace(runs=())

    def one(evidence: float, losses: float, fitted: float) -> Any:
        return SimpleNamespace(
            evidence=evidence, losses=losses, fitted=fitted, refit=refit, effects=(1,)
        )

    before, right, wrong = one(0.0, 2.8, 2.7), one(900.0, 3.4, 1.0), one(900.0, 3.4, 3.3)
    assert gains(before, right, judge)
    assert not gains(before, wrong, judge)
    assert better(before, right, judge) is right
    assert better(before, wrong, judge) is before


@pytest.mark.parametrize("rest", [0.04, 0.1, 0.2])
def test_friction_that_does_not_fade_is_coulombs(pendulum: Robot, rest: float) -> None:
    effects = (
        StribeckFriction(joint="hinge", c=0.1, s=rest, vs=1.0),
        ViscousFriction(joint="hinge", b=0.3),
    )
    hypothesis = Hypothesis(robot=pendulum, step=0.01, knobs=knobs(pendulum), effects=effects)
    own, point = len(hypothesis.knobs), hypothesis.start
    rows = np.random.default_rng(0).normal(size=(40, 1 + len(point)))
    about = LogPosterior(
        hypothesis=hypothesis, point=point, grams=(rows.T @ rows)[None], readings=1000
    )
    refit = Refit(hypothesis=hypothesis, point=point, runs=(), evidence=7.0, rank=about.step()[1])
    losses = np.zeros(4)
    found = Finalist(refit=refit, price=0.0, losses=losses, fitted=losses, about=about)
    new = simplified(found)
    if rest > 0.1:
        assert new is found
        return
    assert [effect.label for effect in new.effects] == [
        "coulomb_friction@hinge",
        "viscous_friction@hinge",
    ]
    # What follows own parameters: the level, and damping; friction at rest and its speed are gone.
    assert new.refit.point[own:].tolist() == [0.1, 0.3]
    kept = [*range(2 + own), 4 + own]
    assert np.array_equal(new.about.grams[0], (rows.T @ rows)[np.ix_(kept, kept)])
    gained = 0.5 * (refit.rank - new.refit.rank) * math.log(1000)
    assert new.evidence == pytest.approx(7.0 + gained)
    assert gained > 0.0
