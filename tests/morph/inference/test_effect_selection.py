"""Sets of effects that are refitted: none twice, and other laws in the place of those found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, under
from morph.inference.refit import Refit, refitted
from morph.inference.validate import Validation
from morph.model.hypothesis import Hypothesis
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.body.external_push import ExternalPush
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from tests.morph.inference.dry_wheel import COULOMB, found, posed


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> EffectSelection:
    """Return runs of a wheel with friction that is the same at every speed."""
    return posed(tmp_path_factory.mktemp("wheel"), 0.0)


def test_a_simpler_law_takes_the_place_of_a_richer_one(
    task: EffectSelection,
) -> None:
    curved = StribeckFriction(joint="axle", c=COULOMB, s=1.1 * COULOMB, vs=0.5)
    best = found(task, replace(task.nominal, effects=(curved,)))
    search = task.search(best)
    other = task.replaced(best, search, set())
    assert other is not None
    (simple,) = other.effects
    assert isinstance(simple, CoulombFriction)
    # 1000 readings of 2e-4 rad in a second each way: torques of 1e-3 N m show.
    assert simple.c == pytest.approx(COULOMB, abs=2e-3)
    # What was replaced before does not come back.
    again = task.replaced(best, search, {"coulomb_friction@axle"})
    assert again is None or not isinstance(again.effects[0], CoulombFriction)


def test_an_effect_goes_where_the_others_explain_what_it_did(task: EffectSelection) -> None:
    dry, wet = CoulombFriction(joint="axle", c=COULOMB), ViscousFriction(joint="axle", b=0.001)
    best = found(task, replace(task.nominal, effects=(dry, wet)))
    other = task.replaced(best, task.search(best), set())
    assert other is not None
    assert [effect.name for effect in other.effects] == ["coulomb_friction"]
    # The one that is left cannot go: a wheel with dry friction stops.
    alone = task.replaced(other, task.search(other), set())
    assert alone is None or alone.effects


@pytest.mark.parametrize(("noise", "left"), [(True, 2), (False, 1)])
def test_no_effect_leaves_a_set_at_noise_against_the_evidence(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, noise: bool, left: int
) -> None:
    effects = ViscousFriction(joint="axle", b=1e-3), CoulombFriction(joint="axle", c=COULOMB)
    whole = found(task, replace(task.nominal, effects=effects))
    # Rollouts that diverge seem to do better without dry friction, whose evidence is 1e4 nats.
    monkeypatch.setattr(
        "morph.inference.effect_selection.needed", lambda *given, **more: ([0], whole.losses)
    )
    monkeypatch.setattr("morph.inference.explained.evidence_decides", lambda runs: noise)
    monkeypatch.setattr(Validation, "worse", lambda *given: False)
    shared = []

    def together(one: Finalist, other: Finalist) -> Finalist:
        shared.append(other)
        return under(one, other)

    monkeypatch.setattr("morph.inference.effect_selection.under", together)
    assert len(task.reduced(whole).effects) == left
    # Both were compared under the disturbance of the larger.
    assert shared[0] is whole


def test_rollouts_of_the_whole_refit_are_kept_where_it_reaches_the_noise(
    task: EffectSelection,
) -> None:
    none = found(task, task.nominal)
    assert none.fitted is none.losses
    dry = found(task, replace(task.nominal, effects=(CoulombFriction(joint="axle", c=COULOMB),)))
    points = [dry.refit.point] * task.validation.folds
    (due,) = task.validation.losses(dry.refit.hypothesis, [points], dry.refit.runs)
    assert dry.fitted == pytest.approx(due, abs=1e-12)
    assert not np.allclose(dry.fitted, dry.losses, atol=1e-9)


@pytest.mark.parametrize(("late", "lag", "gain", "tried"), [
    (ActuatorDelay(actuator="motor", T=0.01), ActuatorLag(actuator="motor", T=0.01), -5.0, True),
    (ActuatorDelay(actuator="motor", T=0.01), ActuatorLag(actuator="motor", T=0.01), -65.0, False),
    # Beside a push the slope of a limit that no other run reaches is nothing.
    (ExternalPush(body="disc", z=1.0), TorqueSaturation(actuator="motor", limit=1.0), -1e3, True),
])  # fmt: skip
def test_a_twin_is_refitted_in_the_place_of_a_finding(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch,
    late: Effect, lag: Effect, gain: float, tried: bool,
) -> None:  # fmt: skip
    wet = ViscousFriction(joint="axle", b=0.1)
    start = replace(task.nominal, effects=(late,))
    refit = SimpleNamespace(
        hypothesis=start, point=start.start, runs=(), removal=lambda at: (np.zeros(0, int), 0.0)
    )
    best: Any = SimpleNamespace(effects=(late,), refit=refit, evidence=0.0, losses=None)
    # Viscous friction is no twin of either, and not likelier.
    search: Any = SimpleNamespace(instead=lambda *given: (-1e3, [(wet, 0.0), (lag, gain)]))

    def likelier(self: EffectSelection, hypothesis: Hypothesis, *rest: Any) -> Any:
        return hypothesis.effects

    monkeypatch.setattr(EffectSelection, "refitted", likelier)
    monkeypatch.setattr(EffectSelection, "prefers", lambda *given: True)
    monkeypatch.setattr(EffectSelection, "reduced", lambda self, new: new)
    other = task.replaced(best, search, set())
    assert other == ((lag,) if tried else None)


@pytest.mark.parametrize(("beside", "tried"), [
    (ActuatorLag(actuator="motor", T=0.005), True), (CoulombFriction(joint="axle", c=0.1), False),
])  # fmt: skip
def test_a_set_is_refitted_without_an_effect_that_its_twin_may_make_up_for(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, beside: Effect, tried: bool
) -> None:
    late = ActuatorDelay(actuator="motor", T=0.02)
    start = replace(task.nominal, effects=(late, beside))
    refit = SimpleNamespace(
        hypothesis=start, point=start.start, runs=(), removal=lambda at: (np.zeros(0, int), 0.0)
    )
    best: Any = SimpleNamespace(effects=(late, beside), refit=refit, evidence=0.0, losses=None)
    # 284 nats were lost in Gram space where a delay of 20 ms and a lag of 5 ms stood for 25 ms.
    search: Any = SimpleNamespace(instead=lambda *given: (-284.0, []))
    monkeypatch.setattr(EffectSelection, "refitted", lambda self, given, *rest: given.effects)
    monkeypatch.setattr(EffectSelection, "prefers", lambda self, best, new, *rest: new == (late,))
    monkeypatch.setattr(EffectSelection, "reduced", lambda self, new: new)
    assert task.replaced(best, search, set()) == ((late,) if tried else None)


def test_no_set_is_refitted_twice(task: EffectSelection, monkeypatch: pytest.MonkeyPatch) -> None:
    base = found(task, task.nominal)
    search = task.search(base)
    best = search.sets(1)[0]
    calls = []

    def counted(hypothesis: Hypothesis, *rest: Any, **options: Any) -> Refit:
        calls.append([each.label for each in hypothesis.effects])
        return refitted(hypothesis, *rest, **options)

    def twice(*rest: Any) -> Sequence[Any]:
        return [[best, best]]

    monkeypatch.setattr("morph.inference.effect_selection.refitted", counted)
    monkeypatch.setattr(EffectSelection, "proposals", twice)
    tried, _ = task.added(base, search, 1)
    assert len(tried) == 1
    assert calls == [[each.label for each in best.effects]]


@pytest.mark.parametrize(("better", "refits"), [(True, 1), (False, 2)])
def test_sets_proposed_later_are_refitted_only_where_none_before_is_better(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, better: bool, refits: int
) -> None:
    base = found(task, task.nominal)
    search = task.search(base)
    best, other = [one for one in search.sets(1) if len(one.effects) == 1][:2]
    monkeypatch.setattr(EffectSelection, "proposals", lambda *rest: [[best], [other]])
    monkeypatch.setattr("morph.inference.effect_selection.gains", lambda *rest: better)
    tried, _ = task.added(base, search, 1)
    assert len(tried) == refits


@pytest.mark.parametrize(("sure", "other", "taken"), [
    (False, StribeckFriction(joint="axle"), False),
    (True, StribeckFriction(joint="axle"), True),
    (False, ViscousFriction(joint="axle"), True),
])  # fmt: skip
def test_parameters_more_than_the_simpler_law_has_must_show_in_rollouts(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch, sure: bool, other: Any, taken: bool
) -> None:
    monkeypatch.setattr("morph.inference.finalist.evidence_decides", lambda runs: True)
    judge: Any = SimpleNamespace(sure=lambda a, b: sure, worse=lambda a, b: False)
    before: Any = SimpleNamespace(evidence=0.0, losses=None, effects=(1,))
    refit = SimpleNamespace(runs=())
    after: Any = SimpleNamespace(
        evidence=100.0, losses=None, fitted=None, refit=refit, effects=(1,)
    )
    simple = CoulombFriction(joint="axle")
    assert replace(task, validation=judge).prefers(before, after, simple, other) == taken
