"""What rollouts say of a set of effects after its search."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.inference import by_rollouts
from morph.inference.by_rollouts import richer, to_rollouts, without_figures
from morph.inference.effect_selection import EffectSelection
from morph.inference.finalist import Finalist
from morph.inference.refit import Refit
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from tests.morph.inference.dry_wheel import COULOMB, found, posed


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> EffectSelection:
    """Return runs of a wheel with friction that is the same at every speed."""
    return posed(tmp_path_factory.mktemp("wheel"), 0.0)


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


def test_a_set_refitted_to_rollouts_is_searched_again_and_sets_with_no_more_are_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rotor, play, late = (SimpleNamespace(label=label) for label in ("rotor", "play", "late"))

    def one(loss: float, *effects: Any) -> Any:
        return SimpleNamespace(effects=effects, loss=loss)

    best = one(10.0, rotor)
    more = [one(1.0, rotor), one(12.0, rotor, late), one(9.0, rotor, play)]
    rolled = []

    def to_rollouts(task: Any, found: Any) -> Any:
        rolled.append(found)
        return found

    monkeypatch.setattr(by_rollouts, "to_rollouts", to_rollouts)
    monkeypatch.setattr(by_rollouts, "gains", lambda before, new, judge: new.loss < before.loss)
    task: Any = SimpleNamespace(
        added=lambda base, search, most: (more, base), search=lambda base: None,
        late=lambda: False, validation=None,
    )  # fmt: skip
    assert by_rollouts.beside(task, best) is more[2]
    assert rolled == more[1:]
    task.late = lambda: True
    assert by_rollouts.beside(task, best) is best
