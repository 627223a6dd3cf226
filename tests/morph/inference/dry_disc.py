"""A disc with dry friction: no code of morph or MuJoCo takes part in its motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from morph.body.robot import Robot
from morph.model.episodes import Episode, episode
from morph.record.recording import Channel, Recording

STEP, FINE, INERTIA = 0.004, 16, 0.02
"""Seconds between readings, steps of the integration in each, and the disc's inertia, kg m2."""


def turned(
    commands: Iterable[float],
    torque: Callable[[float, float, float], float],
    *,
    coulomb: float,
    angle: float = 0.0,
) -> list[float]:
    """Return the disc's angle when each command arrives, rad, from rest on.

    Args:
        commands: One in each step.
        torque: Of a command, the angle and the rate, N m.
        coulomb: Friction, N m.
        angle: At the start, rad.
    """
    rate, read, step = 0.0, [], STEP / FINE
    for now in commands:
        read.append(angle)
        for _ in range(FINE):
            moved = rate + step * torque(now, angle, rate) / INERTIA
            # Friction stops the disc within a step, or takes all that it can.
            rate = np.sign(moved) * max(abs(moved) - step * coulomb / INERTIA, 0.0)
            angle += step * rate
    return read


def pushes(number: int, samples: int) -> list[float]:
    """Return torques that move the disc now and then: friction holds it for half the time."""
    time = STEP * np.arange(samples)
    push = 0.5 * np.sin((5.0 + number) * time) * (np.sin(1.1 * time + number) > 0.0)
    return list(push.round(6))


def pushed(robot: Robot, *, coulomb: float, samples: int, noise: float) -> list[Episode]:
    """Return four runs of the joint `axle` under the pushes of the actuator `motor`."""
    rng, time, episodes = np.random.default_rng(0), STEP * np.arange(samples), []
    for number in range(4):
        sent = pushes(number, samples)
        read = turned(sent, lambda u, q, v: u, coulomb=coulomb)
        channels = {
            "axle.position": Channel(time=time, value=read + noise * rng.normal(size=samples)),
            "motor.command": Channel(time=time, value=np.array(sent), hold=True),
        }
        recording = Recording(name=f"run_{number}", channels=channels)
        episodes.append(episode(recording, robot, STEP))
    return episodes
