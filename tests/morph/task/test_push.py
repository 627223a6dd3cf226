"""A push gives a body the velocities that mechanics say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.task.balance import balance
from morph.task.push import Push
from morph.task.upright import upright


def test_a_push_gives_the_cart_pole_its_impulse() -> None:
    # Both together weigh 1 kg: the momentum along x after a push of 0.3 N s is 0.3 N s.
    task = balance(load("cartpole"))
    push = Push(link="cart", impulse=(0.3, 0.0, 0.0))
    model = task.simulator().model
    q, v = replace(task.start, push=push).sample(task.robot, model, 1, None)
    # The upright pole of 0.5 kg and 0.5 m: x speed of its centre is v0 - 0.25 * (-v1) by sign.
    height = 0.25
    momentum = 0.5 * v[0, 0] + 0.5 * (v[0, 0] - height * v[0, 1] * np.cos(q[0, 1]) * -1.0)
    assert momentum == pytest.approx(0.3, abs=1e-9)


def test_a_body_that_nothing_moves_scores_one_at_rest_and_little_once_it_fell() -> None:
    task = balance(load("cartpole"))
    measure = upright(task)
    assert measure.placed
    assert measure.carriers == ("cart",)
    assert measure.rest[2] == pytest.approx(0.25, abs=1e-6)
