"""Learned dynamics of a body, stepped in place of the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import mujoco
import numpy as np
import torch

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.jointed.fit import JointedSettings
from morph.model.jointed.jointed import Accelerations, Jointed, through
from morph.policy.policy import UNLIMITED
from morph.search.trajectory.plant import Plant, Stepped, bounds_of
from morph.sim.simulator import Simulator
from morph.task.task import Task

FASTEST = 20.0
"""Velocity, in units of those seen, beyond which a dream counts as unstable."""

HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)
"""MuJoCo's number of a hinge."""

AT_ONCE = 4096
"""Rows that are stepped at once; more would leave the processor's cache."""


class Dream(Stepped):
    """What a learned body does, as optimal control sees it: all that others ask of a `Plant`.

    Of the compiled model it uses the kinematics and the bounds of the commands alone.

    Args:
        task: The task, for its body and its control period.
        model: The body's compiled `mujoco.MjModel`.
        bounds: The least and the greatest command of each actuator, shape (nu,) both.
        learned: The accelerations that trials showed.
    """

    def __init__(
        self, task: Task, model: Any, bounds: tuple[Array, Array], learned: Jointed
    ) -> None:
        """Keep what is given."""
        self.robot, self.model, self.period = task.robot, model, task.period
        self.low, self.high = bounds
        self.learned = learned
        self._fastest = FASTEST * learned.velocity_size.numpy()

    def advance(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        """Return positions and velocities one control period later, shape (rows, nv) each.

        A row that leaves all that was seen behind is NaN from then on.
        """
        parts = [
            self._advance(position[at : at + AT_ONCE], velocity[at : at + AT_ONCE], each)
            for at in range(0, max(len(command), 1), AT_ONCE)
            for each in (command[at : at + AT_ONCE],)
        ]
        return np.concatenate([q for q, _ in parts]), np.concatenate([v for _, v in parts])

    def _advance(self, position: Array, velocity: Array, command: Array) -> tuple[Array, Array]:
        q, v, u = (torch.from_numpy(np.array(a)) for a in (position, velocity, command))
        with torch.no_grad():
            after = through(self.learned.mean, q, v, u, self.period)
        place, rate = (a.numpy() for a in after)
        fine = np.isfinite(place).all(-1) & (np.abs(rate) <= self._fastest).all(-1)
        return np.where(fine[:, None], place, np.nan), np.where(fine[:, None], rate, np.nan)

    @property
    def plant(self) -> Plant:
        """Itself, as optimal control takes it."""
        return cast(Plant, self)


def known(task: Task) -> tuple[Any, tuple[Array, Array]]:
    """Return what is known of a body before any trial: its kinematics and its bounds.

    Raises:
        SearchError: It floats, or a command has no bounds.
    """
    where = f"learning {task.name} of {task.robot.name} from trials"
    simulator = Simulator(task.robot, step=task.step)
    model = simulator.model
    single = (HINGE, int(mujoco.mjtJoint.mjJNT_SLIDE))
    if not np.isin(model.jnt_type, single).all():
        raise SearchError(
            "it has a joint that is neither hinge nor slide",
            where=where,
            fix="take a search that works in a simulator, such as those for patterns",
        )
    low, high = bounds_of(simulator)
    boundless = [i for i in range(model.nu) if max(-low[i], high[i]) >= UNLIMITED]
    if boundless:
        raise SearchError(
            f"nothing bounds the commands of actuator {model.actuator(boundless[0]).name!r}",
            where=where,
            fix="give its motor a limit on the card, within which random commands are drawn",
        )
    return model, (low, high)


def settings_of(
    model: Any, bounds: tuple[Array, Array], *, slides: bool, lawful: bool
) -> JointedSettings:
    """Return what the learning of a body begins with.

    Args:
        model: The compiled model.
        bounds: Of the commands.
        slides: Whether it matters where slides are; on a free rail it does not.
        lawful: Whether accelerations are quadratic in velocities and affine in commands.
    """
    turning = model.jnt_type == HINGE
    return JointedSettings(
        turning=tuple(int(i) for i in np.flatnonzero(turning)),
        sliding=tuple(int(i) for i in np.flatnonzero(~turning)) if slides else (),
        command_size=tuple(float(x) for x in np.maximum(np.maximum(-bounds[0], bounds[1]), 1e-9)),
        lawful=lawful,
        names=tuple(str(model.joint(i).name) for i in range(model.njnt)),
    )


def stepped(
    accelerate: Accelerations, state: Sequence[torch.Tensor], command: torch.Tensor, period: float
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return states a period later; numbers stay finite, so that a mean over bodies does too."""
    q, v = through(accelerate, state[0], state[1], command, period)
    return torch.nan_to_num(q).clamp(-1e3, 1e3), torch.nan_to_num(v).clamp(-1e3, 1e3)
