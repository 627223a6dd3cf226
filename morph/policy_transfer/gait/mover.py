"""A body that is to go ahead, as arrays: how fast patterns take it, and what its trunk does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.policy.policy import Action, Policy, actions_of
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.swim import swim
from morph.task.task import Task
from morph.task.torso import torso
from morph.task.walk import walk

FALLEN = 0.7
"""Least share of the trunk's upright axis that must stay upright on a floor: 45 degrees."""

WIDEST = 1.0
"""Farthest from rest that a servo is told to swing, rad."""

LEAD = 1.0
"""How long a rhythm has to settle before it is measured, s."""

SETTLE = 20
"""Control periods in which a body on a floor comes to rest before a servo swings."""

SHORTEST = 5
"""Fewest control periods in which a servo swings out and back."""

TWIST = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
"""What a trunk does, in its own frame: m/s and rad/s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mover:
    """A body of servos in its world, with what it has been tried for counted by nobody here."""

    task: Task
    """`swim` or `walk`: its world, start, horizon and control period."""
    trunk: str
    """The link that is to go ahead."""
    reach: float = WIDEST
    """Farthest from rest that a servo is told to swing, rad."""

    @cached_property
    def simulator(self) -> Simulator:
        """The body in its world."""
        return self.task.simulator()

    @property
    def robot(self) -> Robot:
        """The body."""
        return self.task.robot

    @property
    def wet(self) -> bool:
        """Whether it swims: then it may roll."""
        return self.task.name == "swim"

    @cached_property
    def action(self) -> tuple[Action, ...]:
        """What each servo takes, no farther from rest than `reach`."""
        return tuple(
            replace(one, low=max(one.low, -self.reach), high=min(one.high, self.reach))
            for one in actions_of(self.robot)
        )

    @property
    def trial(self) -> int:
        """How many control periods a trial lasts: so many samples it costs."""
        return self.task.samples - 1

    def speed(self, policies: Sequence[Policy]) -> Array:
        """Return how fast each policy takes the centre of mass the way the trunk faces, m/s.

        Both are means over the time after `LEAD`: how a rhythm begins, and which way that turns
        the body, is no part of it. A body on a floor is measured until it has fallen over, one
        that becomes unstable has a speed of 0.
        """
        seen = np.empty(0)

        def act(q: Array, v: Array, time: float) -> Array:
            now = np.asarray(time)
            return np.array([each.act(seen, now) for each in policies])

        moved = self._run(act, len(policies))
        mass = np.asarray(self.simulator.model.body_mass)
        x = np.zeros((*moved.position.shape[:-1], 3))
        for link in np.flatnonzero(mass):
            x += mass[link] / mass.sum() * moved.pose(int(link)).position
        x, turn = np.nan_to_num(x), moved.pose(self._body).rotation
        faces = np.nan_to_num(turn[..., 0])
        begin, end = round(LEAD / self.task.period), x.shape[1] - 1
        last = np.full(len(policies), end)
        if not self.wet:
            down = ~(turn[..., 2, 2] >= FALLEN)
            last = np.where(down.any(axis=1), np.maximum(down.argmax(axis=1), begin), end)
        gone = x[np.arange(len(x)), last] - x[:, begin]
        ahead = faces[:, begin:].mean(axis=1)
        ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 0.1)
        stable = np.ones(len(x), bool) if moved.stable is None else moved.stable
        way = np.einsum("ri,ri->r", gone, ahead) / (self.task.horizon - LEAD)
        return np.where(stable, way, 0.0)

    def transitions(
        self,
        count: int,
        rng: np.random.Generator,
        *,
        width: float = 0.5,
        noise: float = 1e-3,
    ) -> Transitions:
        """Return transitions of the trunk in short runs, in each of which one servo swings.

        The state is the twist of the trunk and then that of its far end, as an inertial unit
        with a speed over ground gives it at either; of a body of several limbs the far end is
        the trunk again. Every run begins at rest; its servo is told one bell, out and back, and
        the others hold: what swings at once hides behind each other, in bodies of many joints.

        Args:
            count: At most how many, shared among the servos.
            rng: The chance of the ways and of the noise.
            width: How far a servo is told to go, rad.
            noise: Standard deviation of every observation, m/s or rad/s.

        Raises:
            TransferError: There are too few for each servo to have a run of `SHORTEST`.
        """
        size, period = len(self.action), self.task.period
        # On a floor it first settles on legs that are bent: straight ones lift either way.
        lead = 0 if self.wet else SETTLE
        slot = count // size - lead
        if slot < SHORTEST:
            raise TransferError(
                f"{count} transitions are too few for {size} servos",
                where=f"transitions of {self.robot.name}",
                fix=f"take {(SHORTEST + lead) * size} or more",
            )
        way = rng.choice([-1.0, 1.0], size)
        low, high = (np.array([getattr(a, end) for a in self.action]) for end in ("low", "high"))
        middle = np.zeros(size) if self.wet else 0.5 * (low + high)

        def act(q: Array, v: Array, time: float) -> Array:
            into = max(0.0, round(time / period) - lead)
            bell = 0.5 * (1.0 - np.cos(2.0 * np.pi * into / slot))
            return np.clip(middle + np.diag(way * width * bell), low, high)

        moved = self._run(act, size, seconds=(lead + slot) * period)
        seen = [self._twists(moved, link) for link in (self._body, self._end)]
        twist = np.nan_to_num(np.concatenate(seen, axis=2))
        twist = twist + noise * rng.standard_normal(twist.shape)
        if self._end == self._body:
            # One unit, with one noise.
            twist[..., 6:] = twist[..., :6]
        before = np.concatenate([np.zeros_like(twist[:, :1]), twist[:, :-1]], axis=1)
        return Transitions(
            state=before.reshape(-1, 12),
            command=moved.command[:, : lead + slot].reshape(-1, size),
            after=twist.reshape(-1, 12),
            turns=np.zeros(12, dtype=bool),
        )

    def _twists(self, moved: Moved, link: int) -> Array:
        """Return what a link does, seen in the axes that the trunk has at rest, (rows, times, 6).

        To first order R' R+ = I + [w] dt, of which the antisymmetric half is taken.
        """
        x, turn = moved.pose(link).position, moved.pose(link).rotation
        trunk = moved.pose(self._body).rotation[:, :1]
        turn = turn @ turn[:, :1].swapaxes(2, 3) @ trunk
        step = turn[:, :-1].swapaxes(2, 3) @ turn[:, 1:]
        skew = 0.5 * (step - step.swapaxes(2, 3))
        gone = np.einsum("rtji,rtj->rti", turn[:, :-1], np.diff(x, axis=1))
        turned = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=2)
        return np.concatenate([gone, turned], axis=2) / self.task.period

    @cached_property
    def _body(self) -> int:
        return int(self.simulator.model.body(self.trunk).id)

    @cached_property
    def _end(self) -> int:
        parents = {link.parent for link in self.robot.links}
        ends = [link.name for link in self.robot.links if link.name not in parents]
        return int(self.simulator.model.body(ends[0]).id) if len(ends) == 1 else self._body

    def _run(
        self, act: Callable[[Array, Array, float], Array], rows: int, seconds: float | None = None
    ) -> Moved:
        model: Any = self.simulator.model
        q, v = self.task.start.sample(self.robot, model, rows, None)
        horizon = self.task.horizon if seconds is None else round(seconds, 9)
        return run(replace(self.task, horizon=horizon), self.simulator, act, q, v)


def mover(robot: Robot, *, seconds: float, wet: bool, reach: float = WIDEST) -> Mover:
    """Return a body of servos that is to go ahead for so long, in water or on a floor.

    Raises:
        TransferError: One of its actuators is a motor: a swing is of places, not of efforts.
        TaskError: It is held to the world.
    """
    motors = [each.name for each in robot.actuators if each.kind != "position"]
    if motors or not robot.actuators:
        raise TransferError(
            f"{', '.join(motors[:5]) or 'none'} of its actuators take efforts",
            where=f"gaits of {robot.name}",
            fix="give it servos: morph.policy_transfer.gait.servoed",
        )
    made = (swim if wet else walk)(robot)
    made = replace(made, horizon=seconds, period=0.02)
    return Mover(task=made, trunk=torso(robot, made.name), reach=reach)
