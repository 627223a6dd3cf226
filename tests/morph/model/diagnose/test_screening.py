"""Suspects by linear algebra, on a pendulum in closed form whose mass is off as well."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from experiments.conceal.pendulum import Pendulum
from morph.body.load import load
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.model.screen import Suspect, screened, suspects
from morph.physics.joint.coulomb_friction import CoulombFriction

FRICTION = 0.06


@pytest.fixture(scope="module")
def listed(recorded: Callable[..., Any]) -> tuple[Suspect, ...]:
    # 6 % of the mass are 0.3 N m * sin q, five times the friction that is to be seen.
    laws = [("coulomb_friction", 0, {"c": FRICTION})]
    runs = recorded(Pendulum(), laws, seeds=range(3), seconds=3.0, m=1.06).recordings
    robot = load("pendulum")
    step = step_for(runs, robot)
    hypothesis = Hypothesis(robot=robot, step=step, knobs=knobs(robot, None))
    episodes = [episode(run, robot, step) for run in runs]
    return suspects(screened(hypothesis, hypothesis.start, episodes))


def test_dry_friction_is_seen_beside_a_mass_that_is_off(listed: tuple[Suspect, ...]) -> None:
    (coulomb,) = [each for each in listed if each.effect.name == "coulomb_friction"]
    assert isinstance(coulomb.effect, CoulombFriction)
    # Smoothing rounds the corners of friction, and the figures take some of it: a third.
    assert coulomb.effect.c == pytest.approx(FRICTION, rel=0.33)
    # The mass is the description's own business: most of what is left is friction.
    assert coulomb.gain > 0.5


def test_suspects_are_listed_by_what_they_explain(listed: tuple[Suspect, ...]) -> None:
    gains = [each.gain for each in listed]
    assert gains == sorted(gains, reverse=True)
    assert gains[0] > 2.0 * max(gains[-1], 0.0)
    assert len({each.effect.label for each in listed}) == len(listed)
