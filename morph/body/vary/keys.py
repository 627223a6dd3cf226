"""Keyframes that outlive a change of a body's joints."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from morph.arrays import Array

Pose = dict[str, dict[str, Array]]
"""For `qpos`, `qvel` and `ctrl`, the numbers of each joint or actuator."""


@contextmanager
def keeping_keys(spec: Any) -> Iterator[None]:
    """Keep, while joints come and go, what keyframes say of those that stay.

    A joint or actuator that is new stands where it stands without a keyframe.
    """
    if not spec.keys:
        yield
        return
    layout = _layout(spec.copy())
    poses = [_read(key, layout) for key in spec.keys]
    for key in spec.keys:
        key.qpos, key.qvel, key.act, key.ctrl = [], [], [], []
    yield
    after = _layout(spec.copy())
    for key, pose in zip(spec.keys, poses, strict=True):
        _write(key, pose, after)


def scale_keys(spec: Any, lengths: dict[str, float]) -> None:
    """Multiply the positions of slides and free joints in every keyframe, by joint."""
    if not spec.keys:
        return
    _, layout = _layout(spec.copy())
    for key in spec.keys:
        position = np.array(key.qpos)
        for name, factor in lengths.items():
            place = layout["qpos"][name]
            if position.size:
                position[place.start : min(place.start + 3, place.stop)] *= factor
        key.qpos = position


def _layout(spec: Any) -> tuple[Any, dict[str, dict[str, slice]]]:
    model = spec.compile()
    joints = [model.joint(index) for index in range(model.njnt)]
    widths = {0: (7, 6), 1: (4, 3), 2: (1, 1), 3: (1, 1)}
    places: dict[str, dict[str, slice]] = {"qpos": {}, "qvel": {}, "ctrl": {}}
    for joint in joints:
        wide, free = widths[int(joint.type[0])]
        places["qpos"][joint.name] = slice(int(joint.qposadr[0]), int(joint.qposadr[0]) + wide)
        places["qvel"][joint.name] = slice(int(joint.dofadr[0]), int(joint.dofadr[0]) + free)
    for index in range(model.nu):
        places["ctrl"][model.actuator(index).name] = slice(index, index + 1)
    return model, places


def _read(key: Any, layout: tuple[Any, dict[str, dict[str, slice]]]) -> Pose:
    return {
        field: {name: np.array(getattr(key, field))[place] for name, place in places.items()}
        for field, places in layout[1].items()
        if len(getattr(key, field))
    }


def _write(key: Any, pose: Pose, layout: tuple[Any, dict[str, dict[str, slice]]]) -> None:
    model, places = layout
    start = {"qpos": model.qpos0, "qvel": np.zeros(model.nv), "ctrl": np.zeros(model.nu)}
    for field, values in pose.items():
        vector = np.array(start[field])
        for name, place in places[field].items():
            if name in values and values[name].size == place.stop - place.start:
                vector[place] = values[name]
        setattr(key, field, vector)
