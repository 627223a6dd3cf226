from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.clock import REST, SPEEDS, PlaybackClock


@pytest.mark.parametrize("speed", SPEEDS)
def test_time_passes_as_fast_as_the_speed_says(speed: float) -> None:
    clock = PlaybackClock(seconds=100.0, speed=speed)
    for _ in range(50):
        clock.tick(0.02)
    # Fifty ticks of 0.02 s are 1 s; fifty sums of doubles are off by at most 50 * 2^-53 * 4.
    assert clock.time == pytest.approx(speed, abs=1e-12)


@pytest.mark.parametrize("speed", [0.25, 1.0, 4.0])
def test_who_wakes_when_a_picture_is_due_misses_none_but_those_that_come_faster(
    speed: float,
) -> None:
    clock, rate, shown = PlaybackClock(seconds=2.0, speed=speed, looping=False), 60.0, []
    while clock.playing:
        passed = clock.due(rate) + 3e-4
        assert 3e-4 < passed <= 1.0 / rate + 3e-4
        clock.tick(passed)
        shown.append(int(clock.time * rate + 1e-6))
    # At four times the speed at most 60 a second are shown, and so about every fourth.
    assert max(b - a for a, b in itertools.pairwise([0, *shown])) <= max(1.0, speed) + 1
    if speed <= 1.0:
        assert set(range(1, 121)) <= set(shown)


def test_a_paused_clock_stands() -> None:
    clock = PlaybackClock(seconds=2.0, time=0.5, playing=False)
    clock.tick(1.0)
    assert clock.time == 0.5


def test_it_rests_at_the_end_before_it_begins_again() -> None:
    clock = PlaybackClock(seconds=1.0)
    clock.tick(5.0)
    assert clock.time == 1.0
    clock.tick(0.9 * REST)
    assert clock.time == 1.0
    clock.tick(0.2 * REST)
    assert clock.time == 0.0
    assert clock.playing


def test_a_clock_that_does_not_repeat_stops_at_the_end_and_plays_again_from_the_start() -> None:
    clock = PlaybackClock(seconds=1.0, looping=False)
    clock.tick(5.0)
    assert (clock.time, clock.playing) == (1.0, False)
    clock.toggle()
    assert (clock.time, clock.playing) == (0.0, True)


def test_a_step_pauses() -> None:
    clock = PlaybackClock(seconds=1.0, time=0.5)
    clock.step(0.1)
    assert (clock.time, clock.playing) == (0.6, False)


def test_a_shorter_content_takes_the_clock_back_to_its_end() -> None:
    clock = PlaybackClock(seconds=5.0, time=4.0)
    clock.lasts(2.0)
    assert (clock.time, clock.seconds) == (2.0, 2.0)


def test_a_clock_of_no_length_never_moves() -> None:
    clock = PlaybackClock()
    clock.tick(1.0)
    clock.seek(3.0)
    assert clock.time == 0.0


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("tick"), st.floats(0.0, 3.0)),
            st.tuples(st.just("seek"), st.floats(-10.0, 10.0)),
            st.tuples(st.just("step"), st.floats(-2.0, 2.0)),
            st.tuples(st.just("lasts"), st.floats(-1.0, 5.0)),
            st.tuples(st.just("toggle"), st.none()),
        ),
        max_size=30,
    )
)
def test_whatever_is_done_it_stays_within_its_range(acts: list[tuple[str, float | None]]) -> None:
    clock = PlaybackClock(seconds=3.0)
    for name, value in acts:
        if value is None:
            clock.toggle()
        else:
            getattr(clock, name)(value)
        assert 0.0 <= clock.time <= clock.seconds
