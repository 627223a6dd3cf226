"""Gaits: patterns of a whole body from a few numbers, by the symmetry of its geometry."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.roles import Role, actuator_roles
from morph.errors import SearchError
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action, actions_of
from morph.search.family.family import Family, Number

WIDEST = 1.0
"""Greatest amplitude, and greatest offset from where it rests, of a joint, rad."""

OWN = ("amplitude", "offset", "slant", "phase", "lag")
"""The numbers that a role has of its own."""


@dataclass(frozen=True, kw_only=True)
class Gait(Family):
    """Patterns in which all actuators of one role swing alike, those of other legs later.

    With p the place of an actuator (0 in front, 1 at the rear), s its side (0 left, 1 right)
    and d its sense (1 or -1, which makes equal motions mirror images), it swings about
    d (o + g (2 p - 1)) with the amplitude d a, at a frequency F that the body shares, with the
    phase f - b s - l p: o, g, a, f and l belong to its role (hip, knee, yaw), b to the body. So
    the wave of a snake, a trot and a stroke of paddles are points of one family.

    Where a role turns round, g and a count w = 1 - 2 p times, and w 2 pi F t is added: legs
    turn forward in front, backward at the rear and rest in the middle, fast as they push on
    one side of the body and slow as they come back on the other, or the other way round.

    Source: Ijspeert 2008, Central pattern generators for locomotion control in animals and
    robots, Neural Networks 21(4), for gaits as a shared frequency and phase lags.
    """

    action: tuple[Action, ...]
    """Every actuator of the body."""
    roles: tuple[Role, ...]
    """The role of each."""
    turning: tuple[str, ...] = ()
    """Names of the roles that turn round."""
    period: float = 0.02
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values, in the order of `numbers`."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        return Pattern(
            swings=tuple(self._swing(role, free) for role in self.roles),
            action=self.action,
            period=self.period,
        )

    def _swing(self, role: Role, free: dict[str, float]) -> Swing:
        place, side = role.place or 0.0, role.side or 0.0
        amplitude, offset, slant, phase, lag = (free.get(f"{role.name} {key}", 0.0) for key in OWN)
        late = free.get(SIDES_LAG, 0.0) * side + lag * place
        frequency = free["frequency"]
        if role.name not in self.turning:
            return Swing(
                offset=role.sense * (offset + slant * (2.0 * place - 1.0)),
                amplitude=amplitude,
                frequency=frequency,
                # Against the others: half a turn later.
                phase=phase - late + (math.pi if role.sense < 0.0 else 0.0),
            )
        way = role.sense * (1.0 - 2.0 * place)
        return Swing(
            offset=role.sense * offset + way * (slant - late),
            amplitude=way * amplitude,
            frequency=frequency,
            phase=phase - late,
            rate=way * 2.0 * math.pi * frequency,
        )


SIDES_LAG = "lag of the right"
"""What the phase between the sides is called."""


def gait(
    robot: Robot,
    *,
    period: float = 0.02,
    fastest: float = 3.0,
    roles: tuple[str, ...] | None = None,
    action: tuple[Action, ...] | None = None,
) -> Gait:
    """Return the gaits of a robot: what is free follows from its symmetry and its ranges.

    Args:
        robot: The body.
        period: How long each command is held, s.
        fastest: Greatest frequency, Hz.
        roles: Names of the roles that swing, such as `hip`; the others rest at zero. None: all.
        action: What is told to each actuator, and within which bounds; if not given, what the
            robot takes.

    Raises:
        SearchError: It has no actuator, or none of such a role.
    """
    action = actions_of(robot) if action is None else action
    if not action:
        raise SearchError(
            "it has no actuator", where=f"robot {robot.name}", fix="give it a motor or a servo"
        )
    found = actuator_roles(robot)
    each_role = tuple(found[each.actuator] for each in action)
    known = tuple(role.name for role in sorted(set(each_role), key=lambda role: role.order))
    known = tuple(dict.fromkeys(known))
    swinging = known if roles is None else tuple(name for name in known if name in roles)
    if not swinging or not set(roles or ()) <= set(known):
        raise SearchError(
            f"a gait of {', '.join(roles or ()) or 'nothing'} was asked for, "
            f"and its actuators are {', '.join(known)}",
            where=f"robot {robot.name}",
            fix="name roles of its actuators",
        )
    numbers = [Number(name="frequency", low=0.2, high=fastest, start=0.2 + 0.4 * (fastest - 0.2))]
    if len({role.side for role in each_role} - {None}) > 1:
        numbers.append(_turn(SIDES_LAG, math.pi))
    turning = []
    for name in swinging:
        those = [
            (one, role) for one, role in zip(action, each_role, strict=True) if role.name == name
        ]
        free = _turns(robot, those)
        turning += [name] if free else []
        numbers += _of_turning(name) if free else _of_role(name, those)
    if not turning:
        # Only phases between roles show: the clock may begin anywhere.
        numbers.remove(next(number for number in numbers if number.name.endswith("phase")))
    return Gait(
        numbers=tuple(numbers),
        action=action,
        roles=each_role,
        period=period,
        turning=tuple(turning),
    )


def room_about(
    robot: Robot, posture: Mapping[str, float], widest: float
) -> tuple[Array, tuple[Action, ...]]:
    """Return where actuators hold a posture, and how far each may swing about that.

    Args:
        robot: The body.
        posture: Where joints are between their swings, by name, rad or m; others are at zero.
        widest: Farthest swing, rad or m.

    Returns:
        Positions, shape (actuators,), and bounds. What drives no joint, such as a tendon, swings
        about zero as far as its commands go.
    """
    place, room = np.zeros(len(robot.actuators)), []
    for at, (actuator, own) in enumerate(zip(robot.actuators, actions_of(robot), strict=True)):
        if actuator.joint is None:
            room.append(own)
            continue
        joint = robot.driven_by(actuator)
        place[at] = rest = posture.get(joint.name, 0.0)
        low, high = joint.limits or (-math.pi, math.pi)
        room.append(
            Action(
                actuator=actuator.name,
                unit=joint.unit,
                low=float(max(low - rest, -widest)),
                high=float(min(high - rest, widest)),
            )
        )
    return place, tuple(room)


def _turns(robot: Robot, those: list[tuple[Action, Role]]) -> bool:
    """Return whether those of one role are servos that may turn without end, front and rear."""
    servos = [robot.actuator(one.actuator) for one, _ in those]
    return (
        all(each.kind == "position" and each.joint for each in servos)
        and all(robot.driven_by(each).limits is None for each in servos)
        and len({role.place for _, role in those} - {None}) > 1
    )


def _turn(name: str, start: float = 0.0) -> Number:
    # The whole circle and half of it again, so that no good phase lies at a face of the cube.
    return Number(name=name, low=-0.5 * math.pi, high=2.5 * math.pi, start=start)


def _of_turning(named: str) -> list[Number]:
    return [
        # Above 1 a leg would go back for a while, which is no turn.
        Number(name=f"{named} amplitude", low=0.0, high=1.0, start=0.5),
        Number(name=f"{named} offset", low=-0.5, high=0.5, start=0.0),
        Number(name=f"{named} slant", low=-1.5 * math.pi, high=1.5 * math.pi, start=0.0),
        _turn(f"{named} phase", math.pi),
        Number(name=f"{named} lag", low=-math.pi, high=math.pi, start=0.0),
    ]


def _of_role(named: str, those: list[tuple[Action, Role]]) -> list[Number]:
    widest = WIDEST if those[0][0].unit in {"rad", "m"} else math.inf
    # Bounds as the role has them: of one that turns against the others, the other way round.
    bounds = [sorted((role.sense * one.low, role.sense * one.high)) for one, role in those]
    low = max(max(each for each, _ in bounds), -widest)
    high = min(min(each for _, each in bounds), widest)
    reach = max(min(high, -low), 1e-3)
    numbers = [
        Number(name=f"{named} amplitude", low=0.0, high=reach, start=0.4 * reach),
        Number(
            name=f"{named} offset", low=0.5 * min(low, 0.0), high=0.5 * max(high, reach), start=0.0
        ),
        _turn(f"{named} phase"),
    ]
    if len({role.place for _, role in those} - {None}) > 1:
        numbers.append(Number(name=f"{named} slant", low=-0.3 * reach, high=0.3 * reach, start=0.0))
        numbers.append(_turn(f"{named} lag", math.pi))
    return numbers
