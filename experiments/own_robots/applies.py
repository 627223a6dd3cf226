"""Which commands a robot should be able to follow, judged without morph: by its tree and motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of

LOW = 0.05
"""Heights of a robot above its lowest point up to which a leaf is a foot."""
SCALAR = (mujoco.mjtJoint.mjJNT_SLIDE.value, mujoco.mjtJoint.mjJNT_HINGE.value)
"""Joints of one number."""
PRINTABLE = 0.2
"""m: links that are longer fit no printer of the study."""


@dataclass(frozen=True, kw_only=True)
class Abilities:
    """What a robot has that commands ask for."""

    driven: int
    """Hinges and slides that actuators drive."""
    floating: bool
    """Whether its base moves freely."""
    feet: int
    """Leaves of its tree that are lowest and hang from two driven joints or more."""
    carries: bool
    """Whether its motors can hold it on these feet, as it is described."""
    arms: int
    """Leaves that hang from two driven joints or more, of a robot that is bolted down."""
    printable: bool
    """Whether no link is longer than a printer is wide."""

    @property
    def applicable(self) -> frozenset[str]:
        """The commands of the study that it should be able to follow."""
        able = (
            {"inspect", "convert", "simulate", "view", "print"}
            if self.printable
            else {"inspect", "convert", "simulate", "view"}
        )
        if self.driven:
            able |= {"diagnose", "align"}
            # What floats holds a posture by standing in it.
            able |= set() if self.floating else {"hold"}
        if self.feet >= 2 and self.carries:
            able |= {"stand", "walk"}
        if self.floating and self.feet < 2 and self.driven >= 2:
            able |= {"walk"}
        if self.arms:
            able |= {"reach"}
        return frozenset(able)


def abilities(robot: Robot) -> Abilities:
    """Return what a robot has, by its compiled model as it is described."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE.value)
    scalar = {
        int(at)
        for at in model.actuator_trnid[:, 0][model.actuator_trntype <= 1]
        if model.jnt_type[at] in SCALAR
    }
    leaves = sorted(set(range(1, model.nbody)) - {int(at) for at in model.body_parentid[1:]})
    chains = {leaf: _driven(model, leaf, scalar) for leaf in leaves}
    limbs = {leaf: chain for leaf, chain in chains.items() if len(chain) >= 2}
    lowest = {leaf: _lowest(model, data, leaf) for leaf in limbs}
    ground = min((_lowest(model, data, at) for at in range(1, model.nbody)), default=0.0)
    high = max((float(data.geom_xpos[at, 2]) for at in range(model.ngeom)), default=0.0) - ground
    feet = [leaf for leaf in limbs if lowest[leaf] - ground < LOW * high] if len(free) else []
    sizes = [2.0 * float(model.geom_rbound[at]) for at in range(model.ngeom)]
    return Abilities(
        driven=len(scalar),
        floating=bool(len(free)),
        feet=len(feet),
        carries=bool(feet) and _carries(model, data, robot, feet),
        arms=0 if len(free) else len(limbs),
        printable=max(sizes, default=0.0) <= 2.0 * PRINTABLE,
    )


def _driven(model: Any, body: int, scalar: set[int]) -> list[int]:
    """Return the driven joints between a body and the world."""
    results = []
    while body:
        first = int(model.body_jntadr[body])
        results += [at for at in range(first, first + int(model.body_jntnum[body])) if at in scalar]
        body = int(model.body_parentid[body])
    return results


def _lowest(model: Any, data: Any, body: int) -> float:
    shapes = [at for at in range(model.ngeom) if model.geom_bodyid[at] == body]
    low = [float(data.geom_xpos[at, 2] - model.geom_rbound[at]) for at in shapes]
    return min(low, default=float(data.xpos[body, 2]))


def _carries(model: Any, data: Any, robot: Robot, feet: list[int]) -> bool:
    """Return whether joint torques within limits balance gravity, with vertical forces at feet."""
    weight: Array = data.qfrc_bias.copy()
    columns = []
    for foot in feet:
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacobian, None, data.xipos[foot], foot)
        columns.append(jacobian[2])
    lift = np.array(columns)
    base = int(model.jnt_dofadr[np.flatnonzero(model.jnt_type == 0)[0]])
    # Forces that carry the base in z, and turn it about x and y as little as can be.
    rows = [base + 2, base + 3, base + 4]
    forces = np.linalg.lstsq(lift[:, rows].T, weight[rows], rcond=None)[0]
    needed = weight - lift.T @ forces
    most = {
        int(model.joint(each.joint).dofadr[0]): each.limit
        for each in robot.actuators
        if each.joint and each.limit
    }
    return all(abs(needed[dof]) <= limit for dof, limit in most.items())
