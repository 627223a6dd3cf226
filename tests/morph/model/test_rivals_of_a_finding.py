"""Rivals of a finding in the order of their probability."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.model.conclude import Standing, experiment
from morph.model.findings import _finding
from morph.physics import EFFECTS
from morph.physics.joint.coulomb_friction import CoulombFriction

KINDS = {kind.name: kind for kind in EFFECTS}


@pytest.mark.parametrize("likely", ["viscous_friction", "stribeck_friction"])
def test_the_likeliest_rival_comes_first_and_the_experiment_is_against_it(likely: str) -> None:
    ours = CoulombFriction(joint="hinge", c=0.1)
    names = ("viscous_friction", "quadratic_damping", "stribeck_friction")
    rivals = [KINDS[name].at("hinge") for name in names]
    shares = {name: 0.3 if name == likely else 0.1 for name in names}
    contenders = [
        SimpleNamespace(fit=SimpleNamespace(hypothesis=SimpleNamespace(effects=(rival,))))
        for rival in rivals
    ]
    stand = Standing(
        effect=ours,
        without=cast(Any, SimpleNamespace(losses=np.array([4.0, 4.0]))),
        rivals=cast(Any, tuple(contenders)),
        chances={ours.label: 0.5} | {each.label: shares[each.name] for each in rivals},
    )
    evidence = SimpleNamespace(
        train=[SimpleNamespace(name="run_0")],
        robot=SimpleNamespace(joints=()),
        best=SimpleNamespace(losses=np.array([1.0, 1.0])),
        search=SimpleNamespace(rounds=(), segments=SimpleNamespace(episode=np.zeros(2, dtype=int))),
    )
    found = _finding(cast(Any, evidence), ours, {}, stand, ())
    assert found.rivals[0].effect == likely
    assert [each.probability for each in found.rivals] == [0.3, 0.1, 0.1]
    assert found.separate_by == experiment(ours, likely)
    # Of losses of 8 without it, 2 are left with it.
    assert (found.probability, found.gain) == (0.5, pytest.approx(0.75))
