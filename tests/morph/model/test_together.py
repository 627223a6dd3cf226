"""Links that are off all at once, against a body whose links were changed by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.card import Print
from morph.body.load import load
from morph.body.robot import Robot
from morph.model.episodes import episode, step_for
from morph.model.fit import Fit, fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.model.segments import Segments, cut
from morph.model.shooting import predict
from morph.model.together import instead, together
from morph.physics.body.com_offset import ComOffset
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.effect import Effect
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Recording

Recorded = Callable[..., Recording]
TRUSTED = {"mass": 0.0, "com": 0.0, "inertia": 0.0}


@pytest.fixture(scope="module")
def arm() -> Robot:
    robot = load("double_pendulum")
    assert robot.card is not None
    return replace(robot, card=replace(robot.card, print=Print(printed=("upper", "lower"))))


def fitted(arm: Robot, recorded: Recorded, *effects: Effect) -> tuple[Fit, Segments]:
    """Return the described arm fitted to what the arm under effects did, and its segments."""

    def told(times: Array) -> Array:
        return np.asarray(0.4 * np.sin(2.0 * np.pi * 0.7 * times))

    start = {"shoulder": 0.5, "elbow": -0.4}
    run = recorded(arm, *effects, seconds=8.0, start=start, command=told)
    step = step_for([run], arm)
    segments = cut([episode(run, arm, step)], 1.0)
    nominal = Hypothesis(robot=arm, step=step, knobs=knobs(arm, TRUSTED))
    read = predict(nominal, segments, [nominal.start], [segments.start])[0]
    found = fit(nominal, segments, *measure(segments, read))
    read = predict(found.hypothesis, segments, [found.point], [found.start])[0]
    units = measure(segments, read)
    return fit(nominal, segments, *units, point=found.point, start=found.start), segments


def test_masses_of_two_links_are_told_together_and_measured(arm: Robot, recorded: Recorded) -> None:
    true = {"upper": 0.6, "lower": 0.7}
    effects = [LinkInertia(body=name, mass=mass, inertia=mass) for name, mass in true.items()]
    found, segments = fitted(arm, recorded, *effects)
    links = together(found, segments)
    assert links is not None
    assert {"link_inertia@upper", "link_inertia@lower"} <= {
        effect.label for effect in links.hypothesis.effects
    }
    whole = fit(
        links.hypothesis, segments, found.scale, found.weight, point=links.point, iterations=12
    )
    fits = {e.where: e for e in whole.hypothesis.effects if isinstance(e, LinkInertia)}
    # Torques are trusted to 5 %, and every force is a mass times what is seen.
    for name, mass in true.items():
        assert fits[name].mass == pytest.approx(mass, rel=0.06)


def test_friction_alone_is_not_put_down_to_many_links(arm: Robot, recorded: Recorded) -> None:
    found, segments = fitted(arm, recorded, ViscousFriction(joint="elbow", b=0.03))
    links = together(found, segments)
    # What promises less than the one effect that is there is dropped by the search.
    more = found.hypothesis.adding(ViscousFriction(joint="elbow", b=0.01))
    one = fit(more, segments, found.scale, found.weight, start=found.start)
    assert links is None or links.cost > 2.0 * one.cost


def test_an_offset_of_both_links_is_what_else_could_be_said(arm: Robot, recorded: Recorded) -> None:
    effects = [LinkInertia(body=name, mass=0.6, inertia=0.6) for name in ("upper", "lower")]
    found, segments = fitted(arm, recorded, *effects)
    more = replace(found.hypothesis, effects=tuple(effects))
    point = np.concatenate([found.point, more.start[len(found.point) :]])
    whole = fit(more, segments, found.scale, found.weight, point=point, start=found.start)
    said = instead(whole, segments, {effect.label for effect in effects})
    assert set(said) == {"link_inertia@upper", "link_inertia@lower"}
    for others in said.values():
        ((other, chance),) = others
        assert isinstance(other, ComOffset)
        # A weight halfway out weighs on the shoulder as one that is lighter, but not at speed.
        assert chance < 0.5


def test_a_figure_that_an_effect_says_is_not_refitted_beside_it(arm: Robot) -> None:
    effect = LinkInertia(body="lower", mass=0.7)
    whole = Hypothesis(robot=arm, step=0.004, knobs=knobs(arm), effects=(effect,))
    held = {
        name for name, low, high in zip(whole.names, whole.low, whole.high, strict=True)
        if low == high
    }  # fmt: skip
    assert held == {"mass:lower", "inertia:lower"}
