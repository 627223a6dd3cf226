"""Floors by name."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics.contact.presets import SURFACES, Surface, surface
from morph.physics.effect import Effect
from morph.sim.simulator import Simulator

every_surface = pytest.mark.parametrize("known", SURFACES, ids=lambda known: known.name)


def value(effects: tuple[Effect, ...], name: str, parameter: str) -> float:
    (effect,) = (effect for effect in effects if effect.name == name)
    return float(getattr(effect, parameter))


@every_surface
def test_every_number_of_a_floor_says_where_it_comes_from(known: Surface) -> None:
    for source in (known.mu_source, known.e_source, known.stiffness_source):
        assert source.endswith(".")
        assert len(source) > 20


@every_surface
def test_a_block_dropped_on_a_named_floor_slides_as_far_as_its_friction_says(
    known: Surface, block: Robot
) -> None:
    effects = surface(known.name, height=-0.001)
    assert value(effects, "contact_friction", "mu") == known.mu
    assert value(effects, "restitution", "e") == known.e
    run = Simulator(block, effects).run(seconds=1.0, speed={"block.linear_velocity.x": 1.0})
    expected = 1.0 / (2.0 * known.mu * 9.81)
    # A fall of 1 mm lasts t = 14 ms without friction, which each impact makes up for: it costs
    # mu g t^2 / 2 of way, 1.2 % of v^2 / 2 mu g at mu = 0.8, and the bounces of e = 0.5 half as
    # long each (2 e)^2 t^2 and less, about as much again twice. Steps cost mu g h / v = 1.6 %.
    assert run["block.position.x"][-1] == pytest.approx(expected, rel=0.045)
    # It rests in the end: MuJoCo's contacts of a body that bounces this well do not chatter.
    assert np.abs(run["block.linear_velocity.z"][-50:]).max() < 1e-3


def test_a_floor_of_another_name_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(EffectError, match="hard_floor, rubber_on_wood, pla_on_carpet"):
        surface("ice")
