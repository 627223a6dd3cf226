"""What a policy sees of a body's state: channels, offset and scaled, delayed, with their past."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from morph.arrays import Array, Integers
from morph.body.robot import Joint, Robot
from morph.errors import PolicyError
from morph.nearest import nearest
from morph.physics.effect import Effect
from morph.policy.fields import most_of
from morph.policy.policy import Observation, Policy
from morph.record.quantities import WXYZ, XYZ
from morph.sim.drive import sensed

ROTATION = (
    (0, "orientation", "1", WXYZ),
    (1, "angular_velocity", "rad/s", XYZ),
)
"""What is seen of a ball joint: of its position (0) or its velocity (1), with unit and axes."""

FLOATING = (
    (0, "position", "m", XYZ),
    ROTATION[0],
    (1, "linear_velocity", "m/s", XYZ),
    ROTATION[1],
)
"""What is seen of a floating body, likewise."""


def units(robot: Robot) -> dict[str, str]:
    """Return the unit of every channel that follows from the state of a body.

    First the positions of all joints in the body's order, then their velocities, named as
    recordings name them: a ball joint by its own name, relative to the link that it hangs from.
    """
    return {
        name: unit for rate in (0, 1) for joint in robot.joints for name, unit in _of(joint, rate)
    }


def _of(joint: Joint, rate: int) -> Iterator[tuple[str, str]]:
    """Yield name and unit of a joint's channels as MuJoCo orders them, of position or velocity."""
    if joint.kind in {"hinge", "slide"}:
        quantity, unit = (("position", joint.unit), ("velocity", f"{joint.unit}/s"))[rate]
        yield f"{joint.name}.{quantity}", unit
    elif joint.kind in {"free", "ball"}:
        part, known = (joint.link, FLOATING) if joint.kind == "free" else (joint.name, ROTATION)
        for whose, quantity, unit, axes in known:
            if whose == rate:
                yield from ((f"{part}.{quantity}.{axis}", unit) for axis in axes)


def observations_of(
    robot: Robot, channels: tuple[str, ...] | None = None
) -> tuple[Observation, ...]:
    """Return observations of some channels as they are; None for all that `units` names.

    Raises:
        PolicyError: The body has no such channel.
    """
    known = units(robot)
    names = tuple(known) if channels is None else channels
    return tuple(Observation(channel=name, unit=unit_of(robot, name)) for name in names)


def unit_of(robot: Robot, channel: str, *, where: str = "") -> str:
    """Return the unit of a channel that a policy may see.

    Raises:
        PolicyError: The body has no such channel, or it does not follow from the state.
    """
    known = units(robot)
    if channel not in known:
        raise PolicyError(
            f"it observes {most_of(channel)}, which the state of {robot.name} does not hold",
            where=where or f"a policy for {robot.name}",
            fix=f"the nearest channels are {nearest(channel, known)}",
        )
    return known[channel]


def check_channels(policy: Policy, robot: Robot, *, where: str) -> None:
    """Check that a body has every channel that a policy sees, in its unit.

    Raises:
        PolicyError: It lacks one, or has it in another unit.
    """
    for seen in policy.observation:
        unit = unit_of(robot, seen.channel, where=where)
        if seen.unit != unit:
            raise PolicyError(
                f"it observes {seen.channel} in {most_of(seen.unit)}, which is in {unit}",
                where=where,
                fix=f'write "unit": "{unit}", and convert by scale',
            )


def addresses(robot: Robot, model: Any) -> dict[str, int]:
    """Return where each channel of `units` stands in (qpos, qvel), one after the other."""
    results: dict[str, int] = {}
    for joint in robot.joints:
        here = model.joint(joint.name)
        starts = (int(here.qposadr[0]), model.nq + int(here.dofadr[0]))
        for rate, start in enumerate(starts):
            results |= {name: start + at for at, (name, _) in enumerate(_of(joint, rate))}
    return results


