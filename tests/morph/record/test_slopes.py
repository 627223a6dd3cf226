from __future__ import annotations

import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.slopes import slopes


def jittered(rng: np.random.Generator, seconds: float, rate: float) -> np.ndarray:
    even = np.arange(0.0, seconds, 1.0 / rate)
    return even + rng.uniform(-0.2, 0.2, len(even)) / rate


def test_slopes_of_a_sine_are_its_derivatives() -> None:
    time = jittered(np.random.default_rng(0), 4.0, 500.0)
    w = 2.0 * np.pi * 1.5
    smoothed, velocity, acceleration = slopes(time, np.sin(w * time), 20.0)
    inside = (time > 0.3) & (time < 3.7)
    # The filter's amplitude at 1.5 Hz: 1 / (1 + 0.414 (1.5 / 20)^8) is 1 to within 1e-9. What is
    # left is the cubic interpolation's error, (w h)^4 / 384 = 3e-10 of the amplitude.
    assert np.abs(smoothed - np.sin(w * time))[inside].max() < 1e-5
    assert np.abs(velocity - w * np.cos(w * time))[inside].max() < 1e-4 * w
    assert np.abs(acceleration + w**2 * np.sin(w * time))[inside].max() < 1e-3 * w**2


def test_the_response_is_three_decibels_down_at_the_cutoff() -> None:
    time = np.arange(0.0, 10.0, 0.002)
    smoothed, _, _ = slopes(time, np.sin(2.0 * np.pi * 20.0 * time), 20.0)
    inside = smoothed[1000:-1000]
    # A sine's root mean square is 1 / sqrt(2) of its amplitude, which is 1 / sqrt(2) at -3 dB.
    assert np.sqrt(np.mean(inside**2)) == pytest.approx(0.5, rel=2e-3)


def test_noise_is_smoothed_away_without_delay() -> None:
    rng = np.random.default_rng(3)
    time = jittered(rng, 10.0, 500.0)
    w = 2.0 * np.pi
    _, velocity, _ = slopes(time, np.sin(w * time) + rng.normal(0.0, 1e-3, len(time)), 10.0)
    # White noise of 1e-3 through a low-pass at 10 Hz leaves a velocity error of
    # 1e-3 * 2 pi sqrt(2 * 10^3 / 3 / 500) = 0.007 rad/s; the ends are allowed three times that.
    assert np.std(velocity - w * np.cos(w * time)) < 0.02


def test_slopes_of_several_channels_are_those_of_each() -> None:
    time = np.arange(0.0, 2.0, 0.01)
    both = np.stack([np.sin(3.0 * time), time**2], axis=1)
    for together, alone in zip(
        slopes(time, both, 10.0), slopes(time, both[:, 1], 10.0), strict=True
    ):
        assert np.allclose(together[:, 1], alone, atol=1e-10)


def test_samples_that_almost_coincide_do_not_spoil_the_slope() -> None:
    time = np.arange(0.0, 2.0, 0.01)
    time[100] = time[99] + 1e-8
    value = 0.5 * time
    value[100] += 1e-3
    _, velocity, _ = slopes(time, value, 10.0)
    # The jump of 1e-3 within 1e-8 s is a slope of 1e5 if taken at its word.
    assert np.abs(velocity - 0.5).max() < 0.1


@pytest.mark.parametrize("cutoff", [0.0, 50.0, float("nan")])
def test_a_cutoff_beyond_half_the_rate_is_refused(cutoff: float) -> None:
    time = np.arange(0.0, 1.0, 0.01)
    with pytest.raises(RecordingError, match=r"the cutoff is .* between 0 and 50 Hz"):
        slopes(time, time, cutoff)
