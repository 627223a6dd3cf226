from __future__ import annotations

import numpy as np
import pytest

from morph.record.recording import Channel
from morph.record.spikes import spikes, without_spikes


def swung(hertz: float, noise: float) -> Channel:
    """Return 10 s of a swing of 1 rad at 1 Hz that rests for its last 3 s."""
    time = np.arange(0.0, 10.0, 1.0 / hertz)
    value = np.sin(2.0 * np.pi * np.minimum(time, 7.0))
    return Channel(time=time, value=value + noise * np.random.default_rng(0).normal(size=len(time)))


@pytest.mark.parametrize("hertz", [30.0, 100.0, 500.0])
@pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-2])
def test_a_motion_with_its_noise_has_no_spike(hertz: float, noise: float) -> None:
    # At an extreme a reading is off the next by half of (2 pi / hertz)^2, below a third of the
    # largest step at 30 Hz; noise is off by 10 deviations in no sample of 5,000.
    assert not spikes(swung(hertz, noise)).any()


@pytest.mark.parametrize("size", [3.0, -3.0, 1.2])
def test_readings_that_jump_out_and_back_are_spikes_and_no_others(size: float) -> None:
    channel, wrong = swung(100.0, 1e-3), [25, 329, 330, 515, 850, 999]
    channel.value[wrong] += size
    assert np.flatnonzero(spikes(channel)).tolist() == wrong
    left = without_spikes(channel)
    assert len(left.time) == len(left.value) == 994
    assert not set(channel.time[wrong]) & set(left.time)


def test_a_step_that_stays_is_no_spike() -> None:
    channel = swung(100.0, 1e-3)
    channel.value[500:] += 3.0
    assert not spikes(channel).any()


def test_a_short_track_has_none() -> None:
    assert not spikes(Channel(time=np.arange(5.0), value=np.array([0.0, 0.0, 9.0, 0.0, 0.0]))).any()
