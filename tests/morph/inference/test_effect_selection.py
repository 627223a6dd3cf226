"""Sets of effects that are refitted: none twice, and other laws in the place of those found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.by_rollouts import richer, to_rollouts, without_figures
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist, under
from morph.inference.refit import Refit, refitted
from morph.inference.search import Prior
from morph.inference.validate import Validation
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Channel, Recording
from tests.morph.inference.dry_disc import INERTIA, STEP, turned

SAMPLES, COULOMB, NOISE = 1000, 0.05, 2e-4
FADED = 0.5
"""rad/s: speed at which friction that is greater at rest has fallen to 1/e of what it adds."""
WHEEL = f"""
<mujoco model="wheel"><option gravity="0 0 0"/><worldbody><body name="disc">
  <joint name="axle" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body></worldbody>
  <actuator><motor name="motor" joint="axle"/></actuator></mujoco>
"""


def posed(folder: Path, fades: float) -> EffectSelection:
    """Return four runs of a wheel with dry friction, greater by `fades` at rest."""
    path = folder / "wheel.xml"
    path.write_text(WHEEL)
    robot, rng, runs = load(path), np.random.default_rng(0), []

    def driven(u: float, q: float, v: float) -> float:
        return float(u + fades * (1.0 - np.exp(-((v / FADED) ** 2))) * np.sign(v))

    for number in range(4):
        time = STEP * np.arange(SAMPLES)
        torque = 0.2 * np.cos((3.0 + number) * time) + 0.1 * np.cos(11.0 * time)
        read = turned(torque.tolist(), driven, coulomb=COULOMB + fades)
        channels = {
            "axle.position": Channel(time=time, value=read + NOISE * rng.normal(size=SAMPLES)),
            "motor.command": Channel(time=time, value=torque, hold=True),
        }
        runs.append(episode(Recording(name=f"run_{number}", channels=channels), robot, STEP))
    nominal = Hypothesis(robot=robot, step=STEP, knobs=())
    bare = EffectSelection(
        nominal=nominal, episodes=runs, known=(), validation=Validation.of(runs),
        prior=Prior(alone={}), deadline=np.inf,
    )  # fmt: skip
    return replace(bare, prior=bare.search(found(bare, nominal)).prior)


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> EffectSelection:
    """Return runs of a wheel with friction that is the same at every speed."""
    return posed(tmp_path_factory.mktemp("wheel"), 0.0)


def found(task: EffectSelection, hypothesis: Hypothesis) -> Finalist:
    """Return a hypothesis refitted to the runs."""
    return task.refitted(hypothesis, hypothesis.start)


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
    monkeypatch.setattr("morph.inference.effect_selection.evidence_decides", lambda runs: noise)
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


def test_a_refit_to_rollouts_keeps_what_acts_once(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    dry, push = CoulombFriction(joint="axle", c=COULOMB), ExternalPush(body="disc", run="a", z=1.0)

    def one(*effects: Effect) -> Any:
        refit = Refit(
            hypothesis=task.nominal, point=task.nominal.start, runs=[], evidence=0.0, rank=0
        )
        return Finalist(
            refit=replace(refit, hypothesis=replace(task.nominal, effects=effects)),
            price=0.0, losses=np.zeros(1), fitted=np.zeros(1), about=SimpleNamespace(),
        )  # fmt: skip

    monkeypatch.setattr(EffectSelection, "refitted", lambda self, given, *rest: one(*given.effects))
    monkeypatch.setattr(EffectSelection, "reduced", lambda self, new: one(dry))
    monkeypatch.setattr(Finalist, "effects", property(lambda self: self.refit.hypothesis.effects))
    wet = ViscousFriction(joint="axle", b=0.1)
    assert to_rollouts(task, one(dry, push)).effects == (dry, push)
    assert to_rollouts(task, one(dry, wet)).effects == (dry,)


def test_changes_of_own_figures_are_refitted_away_where_rollouts_allow_it(
    task: EffectSelection, monkeypatch: pytest.MonkeyPatch
) -> None:
    dry, heavy = CoulombFriction(joint="axle", c=COULOMB), LinkInertia(body="disc", mass=1.05)
    weak = TorqueScale(actuator="motor", gain=0.84)
    monkeypatch.setattr(
        EffectSelection,
        "exchanged",
        lambda self, found, at, other: SimpleNamespace(
            effects=(*found.effects[:at], *found.effects[at + 1 :])
        ),
    )
    # Rollouts need the gain, or neither; friction is not asked about.
    for kept, left in (((weak,), (dry, weak)), ((), (dry,))):

        def prefers(
            self: Any, best: Any, new: Any, effect: Effect, other: None, kept: Any = kept
        ) -> bool:
            return effect not in kept

        monkeypatch.setattr(EffectSelection, "prefers", prefers)
        whole: Any = SimpleNamespace(effects=(heavy, dry, weak))
        assert without_figures(task, whole).effects == left


def test_a_richer_law_is_begun_from_the_simpler_one(task: EffectSelection, tmp_path: Path) -> None:
    dry = CoulombFriction(joint="axle", c=COULOMB)

    def best(given: EffectSelection) -> Effect:
        simple = found(replace(given, by_rollouts=True), replace(given.nominal, effects=(dry,)))
        (effect,) = richer(given, simple).effects
        return effect

    assert isinstance(best(task), CoulombFriction)
    sticky = best(posed(tmp_path, COULOMB))
    assert isinstance(sticky, StribeckFriction)
    # The wheel is seldom between rest and 0.5 rad/s: the friction there and at rest trade.
    assert sticky.c == pytest.approx(COULOMB, rel=0.1)
    assert sticky.s == pytest.approx(2.0 * COULOMB, rel=0.2)


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
