"""The one place where a Robot becomes something that MuJoCo can run."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import mujoco

from morph.body.robot import Robot

FRICTION_TIME = 1e-4
"""Time in which dry friction stops a joint, s; MuJoCo raises it to two timesteps.

MuJoCo's constraints are soft: a joint that friction holds against a torque
creeps at torque * inverse inertia * (1 - d) / d * time / 2, where d is the
impedance (MuJoCo documentation, Computation, Solver parameters). At twice the
timestep the stop takes one step, which is the stiffest that is stable, at any
timestep.
"""

FRICTION_IMPEDANCE = 0.9999
"""The impedance d of dry friction, MuJoCo's greatest (mjMAXIMP)."""


def spec_of(robot: Robot, *, timestep: float = 0.002) -> Any:
    """Return a robot as a `mujoco.MjSpec`, to edit and compile.

    Args:
        robot: The robot; it is not changed.
        timestep: Seconds between states.

    Returns:
        A new spec, with the implicit-in-velocity integrator, and dry friction
        so stiff that a joint it holds does not creep.
    """
    spec = bare_spec(robot)
    spec.option.timestep = timestep
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for joint in spec.joints:
        joint.solref_friction = (FRICTION_TIME, 1.0)
        joint.solimp_friction = (FRICTION_IMPEDANCE, FRICTION_IMPEDANCE, 0.001, 0.5, 2.0)
    return spec


def bare_spec(robot: Robot) -> Any:
    """Return a robot as a new `mujoco.MjSpec` with nothing set for simulation."""
    if robot.assets:
        return mujoco.MjSpec.from_string(robot.mjcf, assets=dict(robot.assets))
    return _parsed(robot.mjcf).copy()


@lru_cache(maxsize=8)
def _parsed(mjcf: str) -> Any:
    # A copy costs a twentieth of parsing again, and searches ask for thousands.
    return mujoco.MjSpec.from_string(mjcf)
