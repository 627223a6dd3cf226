from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy_transfer.live.watch import Watch, Watcher
from morph.task.task import Task


def watcher(swing: Task, *, timed: bool = False, **settings: float) -> Watcher:
    model = swing.simulator().model
    return Watcher(Watch(**settings), swing.robot, model, 0.05, timed=timed)  # type: ignore[arg-type]


def noisy(rows: int) -> Array:
    return np.random.default_rng(100).normal(size=(rows, 4))


def first_wrong(states: Array, times: list[float] | None, watch: Watcher) -> tuple[int, str]:
    for at, state in enumerate(states):
        wrong = watch.saw(state, None if times is None else times[at], 0.0)
        if wrong is not None:
            return at, wrong
    return -1, ""


def test_ten_readings_alike_are_a_dead_sensor_and_nine_are_none(swing: Task) -> None:
    states = noisy(40)
    states[20:29, 1] = 0.3
    assert first_wrong(states, None, watcher(swing))[0] == -1
    states[29, 1] = 0.3
    at, wrong = first_wrong(states, None, watcher(swing))
    assert (at, wrong[:14]) == (29, "hinge.position")


def test_readings_alike_mean_nothing_where_they_are_said_to(swing: Task) -> None:
    assert first_wrong(np.zeros((40, 4)), None, watcher(swing, repeats=0))[0] == -1


def test_a_steady_clock_with_little_jitter_is_regular(swing: Task) -> None:
    rng = np.random.default_rng(101)
    # Gaps vary by at most 2 * 2 ms = 8 % of 50 ms, below the 10 % that count.
    times = (0.05 * np.arange(40) + rng.uniform(-0.002, 0.002, 40)).tolist()
    watch = watcher(swing)
    assert first_wrong(noisy(40), times, watch)[0] == -1
    assert watch.irregular == 0
    assert watch.latest < 0.005


def test_a_late_state_is_counted_and_a_lost_one_is_the_end(swing: Task) -> None:
    times = 0.05 * np.arange(40)
    late = times.copy()
    late[20] += 0.01
    watch = watcher(swing)
    assert first_wrong(noisy(40), late.tolist(), watch)[0] == -1
    # The gap before it is 60 ms and the gap after it 40 ms: both are off by 20 %.
    assert watch.irregular == 2
    assert watch.latest == pytest.approx(0.01)
    lost = np.delete(times, 20).tolist()
    at, wrong = first_wrong(noisy(39), lost, watcher(swing))
    assert at == 20
    assert wrong == "0.1 s lie between two states that should be 0.05 s apart: a state is lost"


@pytest.mark.parametrize(
    ("second", "says"),
    [(0.0, "repeated or swapped"), (-0.05, "swapped"), (0.01, "its rate is another")],
)
def test_time_that_does_not_go_on_is_the_end(swing: Task, second: float, says: str) -> None:
    at, wrong = first_wrong(noisy(2), [0.0, second], watcher(swing))
    assert at == 1
    assert says in wrong


def test_a_time_that_is_no_number_is_the_end(swing: Task) -> None:
    assert first_wrong(noisy(1), [float("nan")], watcher(swing))[1].startswith("its state says no")


def test_states_without_a_time_are_timed_by_their_coming_if_the_target_keeps_time(
    swing: Task,
) -> None:
    come = [0.0, 0.05, 0.2]
    found = []
    for timed in (False, True):
        watch = watcher(swing, timed=timed)
        wrong = [watch.saw(s, None, c) for s, c in zip(noisy(3), come, strict=True)]
        found.append(wrong[-1] is not None)
    assert found == [False, True]


@pytest.mark.parametrize("settings", [{"answer_within": 0.0}, {"repeats": 1}, {"lost": 1.0}])
def test_settings_that_are_none_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(TransferError, match=r"watch of a live target"):
        Watch(**settings)  # type: ignore[arg-type]
