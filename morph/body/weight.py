"""Whether a compiled model holds numbers, and masses that a robot may have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from morph.errors import RobotError

HEAVIEST = 1e7
"""Greatest mass of a robot, kg."""

FINITE = (
    *("body_pos", "body_quat", "body_mass", "body_ipos", "body_inertia", "geom_pos", "geom_quat"),
    *("jnt_pos", "jnt_axis", "jnt_range", "jnt_stiffness", "dof_damping", "dof_armature", "qpos0"),
    *("dof_frictionloss", "geom_size", "site_pos", "actuator_gear", "actuator_gainprm"),
    *("actuator_biasprm", "actuator_ctrlrange", "actuator_forcerange"),
)
"""Fields of a model that must hold numbers."""


def check_model(model: Any, source: Path) -> None:
    """Refuse a compiled `mujoco.MjModel` that no robot has.

    Raises:
        RobotError: A number in it is none, or a mass is beyond `HEAVIEST`.
    """
    _check_finite(model, source)
    _check_weight(model, source)


def _check_finite(model: Any, source: Path) -> None:
    for field in FINITE:
        if not np.isfinite(getattr(model, field)).all():
            raise RobotError(
                f"its {field.replace('_', ' ')} holds NaN or infinity",
                where=str(source),
                fix="write numbers; search the file for nan and inf",
            )


def _check_weight(model: Any, source: Path) -> None:
    # The world's own mass, that of what stands in it, is no part's.
    for index in range(1, model.nbody):
        given, mass = f"the link {model.body(index).name!r}", float(model.body_mass[index])
        if mass <= HEAVIEST:
            given, mass = "the robot", float(model.body_subtreemass[0])
        if mass > HEAVIEST:
            raise RobotError(
                f"{given} weighs {mass:.3g} kg, which no robot does",
                where=str(source),
                fix="write masses in kg, densities in kg/m3 and meshes in metres",
            )