class Observer:
    """What a policy sees in many runs at once; it remembers, so each run needs a new one.

    Noise is that of the sensor: each reading has its own, which stays with it as it ages.

    Args:
        policy: Whose observations are made.
        robot: The body.
        model: Its compiled `mujoco.MjModel`.
        rows: How many runs there are.
        rng: The chance of the noise; None for none.
        noise: Standard deviation of every reading, in its unit.
        effects: What acts on the body; a biased sensor is seen biased.

    Raises:
        PolicyError: The body lacks a channel, a delay is no multiple of the control period,
            or the noise is negative.
    """

    def __init__(
        self,
        policy: Policy,
        robot: Robot,
        model: Any,
        rows: int,
        rng: np.random.Generator | None = None,
        noise: float = 0.0,
        effects: Sequence[Effect] = (),
    ) -> None:
        seen = policy.observation
        check_channels(policy, robot, where=f"a policy of kind {policy.kind}")
        if not 0.0 <= noise < math.inf:
            raise PolicyError(
                f"noise of {noise:g} is none", where="an observer", fix="give 0 or more"
            )
        where = addresses(robot, model)
        # One reading for each channel, however often it is seen: its noise is one.
        channels = list(dict.fromkeys(each.channel for each in seen))
        self._columns = np.array([where[name] for name in channels], dtype=np.int64)
        self._as_it_is = np.array_equal(self._columns, np.arange(model.nq + model.nv))
        self._rows, self._rng, self._noise = rows, rng, noise
        self._sensing = [each for each in effects if type(each).sense is not Effect.sense]
        self._channels = channels
        self._pick, self._age = _ages(policy, channels)
        numbers = [each for each in seen for _ in range(each.history)]
        self._offset = np.array([each.offset for each in numbers])
        self._scale = np.array([each.scale for each in numbers])
        self._plain = bool((self._offset == 0.0).all() and (self._scale == 1.0).all())
        self._newest = not self._age.any() and np.array_equal(
            self._pick, np.arange(len(self._columns))
        )
        self._past: Array | None = None

    def see(self, position: Array, velocity: Array) -> Array:
        """Return what is seen at the next control time, shape (rows, observations).

        Args:
            position: MuJoCo's `qpos`, shape (rows, nq).
            velocity: MuJoCo's `qvel`, shape (rows, nv).

        Raises:
            PolicyError: There are more or fewer runs than it was made for.
        """
        if len(position) != self._rows:
            raise PolicyError(
                f"it sees {len(position)} runs, and was made for {self._rows}",
                where="an observer",
                fix="make one for these runs",
            )
        reading = np.concatenate([position, velocity], axis=1)
        if not self._as_it_is:
            reading = reading[:, self._columns]
        if self._sensing:
            for at, channel in enumerate(self._channels):
                reading[:, at] = sensed(self._sensing, channel, reading[:, at])
        if self._rng is not None and self._noise > 0.0:
            reading += self._noise * self._rng.standard_normal(reading.shape)
        seen = reading if self._newest else self._remembered(reading)
        return seen if self._plain else np.asarray((seen - self._offset) / self._scale)

    def _remembered(self, reading: Array) -> Array:
        if self._past is None:
            depth = int(self._age.max(initial=0)) + 1
            self._past = np.repeat(reading[None], depth, axis=0)
        else:
            self._past[1:] = self._past[:-1].copy()
            self._past[0] = reading
        return np.asarray(self._past[self._age, :, self._pick].T)


def _ages(policy: Policy, channels: list[str]) -> tuple[Integers, Integers]:
    """Return for each number seen which channel it is, and how many periods old."""
    pick: list[int] = []
    age: list[int] = []
    for each in policy.observation:
        delay = each.delay_s / policy.period
        if abs(delay - round(delay)) > 1e-6:
            raise PolicyError(
                f"{each.channel} is {each.delay_s:g} s late, "
                f"and the control period is {policy.period:g} s",
                where=f"a policy of kind {policy.kind}",
                fix="give a delay that is a multiple of the control period",
            )
        pick += [channels.index(each.channel)] * each.history
        age += [round(delay) + past for past in range(each.history)]
    return np.array(pick, dtype=np.int64), np.array(age, dtype=np.int64)
