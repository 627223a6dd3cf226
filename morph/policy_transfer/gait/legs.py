"""Which servo of a leg swings it and which lifts it, and which way, learned from responses."""

from __future__ import annotations

import numpy as np

from morph.body.robot import Robot
from morph.body.roles import actuator_roles
from morph.errors import TransferError
from morph.policy_transfer.gait.limbs import CLEAR, Limb, Responses


def legs(result: Responses, robot: Robot) -> tuple[Limb, ...]:
    """Return where each servo of a body on legs belongs.

    Geometry tells which servos make a leg and in which corner it stands. Of a leg, the servo that
    tilts the trunk most lifts it, and the one of the others that moves the trunk most along x
    swings it; what is left rests. The senses are learned: a leg that is lifted lets the trunk
    sink, and one that swings forward on the floor pushes the trunk back.

    Raises:
        TransferError: A leg has fewer than two servos.
    """
    roles = actuator_roles(robot)
    corners = [(roles[each.name].side, roles[each.name].place) for each in robot.actuators]
    tilt = np.hypot(result.trunk[:, 3], result.trunk[:, 4])
    ahead, up = result.trunk[:, 0], result.trunk[:, 2]
    made: dict[int, Limb] = {}
    for corner in dict.fromkeys(corners):
        mine = [at for at, each in enumerate(corners) if each == corner]
        if len(mine) < 2:
            raise TransferError(
                f"a leg has {len(mine)} servo, {robot.actuators[mine[0]].name}",
                where="legs of a body",
                fix="give a body whose legs both swing and lift",
            )
        lift = max(mine, key=lambda at: float(tilt[at]))
        rest = [at for at in mine if at != lift]
        swing = max(rest, key=lambda at: float(abs(ahead[at])))
        side, place = (0.5 if each is None else each for each in corner)
        for at in mine:
            role = {lift: "lift", swing: "swing"}.get(at, "")
            value, error = (
                (up[at], result.error[at, 2])
                if role == "lift"
                else (ahead[at], result.error[at, 0])
            )
            made[at] = Limb(
                place=place,
                side=side,
                sense=float(-np.sign(value)) if role else 0.0,
                sure=bool(abs(value) > CLEAR * error or not role),
                role=role,
            )
    return tuple(made[at] for at in range(len(corners)))
