"""Joints' positions by where links were tracked, as by motion capture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Integers, Mask
from morph.body.follow import follow, leaders
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import RecordingError
from morph.record.noise import FEWEST, noise
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel, Note, Recording
from morph.sim.tangent import conjugate, product, rotation

STARTS = 40
"""Postures, drawn at random, from which the first one is sought."""
STEPS = 50
"""Most steps from one of them."""
NEXT, MOST_TURN = 3, 0.5
"""Most steps from one sample to the next, and how far one goes, rad or m."""
DAMPING = 1e-9
"""Damping of a step, as a share of the largest diagonal entry of its matrix."""
TOLD = 1e-6
"""Least curvature of the squared error along a joint that is told, as a share of the largest."""
ALIKE, SAME = 20.0, 0.1
"""Squared errors, over the noise, by which postures fit as well; rad or m within which they are
one."""
WRONG = 0.1
"""Largest error of poses, as a share of how much they move, that a description may leave."""
QUIET = 1e-6
"""Least noise of a pose, m or rad."""


def with_tracked_links(recording: Recording, robot: Robot) -> Recording:
    """Return a recording with positions of joints that no encoder read, by the poses of links.

    Each posture is the one from which the poses differ least, weighed by their noise: Gauss and
    Newton's method, from the last sample's. Joints of which the poses tell nothing stay unread. It
    is noted.

    Args:
        recording: What was recorded: `<link>.position.{x,y,z}`, `<link>.orientation.{w,x,y,z}`.
        robot: Its robot.

    Raises:
        RecordingError: The description cannot take the poses that were recorded.
    """
    channels = recording.channels
    lead = [each for each in robot.joints if each.mimic is None]
    unread = [e.name for e in lead if e.kind in {"hinge", "slide"} and not _read(channels, e.name)]
    free = {each.link for each in robot.joints if each.kind == "free"}
    links = [each.name for each in robot.links if each.name not in free]
    poses = [pose for link in links for pose in _Pose.all_of(channels, link)]
    if not unread or not poses:
        return recording
    model = spec_of(robot).compile()
    time = max((pose.time for pose in poses), key=len)
    start, end = (limit([each.time[at] for each in poses]) for limit, at in ((max, 0), (min, -1)))
    time = time[(time >= start) & (time <= end)]
    known = _known(model, robot, recording, time)
    if len(time) < FEWEST or known is None:
        return recording
    posture = _Posture(model, [model.joint(name).dofadr[0] for name in unread], poses)
    position, given = posture.followed(time, known, recording.name)
    results = [name for name, there in zip(unread, given, strict=True) if there]
    if not results:
        return recording
    more = {
        f"{name}.position": Channel(time=time, value=position[:, model.joint(name).qposadr[0]])
        for name in results
    }
    note = Note(
        what=f"the position of {', '.join(results)} is that of the tracked links",
        where=f"recording {recording.name}",
    )
    return replace(recording, channels={**channels, **more}, notes=(*recording.notes, note))


def _read(channels: Mapping[str, Channel], joint: str) -> bool:
    return f"{joint}.position" in channels


def _known(model: mujoco.MjModel, robot: Robot, recording: Recording, time: Array) -> Array | None:
    """Return postures, (samples, nq), with what was read; None where a free link was not."""
    result = np.tile(model.qpos0, (len(time), 1))
    for joint in robot.joints:
        at = model.joint(joint.name).qposadr[0]
        names = [f"{joint.name}.position"]
        if joint.kind == "free":
            names = [f"{joint.link}.position.{axis}" for axis in XYZ]
            names += [f"{joint.link}.orientation.{axis}" for axis in WXYZ]
            if any(name not in recording.channels for name in names):
                return None
        for place, name in enumerate(names):
            if name in recording.channels:
                result[:, at + place] = recording.channels[name].at(time)
    return result


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pose:
    """Where a link was, or how it was turned."""

    link: str
    time: Array
    value: Array
    """m, shape (samples, 3), or unit quaternions, shape (samples, 4)."""
    noise: float
    """Standard deviation, m or rad."""

    @classmethod
    def all_of(cls, channels: Mapping[str, Channel], link: str) -> list[_Pose]:
        """Return what was recorded of a link."""
        results = []
        for quantity, axes in (("position", XYZ), ("orientation", WXYZ)):
            some = [channels.get(f"{link}.{quantity}.{axis}") for axis in axes]
            parts = [part for part in some if part is not None]
            if len(parts) < len(axes) or len(parts[0].time) < FEWEST:
                continue
            time = parts[0].time
            value = np.stack([part.at(time) for part in parts], axis=1)
            if quantity == "orientation":
                # A quaternion and its opposite are one orientation.
                flips = np.sum(value[1:] * value[:-1], axis=1) < 0.0
                value[1:] *= np.cumprod(np.where(flips, -1.0, 1.0))[:, None]
                value /= np.linalg.norm(value, axis=1, keepdims=True)
            std = float(np.sqrt(np.mean([noise(time, each) ** 2 for each in value.T])))
            # A rotation vector is twice a quaternion's imaginary part.
            std = max(QUIET, 2.0 * std if quantity == "orientation" else std)
            results.append(cls(link=link, time=time, value=value, noise=std))
        return results

    @property
    def turns(self) -> bool:
        """Whether it is an orientation."""
        return len(self.value.T) == len(WXYZ)

    def at(self, time: Array) -> Array:
        """Return it at other times."""
        some = np.stack([np.interp(time, self.time, each) for each in self.value.T], axis=1)
        return some / np.linalg.norm(some, axis=1, keepdims=True) if self.turns else some


def _wrapped(change: Array, turns: Mask) -> Array:
    """Return changes of joints' positions, those of hinges of at most half a turn."""
    return change - np.where(turns, 2.0 * np.pi * np.round(change / (2.0 * np.pi)), 0.0)


