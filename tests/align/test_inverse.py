"""Inverse dynamics of a target from its transitions, against a law that is known."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError, SettingError
from morph.alignment.inverse import gaussian_inverse, local_inverse
from morph.alignment.samples import Transitions

DT, MASS, FRICTION = 0.05, 2.0, 1.5
PLAIN = np.array([False, False])


def after(state: Array, command: Array, friction: float = FRICTION) -> Array:
    """Return one Euler step of a mass with viscous friction, x = (place, speed)."""
    force = command[:, 0] - friction * state[:, 1]
    speed = state[:, 1] + DT * force / MASS
    return np.stack([state[:, 0] + DT * state[:, 1], speed], axis=1)


def without_friction(state: Array, then: Array) -> Array:
    """Return the inverse of a simulator that knows the mass and no friction."""
    return np.asarray(MASS * (then[:, 1:] - state[:, 1:]) / DT)


def seen(rows: int, noise: float, seed: int = 0) -> Transitions:
    rng = np.random.default_rng(seed)
    state, command = rng.normal(size=(rows, 2)), rng.uniform(-10.0, 10.0, (rows, 1))
    then = after(state, command) + noise * rng.normal(size=(rows, 2))
    return Transitions(state=state, command=command, after=then, turns=PLAIN)


@pytest.mark.parametrize("way", [gaussian_inverse, local_inverse])
def test_a_guess_lets_sixty_noisy_steps_name_the_friction(way) -> None:
    # Noise of 0.005 in speed is 2 * 0.005 / 0.05 = 0.2 N in one step; a law of four numbers from
    # sixty steps is known to 0.2 * sqrt(4 / 60) = 0.05 N on average, and at most thrice that.
    # The local planes have 10 or so steps' worth of data each: sqrt(4 / 10) of 0.2 N.
    inverse = way(seen(60, 0.005), without_friction)
    rng = np.random.default_rng(1)
    state, command = 0.7 * rng.normal(size=(40, 2)), rng.uniform(-5.0, 5.0, (40, 1))
    told, variance = inverse.predict(state, after(state, command))
    error = np.sqrt(np.square(told - command).mean())
    assert error < (0.1 if way is gaussian_inverse else 0.4)
    alone = without_friction(state, after(state, command))
    assert error < 0.4 * np.sqrt(np.square(alone - command).mean())
    assert (variance > 0.0).all()


def test_without_a_guess_the_law_is_learned_whole() -> None:
    inverse = gaussian_inverse(seen(60, 0.0))
    state, command = np.array([[0.2, 0.5]]), np.array([[3.0]])
    assert inverse.predict(state, after(state, command))[0] == pytest.approx(command, abs=0.1)


def test_what_is_promised_is_what_is_missed() -> None:
    # Errors of 300 predictions in their standard deviations: near 1 in the root mean square.
    errors = []
    rng = np.random.default_rng(3)
    for seed in range(10):
        inverse = gaussian_inverse(seen(40, 0.005, seed), without_friction)
        state, command = rng.normal(size=(30, 2)), rng.uniform(-10.0, 10.0, (30, 1))
        told, variance = inverse.predict(state, after(state, command))
        errors.append((told - command) / np.sqrt(variance))
    # Ten data sets, each of which shares its errors over 30 predictions.
    assert 0.5 < np.sqrt(np.square(errors).mean()) < 1.6


def test_an_angle_that_went_round_is_no_great_change() -> None:
    state = np.array([[3.1, 0.0], [-3.1, 0.0], [3.1, 0.0], [0.0, 0.0]])
    then = state + np.array([0.1, 0.0])
    round_about = then.copy()
    round_about[:, 0] -= 2.0 * np.pi
    command = np.ones((4, 1))
    turns = np.array([True, False])
    one, other = (
        gaussian_inverse(Transitions(state=state, command=command, after=each, turns=turns))
        for each in (then, round_about)
    )
    assert one.predict(state, then)[0] == pytest.approx(
        other.predict(state, round_about)[0], abs=1e-6
    )


def test_more_runs_make_it_surer() -> None:
    few, more = seen(30, 0.01), seen(60, 0.01, seed=1)
    state, command = np.zeros((1, 2)), np.zeros((1, 1))
    doubts = [
        gaussian_inverse(each, without_friction).predict(state, after(state, command))[1]
        for each in (few, few.and_also(more))
    ]
    assert doubts[1] < doubts[0]


def test_shapes_that_do_not_agree_are_refused() -> None:
    with pytest.raises(SamplesError, match="have the shapes"):
        Transitions(
            state=np.zeros((4, 2)), command=np.zeros((3, 1)), after=np.zeros((4, 2)), turns=PLAIN
        )
    with pytest.raises(SamplesError, match="no finite number"):
        Transitions(
            state=np.full((4, 2), np.nan),
            command=np.zeros((4, 1)),
            after=np.zeros((4, 2)),
            turns=PLAIN,
        )
    with pytest.raises(SettingError, match="the ridge is 0"):
        local_inverse(seen(30, 0.0), ridge=0.0)
