"""Angles are seen by sine and cosine, and their differences are wrapped."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import PolicyError
from morph.policy.angles import features, turning, wrapped
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of


def test_features_are_the_rest_and_then_sine_and_cosine_of_each_angle() -> None:
    found = features(np.array([1.0, 2.0, 3.0, 4.0]), np.array([0, 3]), np.array([2, 1]))
    known = [1.0, 4.0, math.sin(3.0), math.cos(3.0), math.sin(2.0), math.cos(2.0)]
    assert found == pytest.approx(known, abs=1e-15)


def test_differences_of_angles_are_the_short_way_round() -> None:
    angles = np.array([0.1, -6.2, 6.2, 3.0, 3.2, 100.0])
    found = wrapped(np.stack([angles, angles], axis=-1), np.array([1]))
    assert found[:, 0].tolist() == angles.tolist()
    assert found[:, 1] == pytest.approx([math.remainder(a, math.tau) for a in angles], abs=1e-12)


def test_hinges_turn_and_slides_and_speeds_and_limited_hinges_do_not() -> None:
    cart, arm = load("cartpole"), load("so101")
    assert turning(cart, observations_of(cart)).tolist() == [0.0, 1.0, 0.0, 0.0]
    assert not turning(arm, observations_of(arm)).any()
    past = replace(observations_of(cart, ("hinge.position",))[0], history=3)
    assert turning(cart, (past,)).tolist() == [1.0] * 3


@pytest.mark.parametrize(
    ("angles", "what"),
    [
        ((1.0,), "shape"),
        ((0.0, 0.5, 0.0, 0.0), "numbers other than 0 and 1"),
        ((1.0, 0.0, 0.0, 0.0), "slide.position in m"),
        ((0.0, 0.0, 0.0, 1.0), "hinge.velocity in rad/s"),
        (None, "shape"),
        ("many", "shape|array of numbers"),
    ],
)
def test_what_is_no_angle_is_refused(angles: Any, what: str) -> None:
    robot = load("cartpole")
    with pytest.raises(PolicyError, match=what):
        Linear(
            weight=np.zeros((1, 4)),
            bias=np.zeros(1),
            angles=angles,
            action=actions_of(robot),
            observation=observations_of(robot),
        )


def test_a_scaled_angle_is_refused_as_it_cannot_be_wrapped() -> None:
    robot = load("cartpole")
    seen = tuple(replace(each, scale=2.0) for each in observations_of(robot))
    with pytest.raises(PolicyError, match="scale of 2 is no angle"):
        Linear(
            weight=np.zeros((1, 5)),
            bias=np.zeros(1),
            angles=(0.0, 1.0, 0.0, 0.0),
            action=actions_of(robot),
            observation=seen,
        )
