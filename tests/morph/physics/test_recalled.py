"""Rollouts that start within a recording go on as that did."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.effect_memory import recalled
from morph.model.episodes import episode
from morph.model.hypothesis import Hypothesis
from morph.model.segments import cut
from morph.physics.actuator.thermal_derating import ThermalDerating
from morph.record.recording import Channel, Recording
from morph.sim.rollout import rollout
from morph.sim.simulator import Simulator

STEP = 0.002


def test_a_rollout_from_within_a_run_goes_on_as_hot_as_the_run(
    wheels: Callable[..., Robot],
) -> None:
    effect = ThermalDerating(actuator="axle", floor=0.2, rate=1.0, level=0.3)
    another = replace(effect, rate=0.2)
    robot = wheels()
    time = STEP * np.arange(2001)
    sent = {"axle": 0.4 * np.sin(3.0 * time), "second": 0.1 * np.cos(2.0 * time)}
    command = {name: Channel(time=time, value=value, hold=True) for name, value in sent.items()}
    run = Simulator(robot, (effect,), step=STEP).run(seconds=4.0, command=command)
    channels = {
        name: channel for name, channel in run.channels.items() if name.endswith(".position")
    } | {f"{name}.command": channel for name, channel in command.items()}
    read = episode(Recording(name="run", channels=channels), robot, STEP)
    hypothesis = Hypothesis(robot=robot, step=STEP, knobs=(), effects=(effect,))
    variant, segments = hypothesis.at(hypothesis.start), cut([read], 0.5)
    assert len(segments) == 8
    which = np.zeros((1, 8), dtype=int)
    states = recalled(hypothesis, segments, [variant], which)
    begin = [run.channel(f"axle.{what}").value for what in ("position", "velocity")]
    other = [run.channel(f"second.{what}").value for what in ("position", "velocity")]
    place, speed = (
        np.stack(both, axis=1)[segments.first] for both in zip(begin, other, strict=True)
    )
    sent_then = segments.command([np.stack(list(sent.values()), axis=1)])
    on, _ = rollout([variant], which[0], place, speed, sent_then, states=states)
    anew, _ = rollout([variant], which[0], place, speed, sent_then)
    due = np.stack([begin[0][f : f + segments.steps + 1] for f in segments.first])
    # An episode's command is that about the start of each step, half a step early: 1.2 N m/s on
    # 0.25 kg m2 for 1 ms turn a wheel by at most 4.8e-3 rad/s2 * (0.5 s)^2 / 2 = 6e-4 rad.
    assert on[:, :, 0] == pytest.approx(due, abs=6e-4)
    # Begun anew, a motor is cold: that shows.
    assert np.abs(anew[1:, -1, 0] - due[1:, -1]).max() > 0.01
    # Of two versions at once each remembers its own.
    changed = replace(hypothesis, effects=(another,))
    versions = [variant, changed.at(changed.start)]
    both = recalled(hypothesis, segments, versions, np.array([[0] * 8, [1] * 8]))[0]
    alone = recalled(changed, segments, versions[1:], which)[0]
    assert np.array_equal(both, np.concatenate([states[0], alone], axis=-1))
    assert not np.allclose(states[0], alone)
