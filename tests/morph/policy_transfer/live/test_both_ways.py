"""Limits hold in both directions, and a count of repetitions begins anew."""

from __future__ import annotations

import numpy as np

from morph.policy_transfer.live.limits import LimitGuard, Limits
from morph.policy_transfer.live.watch import Watch, Watcher
from morph.task.task import Task


def test_a_command_falls_no_faster_than_it_may_rise(swing: Task) -> None:
    # 40 N/s for 0.05 s are 2 N, down as up.
    limits = Limits(rate={"slide": 40.0})
    guard = LimitGuard(limits, swing.robot, swing.simulator().model, swing.period)
    for sign in (1.0, -1.0):
        told, held = guard.allowed(np.array([sign * 7.0]), np.zeros(1))
        assert told.tolist() == [sign * 2.0]
        assert held.tolist() == [True]


def test_readings_that_repeat_five_times_twice_are_no_dead_sensor(swing: Task) -> None:
    # Ten readings alike are a dead sensor; five, another, and five again are none.
    states = np.random.default_rng(100).normal(size=(40, 4))
    for begin in (3, 9, 15, 21, 27):
        states[begin : begin + 5, 1] = 0.3
    watch = Watcher(Watch(), swing.robot, swing.simulator().model, 0.05, timed=False)
    assert [wrong for state in states if (wrong := watch.saw(state, None, 0.0))] == []
