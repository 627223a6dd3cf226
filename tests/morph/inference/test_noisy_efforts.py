"""Noisy efforts in the place of commands: a pendulum by its own equation, not by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.model.derived_channels import by_effort
from morph.model.episodes import episode, fills
from morph.record.recording import Channel, Recording
from tests.morph.inference.test_rates import TIME, VISCOUS, moved

NOISE = 0.2
"""Of the sensor of torque, N m; motors give some 1 N m."""


def by_torque(seed: int, viscous: float) -> Recording:
    """Return what an encoder and a sensor of torque read, this midway between two commands."""
    command, angle, _ = moved(seed, viscous)
    rng = np.random.default_rng(200 + seed)
    effort = command + NOISE * rng.standard_normal(len(TIME))
    channels = {
        "hinge.position": Channel(time=TIME, value=angle + 1e-3 * rng.standard_normal(len(TIME))),
        "hinge.effort": Channel(time=TIME + 0.005, value=effort),
    }
    return Recording(name=f"run_{seed}", channels=channels)


def test_the_noise_of_an_effort_is_that_of_each_of_its_steps() -> None:
    robot = load("pendulum")
    laid = episode(by_effort(by_torque(0, 0.0), robot), robot, 0.0025)
    # Four steps share a reading: four independent errors of twice its noise move as far. Medians
    # of 797 third differences scatter by 5 %.
    assert laid.unsure == pytest.approx(2.0 * NOISE, rel=0.15)
    assert fills(laid) == []


def test_the_noise_of_an_effort_is_no_missing_force() -> None:
    runs = [by_torque(seed, VISCOUS) for seed in range(3)]
    found = diagnose(load("pendulum"), runs[:2], held_out=runs[2:])
    assert found.verdict == "mismatch"
    assert [each.effect.label for each in found.findings] == ["viscous_friction@hinge"]
    (estimate,) = found.findings[0].parameters.values()
    assert estimate.low90 < VISCOUS < estimate.high90


def test_a_lost_command_is_told_beside_noisy_ones() -> None:
    robot, run = load("pendulum"), by_effort(by_torque(0, 0.0), load("pendulum"))
    channel, kept = run.channels["hinge.command"], np.arange(len(TIME)) != 400
    part = replace(channel, time=channel.time[kept], value=channel.value[kept])
    laid = episode(replace(run, channels={**run.channels, "hinge.command": part}), robot, 0.0025)
    assert fills(laid) == ["commands that the logger lost are interpolated, gaps: 1"]
