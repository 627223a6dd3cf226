"""A robot with the masses that its parts really have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.inertia import is_physical
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.body.vary.apply import edited
from morph.errors import MakeError
from morph.fabrication.link_mass import LinkMass
from morph.files import sha256
from morph.print.weight import Weight


def printed_robot(robot: Robot, masses: Sequence[LinkMass], *, name: str = "") -> Robot:
    """Return a robot whose links have the masses that they have now.

    Mass, centre of mass and inertia of each link are those of `LinkMass.now`; a link whose
    mass still comes from the description, and one that is not named, stays as it is.

    Args:
        robot: The body as it was designed; it is not changed.
        masses: What its links weigh.
        name: What to call the new robot; by default as the old one.

    Raises:
        MakeError: A link is not there, or no body has such a mass and inertia.
        RobotError: MuJoCo cannot use it.
    """
    spec = bare_spec(robot)
    bodies = {body.name: body for body in spec.bodies[1:]}
    given = []
    for each in masses:
        if each.link not in bodies:
            raise MakeError(
                f"there is no link {each.link!r}; there are {', '.join(bodies)}",
                where=f"robot {robot.name}",
                fix="use the package with the robot that it was made of",
            )
        if each.source == "description":
            continue
        _give(bodies[each.link], each.now, robot.name)
        given.append(f"{each.link} {each.now.mass!r} {each.now.com.tolist()}")
        given.append(repr(each.now.inertia.tolist()))
    digest = sha256(robot.sha256 or sha256(robot.mjcf), *given)
    return edited(robot, spec, name or robot.name, digest)


def designed(robot: Robot) -> dict[str, Weight]:
    """Return what each link weighs by the description, in the link's frame, by its name."""
    return {
        link.name: Weight(
            mass=link.mass,
            com=np.array(link.com, dtype=np.float64),
            inertia=_matrix(link.inertia),
        )
        for link in robot.links
    }


def _matrix(six: Sequence[float]) -> Array:
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=np.float64)


def _give(body: Any, weight: Weight, robot: str) -> None:
    # A part that a slicer was asked about has some spread; only nonsense is refused here.
    if not (weight.mass > 0 and np.isfinite(weight.com).all() and is_physical(weight.inertia)):
        raise MakeError(
            f"{body.name!r} would weigh {weight.mass:g} kg with an inertia that no body has",
            where=f"robot {robot}",
            fix="see the masses of its parts in package.json",
        )
    import mujoco

    moments, axes = np.linalg.eigh(weight.inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1.0
    turn = np.empty(4)
    mujoco.mju_mat2Quat(turn, axes.ravel())
    body.explicitinertial = True
    body.mass = weight.mass
    body.ipos = weight.com
    body.iquat = turn
    body.inertia = moments
    body.fullinertia = np.full(6, np.nan)
