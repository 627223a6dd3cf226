"""Positions of unread joints in closed chains, from the closure constraints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import chains
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import RecordingError
from morph.record.recording import Channel, Note, Recording

STEPS, FIRST = 5, 50
"""Most Gauss-Newton steps to where chains close: from the last sample, and from home."""
TOLD = 1e-6
"""Least singular value of the chains' closure by the unread joints, as a share of the largest, of
joints that it tells."""
OPEN = 1e-3
"""By how much a chain may stay open, m."""


def with_chains(recording: Recording, robot: Robot) -> Recording:
    """Return a recording with the positions of unread joints of closed chains.

    Each is where the chains close by the joints that were read, next to the last sample's posture:
    Gauss and Newton's method. Joints that closure does not tell stay unread. It is noted.

    Raises:
        RecordingError: The chains do not close at the positions that were read.
    """
    model = spec_of(robot).compile()
    held = chains(model)
    hinges = [each.name for each in robot.joints if each.kind in {"hinge", "slide"}]
    read = [name for name in hinges if f"{name}.position" in recording.channels]
    unread = [name for name in hinges if name not in read]
    if not held or not unread or not read:
        return recording
    tracks = [recording.channel(f"{name}.position") for name in read]
    first = tracks[0].time
    places = [int(model.joint(name).qposadr[0]) for name in read]
    dofs = [int(model.joint(name).dofadr[0]) for name in unread]
    closure = _Closure(model, held)
    given = closure.told(dofs)
    if not given:
        return recording
    posture = np.array(model.qpos0)
    result, steps = np.empty((len(first), len(given))), FIRST
    at = np.stack([track.at(first) for track in tracks], axis=1)
    for sample, values in enumerate(at):
        posture[places] = values
        gap = closure.close(posture, given, steps)
        if not gap < OPEN:
            raise RecordingError(
                f"a closed chain stays {1e3 * gap:.2g} mm open at {first[sample]:.3f} s by the "
                f"positions of {', '.join(read[:4])} that were read",
                where=f"recording {recording.name}",
                fix="check the zeros and signs of these joints against the description",
            )
        steps = STEPS
        result[sample] = posture[[int(model.jnt_qposadr[model.dof_jntid[dof]]) for dof in given]]
    names = [model.joint(int(model.dof_jntid[dof])).name for dof in given]
    channels = {
        f"{name}.position": Channel(time=first, value=values, guess=0.0)
        for name, values in zip(names, result.T, strict=True)
    }
    note = Note(
        what=f"positions of {', '.join(names)} follow from where closed chains close",
        where=f"recording {recording.name}",
    )
    return replace(
        recording,
        channels={**recording.channels, **channels},
        notes=(*recording.notes, note),
    )


class _Closure:
    """How far chains are open, by the places of joints."""

    def __init__(self, model: Any, held: list[int]) -> None:
        self._model, self._data, self._held = model, mujoco.MjData(model), held

    def told(self, dofs: list[int]) -> list[int]:
        """Return those of some degrees of freedom that closure tells, others being known."""
        self._data.qpos[:] = self._model.qpos0
        jacobian = self._at()[1][:, dofs]
        _, size, turn = np.linalg.svd(jacobian)
        free = turn[int((size > TOLD * size.max(initial=1e-12)).sum()) :]
        return [dof for at, dof in enumerate(dofs) if not (np.abs(free[:, at]) > 1e-3).any()]

    def close(self, posture: Array, dofs: list[int], steps: int) -> float:
        """Move some joints of a posture to where the chains close; return what stays open, m."""
        model, data = self._model, self._data
        step = np.zeros(model.nv)
        for _ in range(steps):
            data.qpos[:] = posture
            gap, jacobian = self._at()
            if float(np.abs(gap).max()) < 1e-9:
                break
            step[dofs] = -np.linalg.lstsq(jacobian[:, dofs], gap, rcond=TOLD)[0]
            mujoco.mj_integratePos(model, posture, step, 1.0)
        data.qpos[:] = posture
        return float(np.abs(self._at()[0]).max())

    def _at(self) -> tuple[Array, Array]:
        """Return by how much the chains are open, and how that changes with each joint."""
        model, data = self._model, self._data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        gaps, rows = [], []
        for each in self._held:
            (here, first), (there, second) = self._points(each)
            one, other = np.zeros((2, 3, model.nv))
            mujoco.mj_jac(model, data, one, None, here, first)
            mujoco.mj_jac(model, data, other, None, there, second)
            gaps.append(here - there)
            rows.append(one - other)
        return np.concatenate(gaps), np.concatenate(rows)

    def _points(self, held: int) -> Iterator[tuple[Array, int]]:
        """Yield both points that a constraint holds together, in the world, and their bodies."""
        model, data = self._model, self._data
        for side, at in enumerate((model.eq_obj1id[held], model.eq_obj2id[held])):
            if model.eq_objtype[held] == mujoco.mjtObj.mjOBJ_SITE:
                yield np.array(data.site_xpos[at]), int(model.site_bodyid[at])
            else:
                local = model.eq_data[held, 3 * side : 3 * side + 3]
                turned = data.xmat[at].reshape(3, 3) @ local
                yield data.xpos[at] + turned, int(at)