class _Posture:
    """The posture of a model that fits the poses of links best."""

    def __init__(self, model: mujoco.MjModel, dofs: Sequence[int], poses: Sequence[_Pose]) -> None:
        self._model, self._data, self._poses = model, mujoco.MjData(model), poses
        self._dofs: Integers = np.array(dofs)
        self._places = model.jnt_qposadr[model.dof_jntid[self._dofs]]
        self._ties = leaders(model)

    def followed(self, time: Array, known: Array, name: str) -> tuple[Array, Mask]:
        """Return postures, shape (samples, nq), and which joints are told, shape (joints,).

        Raises:
            RecordingError: The best posture leaves too much of the poses.
        """
        poses = [pose.at(time) for pose in self._poses]
        begin, unique = self._first(known[0], [pose[0] for pose in poses])
        last, left = begin, np.zeros(len(poses))
        result, curvatures = known.copy(), np.empty((len(time), len(begin)))
        for at in range(len(time)):
            begin, last = 2.0 * begin - last, begin
            now = [pose[at] for pose in poses]
            begin, error, curvatures[at] = self._best(known[at], begin, now, NEXT)
            result[at] = self._data.qpos
            left += np.sum(error**2, axis=1) / len(time)
        self._check(poses, np.sqrt(left) * [pose.noise for pose in self._poses], name)
        least = np.quantile(curvatures, 0.01, axis=0)
        return result, unique & (least > TOLD * curvatures.max())

    def _first(self, known: Array, poses: Sequence[Array]) -> tuple[Array, Mask]:
        """Return the best first posture, and which joints all that are as good agree on."""
        model, joints = self._model, self._model.dof_jntid[self._dofs]
        turns = model.jnt_type[joints] == mujoco.mjtJoint.mjJNT_HINGE
        limited = model.jnt_limited[joints][:, None] > 0
        low, high = np.where(limited, model.jnt_range[joints], (-np.pi, np.pi)).T
        drawn = np.random.default_rng(0).uniform(low, high, (STARTS, len(low)))
        home = model.qpos0[self._places]
        tries = [self._best(known, each, poses, STEPS) for each in (home, *drawn)]
        wrong = np.array([np.sum(error**2) for _, error, _ in tries])
        alike = np.array([tries[at][0] for at in np.flatnonzero(wrong < wrong.min() + ALIKE)])
        apart = _wrapped(alike - alike[0], turns)
        # Of angles that differ by whole turns that nearest to the described pose.
        begin = home + _wrapped(tries[int(wrong.argmin())][0] - home, turns)
        return begin, np.ptp(apart, axis=0) < SAME

    def _check(self, poses: Sequence[Array], left: Array, name: str) -> None:
        """Refuse poses that are not those of the links by a description."""
        for pose, values, rms in zip(self._poses, poses, left, strict=True):
            spread = np.sqrt(np.sum(np.var(values, axis=0))) * (2.0 if pose.turns else 1.0)
            if rms > max(WRONG * spread, 10.0 * pose.noise):
                unit, what = ("rad", "orientation") if pose.turns else ("m", "position")
                raise RecordingError(
                    f"the best posture of the description is {rms:.3g} {unit} off, of a motion of "
                    f"{spread:.3g} {unit}",
                    where=f"recording {name}, {pose.link}.{what}",
                    fix="give poses of the frame of that link in the description, in the frame of "
                    "its world; a marker elsewhere on the link, or a camera's frame, needs its "
                    "offset taken off; or leave the channel out",
                )

    def _best(
        self, known: Array, begin: Array, poses: Sequence[Array], steps: int
    ) -> tuple[Array, Array, Array]:
        """Return joints' positions, the errors, and their squares' curvature by joint.

        The curvature is that along a joint of which no other undoes the motion.
        """
        joints = np.array(begin)
        for _ in range(steps):
            error, inverse, gradient = self._errors(known, joints, poses)
            step = inverse @ gradient
            step *= min(1.0, MOST_TURN / (np.abs(step).max() + 1e-300))
            joints = joints + step
            if np.abs(step).max() < 1e-9:
                break
        error, inverse, _ = self._errors(known, joints, poses)
        return joints, error, 1.0 / np.diag(inverse)

    def _errors(
        self, known: Array, joints: Array, poses: Sequence[Array]
    ) -> tuple[Array, Array, Array]:
        """Return poses less those of a posture over their noise, shape (poses, 3).

        With them the inverse of the matrix of Gauss and Newton's method, and its right side.
        """
        model, data, ties = self._model, self._data, self._ties
        data.qpos[:] = known
        data.qpos[self._places] = joints
        follow(model, data.qpos[None], np.zeros((1, model.nv)))
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        error, rows = np.empty((len(poses), 3)), np.zeros((len(poses), 2, 3, model.nv))
        for at, (pose, value) in enumerate(zip(self._poses, poses, strict=True)):
            body = model.body(pose.link).id
            mujoco.mj_jacBody(model, data, rows[at, 0], rows[at, 1], body)
            rows[at, 0] = rows[at, int(pose.turns)] / pose.noise
            apart = (
                rotation(product(value, conjugate(data.xquat[body])))
                if pose.turns
                else value - data.xpos[body]
            )
            error[at] = apart / pose.noise
        by = rows[:, 0].reshape(-1, model.nv)
        for joint, (leader, ratio, _) in ties.items():
            by[:, model.jnt_dofadr[leader]] += ratio * by[:, model.jnt_dofadr[joint]]
        by = by[:, self._dofs]
        matrix = by.T @ by
        matrix += DAMPING * (np.diag(matrix).max() + 1e-300) * np.eye(len(matrix))
        return error, np.linalg.inv(matrix), by.T @ error.reshape(-1)
