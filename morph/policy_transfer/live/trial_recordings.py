"""Trials saved as recordings, for a later diagnosis."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.policy.observing import addresses
from morph.record.recording import Channel, Recording
from morph.record.write import write
from morph.search.target import Experience


def last_kept(folder: Path | None) -> int:
    """Return the number of the last trial that a folder keeps; 0 if there is none."""
    if folder is None or not folder.is_dir():
        return 0
    results = (re.fullmatch(r"trial_(\d+)\.npz", file.name) for file in folder.iterdir())
    return max((int(match[1]) for match in results if match), default=0)


def write_trial(
    shown: Experience, clock: Array, robot: Robot, model: Any, folder: Path, number: int
) -> Path:
    """Return the file to which a trial is written, under canonical names.

    Args:
        shown: What it showed.
        clock: When each state came, s, shape (samples,); not used if it does not increase.
        robot: The body.
        model: Its compiled `mujoco.MjModel`.
        folder: Where trials are kept.
        number: Which trial it is.

    Raises:
        OutputError: The file cannot be written.
    """
    if not (np.diff(clock) > 0.0).all():
        clock = np.asarray(shown.period * np.arange(len(clock)), dtype=float)
    state = np.concatenate([shown.position, shown.velocity], axis=1)
    channels = {
        name: Channel(time=clock, value=state[:, at])
        for name, at in addresses(robot, model).items()
    }
    for index, actuator in enumerate(robot.actuators):
        channels[f"{actuator.name}.command"] = Channel(
            time=clock[:-1], value=shown.command[:, index], hold=True
        )
    name = f"trial_{number:04d}"
    return write(Recording(name=name, channels=channels), folder / f"{name}.npz")
