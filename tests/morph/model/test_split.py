from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.episodes import episode, step_for
from morph.model.segments import EDGE, scored_segments
from morph.model.split import LEAD, between, split
from morph.record.recording import Channel, Recording


def recording(name: str, session: str = "", seconds: float = 8.0) -> Recording:
    """Return positions at 100 Hz that say their own time, and a command every second."""
    time = 0.01 * np.arange(round(100 * seconds) + 1)
    told = np.arange(0.5, seconds)
    return Recording(
        name=name,
        session=session,
        channels={
            "hinge.position": Channel(time=time, value=time),
            "hinge.command": Channel(time=told, value=told, hold=True),
        },
    )


def names(recordings: tuple[Recording, ...]) -> list[str]:
    return [recording.name for recording in recordings]


def test_what_the_user_sets_aside_is_set_aside() -> None:
    parts = split([recording("a"), recording("b")], [recording("c")])
    assert (names(parts.train), names(parts.held_out)) == (["a", "b"], ["c"])
    assert parts.how == "as named"


def test_whole_sessions_are_set_aside_where_there_are_several() -> None:
    days = ["mon", "mon", "tue", "wed", "thu", "thu"]
    parts = split([recording(f"run_{n}", day) for n, day in enumerate(days)])
    # A quarter of four sessions is one: the last.
    assert names(parts.held_out) == ["run_4", "run_5"]
    assert names(parts.train) == ["run_0", "run_1", "run_2", "run_3"]
    assert parts.how == "by session"


@pytest.mark.parametrize(("count", "aside"), [(2, 1), (4, 1), (7, 1), (8, 2)])
def test_a_quarter_of_the_episodes_is_set_aside_within_a_session(count: int, aside: int) -> None:
    parts = split([recording(f"run_{n}") for n in range(count)])
    assert (len(parts.train), len(parts.held_out)) == (count - aside, aside)
    assert not set(names(parts.train)) & set(names(parts.held_out))
    assert parts.how == "by episode"


def test_the_last_quarter_of_a_lone_episode_is_set_aside() -> None:
    only = recording("run")
    parts = split([only])
    (train,), (aside,) = parts.train, parts.held_out
    # All channels run together from 0.5 s, the first command, to 8 s: a quarter is 1.875 s.
    middle = 0.5 + 0.75 * 7.5
    assert train["hinge.position"].max() == pytest.approx(middle, abs=0.0051)
    # Readings before it say how fast the rest starts.
    assert aside["hinge.position"].min() == pytest.approx(middle - LEAD, abs=0.0051)
    assert parts.how == "by time"


def test_a_held_command_keeps_what_it_held_when_a_stretch_begins() -> None:
    part = between(recording("run"), 3.2, 5.2)
    # Commands were sent at 2.5, 3.5 and 4.5 s; the one of 2.5 s still holds at 3.2 s.
    command = part.channel("hinge.command")
    assert command.value.tolist() == [2.5, 3.5, 4.5]
    assert command.at(np.array([3.2, 3.49, 3.51])).tolist() == [2.5, 2.5, 3.5]
    position = part.channel("hinge.position").time
    assert (position[0], position[-1]) == pytest.approx((3.2, 5.2), abs=0.011)
    assert np.diff(position) == pytest.approx(0.01, abs=1e-12)


def test_the_last_quarter_ends_with_the_recording() -> None:
    only = recording("run", seconds=4.0)
    (aside,) = split([only]).held_out
    assert aside["hinge.position"][-1] == only["hinge.position"][-1]


@pytest.mark.parametrize("seconds", [4.0, 4.4, 8.0])
def test_the_last_quarter_starts_as_fast_as_the_robot_was_then(
    cartpole: Robot, recorded: Callable[..., Recording], seconds: float
) -> None:
    only = recorded(cartpole, seconds=seconds, start={"hinge": 1.0}, noise=0.0)
    step = step_for([only], cartpole)
    whole, last = (episode(each, cartpole, step) for each in (only, *split([only]).held_out))
    segments = scored_segments([last], 1.0)
    begin = last.begin + segments.seconds(0)[0] + last.recording.start
    # The readings before are LEAD longer than EDGE; of a run with room for one rollout none is in
    # what was fitted, but for a reading of 0.01 s and a step.
    assert begin > 0.75 * seconds - (LEAD - EDGE if seconds > 5.0 else 0.0) - 0.015
    rates = [np.interp(begin - 0.5 * step, whole.time, rate) for rate in whole.state.T[2:]]
    # Between readings 10 ms apart lines are off by 0.01^2 / 8 of the second derivative, of 5 rad/s
    # at 5 rad/s: 1.6e-3. Without the readings before it, it is off by 0.2.
    assert segments.start[0, 2:] == pytest.approx(rates, abs=2e-3)
