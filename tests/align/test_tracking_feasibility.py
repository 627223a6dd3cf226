"""How much of a trajectory a target can follow."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.errors import SettingError
from morph.alignment.inverse import GaussianInverse
from morph.alignment.samples import Transitions
from morph.alignment.tracking_feasibility import following

PLAIN = np.array([False, False])


def circle(rows: int = 60, speed: float = 1.0, phase: float = 0.0) -> Transitions:
    at = phase + np.linspace(0.0, 2.0 * np.pi, rows)
    state = np.stack([np.cos(at), np.sin(at)], axis=1)
    move = 0.1 * speed * np.stack([-np.sin(at), np.cos(at)], axis=1)
    command = np.zeros((rows, 1))
    return Transitions(state=state, command=command, after=state + move, turns=PLAIN)


def test_what_was_seen_itself_can_be_followed() -> None:
    assert set(following(circle(), circle(phase=0.02)).share.values()) == {1.0}


def test_half_a_circle_that_was_seen_is_half_followed() -> None:
    whole, half = circle(120), circle(120)
    part = Transitions(
        state=half.state[:60], command=half.command[:60], after=half.after[:60], turns=PLAIN
    )
    found = following(whole, part, near=0.1).share
    # Sixty steps, and those beyond the ends that are still within a tenth of a spread.
    assert found["euclidean"] == pytest.approx(0.5, abs=0.06)
    assert found["relative"] == pytest.approx(0.5, abs=0.06)


def test_steps_of_another_size_are_told_by_the_relative_metric() -> None:
    # A change of 1.4 of the other differs by 0.4 / 1.4 = 0.29 of itself, over 0.25.
    found = following(circle(speed=1.4), circle(), near=0.5)
    assert found.share["relative"] == 0.0
    assert following(circle(speed=1.2), circle(), near=0.5).share["relative"] == 1.0


def test_noise_alone_does_not_make_a_step_another() -> None:
    rng = np.random.default_rng(0)
    clean = circle()
    noisy = Transitions(
        state=clean.state + 0.01 * rng.normal(size=(60, 2)),
        command=clean.command,
        after=clean.after + 0.01 * rng.normal(size=(60, 2)),
        turns=PLAIN,
    )
    assert following(clean, noisy, noise=0.01).share["relative"] > 0.95


def test_bounds_forbid_what_inverse_dynamics_ask_for() -> None:
    def asked(state, after):
        return 10.0 * state[:, :1]

    inverse = GaussianInverse(turns=PLAIN, guess=asked, missed=(_Nothing(),))
    low, high = np.array([-5.0]), np.array([5.0])
    found = following(circle(601), circle(601), inverse=inverse, low=low, high=high)
    # |10 cos| <= 5 on a third of the circle.
    assert found.share["permitted"] == pytest.approx(1.0 / 3.0, abs=0.01)


class _Nothing:
    def predict(self, x):
        return np.zeros(len(x)), np.zeros(len(x))


def test_thresholds_that_are_none_are_refused() -> None:
    with pytest.raises(SettingError, match="near is 0"):
        following(circle(), circle(), near=0.0)
