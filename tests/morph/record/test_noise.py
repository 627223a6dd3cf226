from __future__ import annotations

import numpy as np
import pytest

from morph.errors import RecordingError
from morph.record.noise import moves, noise, noisy, quantum
from morph.record.recording import Channel, Recording


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_gaussian_noise_on_a_moving_joint_is_measured(jitter: float) -> None:
    rng = np.random.default_rng(0)
    time = (np.arange(5000) + rng.uniform(-jitter, jitter, 5000)) * 0.002
    value = np.sin(2.0 * np.pi * time) + rng.normal(0.0, 2e-4, 5000)
    # A median of 5000 dependent magnitudes is good to about 1.5 * 0.78 / sqrt(5000) = 2 %; motion
    # adds h^3 w^3 / sqrt(20) = 4e-7. Even weights would
    # take the jitter, 6 rad/s * 6e-4 s, as noise.
    assert noise(time, value) == pytest.approx(2e-4, rel=0.08)


def test_a_quantised_sine_is_as_noisy_as_its_rounding() -> None:
    time = np.arange(5000) * 0.002
    step = 2.0 * np.pi / 4096
    # At 2 rad/s and 500 Hz it moves 2.6 steps a sample, so roundings are independent.
    value = np.round(np.sin(2.0 * time) / step) * step
    assert quantum(value) == pytest.approx(step, rel=1e-9)
    # Rounding is uniform: its standard deviation is step / sqrt(12); estimates spread by its shape.
    assert step / np.sqrt(12.0) <= noise(time, value) < 1.5 * step / np.sqrt(12.0)


def test_a_joint_at_rest_is_as_noisy_as_its_rounding() -> None:
    time = np.arange(100) * 0.01
    value = np.where(np.arange(100) < 50, 0.1, 0.2)
    assert noise(time, value) == pytest.approx(0.1 / np.sqrt(12.0), rel=1e-9)


def test_a_smooth_signal_has_no_quantum() -> None:
    assert quantum(np.random.default_rng(0).normal(size=1000)) == 0.0


def test_a_constant_has_no_noise() -> None:
    assert noise(np.arange(20.0), np.full(20, 3.0)) == 0.0


def test_a_counter_that_toggles_at_rest_does_not_move() -> None:
    rng = np.random.default_rng(5)
    time, count = np.arange(2000) * 0.01, 2.0 * np.pi / 4096.0
    toggles = count * rng.integers(0, 2, 2000)
    assert not moves(time, toggles)
    assert not moves(time, rng.normal(scale=1e-3, size=2000))
    assert not moves(time, np.zeros(2000))
    # Twenty counts in twenty seconds is a motion.
    assert moves(time, count * np.round(time))


def test_positions_and_orientations_are_read_with_noise_and_velocities_are_not_read() -> None:
    time = np.arange(4000) * 0.01
    still = dict.fromkeys(["hinge.position", "hull.position.x", "hinge.velocity"], 0.0 * time)
    still |= {f"hull.orientation.{axis}": 0.0 * time for axis in "xyz"}
    still |= {"hull.orientation.w": 1.0 + 0.0 * time, "hull.angular_velocity.x": 0.0 * time}
    still |= {"motor.command": 0.0 * time}
    run = Recording(
        name="run", channels={name: Channel(time=time, value=v) for name, v in still.items()}
    )
    read = noisy(run, 0.01)
    assert set(read.channels) == {name for name in still if "velocity" not in name}
    assert not read["motor.command"].any()
    # The standard deviation of 4000 draws is itself known to 1.1 %: four of these.
    for name in ("hinge.position", "hull.position.x"):
        assert np.std(read[name]) == pytest.approx(0.01, rel=0.045)
    parts = np.stack([read[f"hull.orientation.{axis}"] for axis in "xyz"], axis=1)
    # The vector of a small rotation is twice the imaginary part.
    assert 2.0 * np.std(parts) == pytest.approx(0.01, rel=0.045)
    assert noisy(run, 0.0) is run
    with pytest.raises(RecordingError, match="out of range"):
        noisy(run, -0.1)
