"""Options of a description under which MuJoCo would leave the fluid out, put right or refused."""

from __future__ import annotations

from typing import Any

import mujoco

from morph.errors import EffectError

SPRING = mujoco.mjtDisableBit.mjDSBL_SPRING
DAMPER = mujoco.mjtDisableBit.mjDSBL_DAMPER


def put_right(model: Any) -> None:
    """Change what only asks for another way of solving the same problem, in a wet model.

    The fluid enters M after MuJoCo has prepared for PGS, noslip and `diagexact`, which so would
    work on dry bodies (not under its `discrete` integrator). Newton solves the same problem as
    PGS; without `diagexact`, softness comes from `settle`. A tree that sleeps keeps its M, to
    which the fluid would be added again and again.

    Raises:
        EffectError: The description asks for noslip, or for no passive forces at all.
    """
    if model.opt.solver == mujoco.mjtSolver.mjSOL_PGS:
        model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
    for flag in (mujoco.mjtEnableBit.mjENBL_DIAGEXACT, mujoco.mjtEnableBit.mjENBL_SLEEP):
        model.opt.enableflags &= ~flag.value
    if model.opt.noslip_iterations:
        raise EffectError(
            f"noslip_iterations is {model.opt.noslip_iterations}, and noslip knows no fluid",
            where="the fluid",
            fix='leave noslip_iterations out of <option>; cone="elliptic" and a high impratio '
            "keep contacts from slipping",
        )
    off = SPRING.value | DAMPER.value
    if model.opt.disableflags & off == off:
        raise EffectError(
            "springs and dampers are both disabled, and MuJoCo then leaves out the fluid, too",
            where="the fluid",
            fix="disable only one of them in <flag>",
        )
