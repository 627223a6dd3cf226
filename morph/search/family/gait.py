"""Gaits: patterns of a whole body from a few numbers, by the symmetry that its names tell."""

from __future__ import annotations

import math
from dataclasses import dataclass

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import SearchError
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action, actions_of
from morph.search.family.family import Family, Number
from morph.search.family.parts import ActuatorRole, parts_of

WIDEST = 1.0
"""Greatest amplitude, and greatest offset from where it rests, of a joint, rad."""

OWN = ("amplitude", "offset", "slant", "phase", "lag")
"""The numbers that a role has of its own."""


@dataclass(frozen=True, kw_only=True)
class Gait(Family):
    """Patterns in which all actuators of one role swing alike, those of other legs later.

    With p the place of an actuator (0 in front, 1 at the rear) and s its side (0 left, 1
    right), it swings about o + g (2 p - 1) with the amplitude a, at a frequency F that the
    body shares, with the phase f - b s - l p: o, g, a, f and l belong to its role (hip, knee,
    yaw), b to the body. So the wave of a snake, a trot and a stroke of paddles are points of
    one family.

    Where a role turns round, g and a count w = 1 - 2 p times, and w 2 pi F t is added: legs
    turn forward in front, backward at the rear and rest in the middle, fast as they push on
    one side of the body and slow as they come back on the other, or the other way round.

    Source: Ijspeert 2008, Central pattern generators for locomotion control in animals and
    robots, Neural Networks 21(4), for gaits as a shared frequency and phase lags.
    """

    action: tuple[Action, ...]
    """Every actuator of the body."""
    parts: tuple[ActuatorRole, ...]
    """What the name of each tells."""
    turning: tuple[str, ...] = ()
    """The roles that turn round."""
    period: float = 0.02
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values, in the order of `numbers`."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        return Pattern(
            swings=tuple(self._swing(part, free) for part in self.parts),
            action=self.action,
            period=self.period,
        )

    def _swing(self, part: ActuatorRole, free: dict[str, float]) -> Swing:
        place, side = part.place or 0.0, part.side or 0.0
        amplitude, offset, slant, phase, lag = (
            free.get(f"{part.role} {key}".strip(), 0.0) for key in OWN
        )
        late = free.get(SIDES_LAG, 0.0) * side + lag * place
        frequency = free["frequency"]
        if part.role not in self.turning:
            return Swing(
                offset=offset + slant * (2.0 * place - 1.0),
                amplitude=amplitude,
                frequency=frequency,
                phase=phase - late,
            )
        way = 1.0 - 2.0 * place
        return Swing(
            offset=offset + way * (slant - late),
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
    """Return the gaits of a robot: what is free follows from its actuators' names and ranges.

    Args:
        robot: The body.
        period: How long each command is held, s.
        fastest: Greatest frequency, Hz.
        roles: Which roles swing, such as `hip`; the others rest at zero. None for all.
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
    parts = parts_of(tuple(each.actuator for each in action))
    known = tuple(dict.fromkeys(part.role for part in parts))
    swinging = known if roles is None else roles
    if not swinging or not set(swinging) <= set(known):
        raise SearchError(
            f"a gait of {', '.join(swinging) or 'nothing'} was asked for, "
            f"and its actuators are {', '.join(known)}",
            where=f"robot {robot.name}",
            fix="name roles of its actuators",
        )
    numbers = [Number(name="frequency", low=0.2, high=fastest, start=0.2 + 0.4 * (fastest - 0.2))]
    if len({part.side for part in parts} - {None}) > 1:
        numbers.append(_turn(SIDES_LAG, math.pi))
    turning = []
    for role in swinging:
        those = [(one, part) for one, part in zip(action, parts, strict=True) if part.role == role]
        free = _turns(robot, those)
        turning += [role] if free else []
        numbers += _of_turning(role) if free else _of_role(role, those)
    if not turning:
        # Only phases between roles show: the clock may begin anywhere.
        numbers.remove(next(number for number in numbers if number.name.endswith("phase")))
    return Gait(
        numbers=tuple(numbers),
        action=action,
        parts=parts,
        period=period,
        turning=tuple(turning),
    )


def _turns(robot: Robot, those: list[tuple[Action, ActuatorRole]]) -> bool:
    """Return whether those of one role are servos that may turn without end, front and rear."""
    servos = [robot.actuator(one.actuator) for one, _ in those]
    return (
        all(each.kind == "position" for each in servos)
        and all(robot.driven_by(each).limits is None for each in servos)
        and len({part.place for _, part in those} - {None}) > 1
    )


def _turn(name: str, start: float = 0.0) -> Number:
    # The whole circle and half of it again, so that no good phase lies at a face of the cube.
    return Number(name=name, low=-0.5 * math.pi, high=2.5 * math.pi, start=start)


def _of_turning(role: str) -> list[Number]:
    named = f"{role} ".lstrip()
    return [
        # Above 1 a leg would go back for a while, which is no turn.
        Number(name=f"{named}amplitude", low=0.0, high=1.0, start=0.5),
        Number(name=f"{named}offset", low=-0.5, high=0.5, start=0.0),
        Number(name=f"{named}slant", low=-1.5 * math.pi, high=1.5 * math.pi, start=0.0),
        _turn(f"{named}phase", math.pi),
        Number(name=f"{named}lag", low=-math.pi, high=math.pi, start=0.0),
    ]


def _of_role(role: str, those: list[tuple[Action, ActuatorRole]]) -> list[Number]:
    widest = WIDEST if those[0][0].unit in {"rad", "m"} else math.inf
    low = max(max(one.low for one, _ in those), -widest)
    high = min(min(one.high for one, _ in those), widest)
    reach = max(min(high, -low), 1e-3)
    named = f"{role} ".lstrip()
    numbers = [
        Number(name=f"{named}amplitude", low=0.0, high=reach, start=0.4 * reach),
        Number(
            name=f"{named}offset", low=0.5 * min(low, 0.0), high=0.5 * max(high, reach), start=0.0
        ),
        _turn(f"{named}phase"),
    ]
    if len({part.place for _, part in those} - {None}) > 1:
        numbers.append(Number(name=f"{named}slant", low=-0.3 * reach, high=0.3 * reach, start=0.0))
        numbers.append(_turn(f"{named}lag", math.pi))
    return numbers
