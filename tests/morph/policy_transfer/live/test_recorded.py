from __future__ import annotations

import math

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy_transfer.live.recorded import Recorded
from morph.record.recording import Channel, Recording
from morph.task.task import Task

CLOCK: Array = np.asarray(0.01 * np.arange(301), dtype=float)


def swung(**left_out: bool) -> Recording:
    """Return a recording at 100 Hz of a cart that goes as sin 2t, and a hinge that rests."""
    value = {
        "slide.position": np.sin(2.0 * CLOCK),
        "slide.velocity": 2.0 * np.cos(2.0 * CLOCK),
        "hinge.position": np.zeros(301),
        "hinge.velocity": np.zeros(301),
    }
    channels = {name: Channel(time=CLOCK, value=x) for name, x in value.items()}
    # It rises by 1 N every 25 ms: within a control period of 50 ms it has two values.
    told = np.floor(CLOCK[:-1] / 0.025 + 1e-6)
    channels["slide.command"] = Channel(time=CLOCK[:-1], value=told, hold=True)
    return Recording(
        name="by_hand", channels={n: c for n, c in channels.items() if n not in left_out}
    )


def test_nothing_can_be_tried_on_recordings(swing: Task) -> None:
    recorded = Recorded(task=swing, recordings=(swung(),))
    with pytest.raises(TransferError, match=r"nothing can be tried on recordings"):
        recorded.trial(np.zeros((10, 1)), np.random.default_rng(0))


def test_a_recording_becomes_a_run_at_the_control_times(swing: Task) -> None:
    (run,) = Recorded(task=swing, recordings=(swung(),)).runs()
    # The last command of the recording is at 2.99 s, and it holds on to 3 s.
    times = 0.05 * np.arange(61)
    np.testing.assert_allclose(run.position[:, 0], np.sin(2.0 * times), atol=1e-12)
    np.testing.assert_allclose(run.velocity[:, 0], 2.0 * np.cos(2.0 * times), atol=1e-12)
    # Samples every 10 ms: values 0 0 0 1 1 | 2 2 2 3 3 | ..., so the means are 2 k + 0.4.
    np.testing.assert_allclose(run.command[:, 0], 2.0 * np.arange(60) + 0.4, atol=1e-9)
    assert run.period == 0.05
    assert math.isfinite(run.loss)


def test_a_velocity_that_was_not_recorded_is_the_slope_of_its_position(swing: Task) -> None:
    (run,) = Recorded(task=swing, recordings=(swung(**{"slide.velocity": True}),)).runs()
    times = 0.05 * np.arange(61)
    # The filter's cutoff is 20 Hz and the motion's 0.3 Hz; its ends are less exact.
    inside = slice(5, -5)
    off = run.velocity[inside, 0] - 2.0 * np.cos(2.0 * times[inside])
    assert np.abs(off).max() < 1e-3


@pytest.mark.parametrize("name", ["hinge.position", "slide.command"])
def test_a_recording_that_lacks_a_channel_is_refused(swing: Task, name: str) -> None:
    recorded = Recorded(task=swing, recordings=(swung(**{name: True}),))
    with pytest.raises(TransferError, match=rf"it lacks {name}"):
        recorded.runs()


def test_a_recording_shorter_than_the_task_has_no_loss(swing: Task) -> None:
    whole = swung()
    short = Recording(
        name="short",
        channels={
            name: Channel(time=x.time[:31], value=x.value[:31], hold=x.hold)
            for name, x in whole.channels.items()
        },
    )
    (run,) = Recorded(task=swing, recordings=(short,)).runs()
    # 0.3 s of 0.5 s.
    assert len(run.position) == 7
    assert math.isnan(run.loss)
    assert not run.success


def test_a_recording_of_less_than_a_period_is_refused(swing: Task) -> None:
    tiny = Recording(
        name="tiny",
        channels={
            name: Channel(time=x.time[:4], value=x.value[:4], hold=x.hold)
            for name, x in swung().channels.items()
        },
    )
    with pytest.raises(TransferError, match=r"less than a control period of 0.05 s"):
        Recorded(task=swing, recordings=(tiny,)).runs()


def test_a_channel_that_dies_in_a_recording_is_named_with_its_time(swing: Task) -> None:
    rng = np.random.default_rng(100)
    whole = swung()
    noise = {"slide.position": 0.01, "slide.velocity": 0.01, "hinge.velocity": 0.01}
    value = {name: x.value + rng.normal(scale=noise.get(name, 0.0), size=len(x.value))
             for name, x in whole.channels.items()}  # fmt: skip
    value["hinge.position"] = rng.normal(scale=0.01, size=301)

    def repeated() -> tuple[str, ...]:
        channels = {
            name: Channel(time=x.time, value=value[name], hold=x.hold)
            for name, x in whole.channels.items()
        }
        recording = Recording(name="by_hand", channels=channels)
        return Recorded(task=swing, recordings=(recording,)).repeated()

    assert repeated() == ()
    # From 1 s to 1.42 s there are nine control times, and to 1.47 s ten.
    value["hinge.position"][100:143] = 0.3
    assert repeated() == ()
    value["hinge.position"][100:148] = 0.3
    (said,) = repeated()
    assert said.startswith("recording by_hand: hinge.position is the same number 10 times")
    assert "from 1 s on: a dead sensor" in said
