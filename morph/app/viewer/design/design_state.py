"""State of one session's design: parameters, pose and history."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from morph.app.viewer.design.history import History
from morph.app.viewer.design.measure import Measures, measured
from morph.app.viewer.design.parameters import changes, designed, general
from morph.app.viewer.figure import Figure, figure
from morph.arrays import Array
from morph.body.card import CardParameter
from morph.body.holding import Holding, HoldingMotor
from morph.body.posture import Handle, Posture
from morph.body.robot import Robot

FINE = 1e-9
"""rad or m: nearer to rest than this is at rest."""


@dataclass(frozen=True, kw_only=True)
class DesignChoice:
    """What a designer has chosen."""

    values: Mapping[str, float] = field(default_factory=dict)
    """Parameters that change something, by their names."""
    pose: Mapping[str, float] = field(default_factory=dict)
    """Joints that are not at rest, by their names, rad or m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Built:
    """A body with its parameters set, and what it looks like."""

    values: Mapping[str, float]
    """The parameters."""
    robot: Robot
    """The body."""
    figure: Figure
    """What is drawn of it."""

    @cached_property
    def measures(self) -> Measures:
        """Its figures; the first to ask waits for them, up to half a second."""
        return measured(self.robot, Posture(self.figure.model), self.figure.shapes)


class BodyPlan:
    """A body as described, the same for all persons.

    Args:
        robot: The body.

    Raises:
        SimulationFailed: MuJoCo refuses its description.
    """

    def __init__(self, robot: Robot) -> None:
        """Draw it as it is."""
        self.robot = robot
        own = robot.card.parameter if robot.card is not None else ()
        self.own = own
        """The parameters of its card."""
        taken = {parameter.name for parameter in own}
        self.general = tuple(each for each in general(robot) if each.name not in taken)
        """Those that every body has."""
        self.original = Built(values={}, robot=robot, figure=figure(robot))
        """The body as it is."""

    @property
    def parameters(self) -> tuple[CardParameter, ...]:
        """All that may be changed."""
        return (*self.own, *self.general)

    def built(self, values: Mapping[str, float]) -> Built:
        """Return the body with parameters set; takes some 10 to 100 ms.

        Raises:
            RobotError: An operation cannot be done.
        """
        if not values:
            return self.original
        robot = designed(self.robot, self.parameters, values)
        drawn = figure(robot, name=self.original.figure.name)
        return Built(values=dict(values), robot=robot, figure=drawn)


class Bench:
    """The design of one body by one person.

    Args:
        plan: The body as described.
    """

    def __init__(self, plan: BodyPlan) -> None:
        """Begin with the body as it is."""
        self.plan = plan
        self.history: History[DesignChoice] = History(now=DesignChoice())
        self.take(plan.original)

    @property
    def choice(self) -> DesignChoice:
        """What is chosen now."""
        return self.history.now

    @property
    def stale(self) -> bool:
        """Whether other parameters are chosen than what is built."""
        return dict(self.built.values) != dict(self.choice.values)

    def take(self, built: Built) -> None:
        """Take a body that was built, and bring it into the chosen pose."""
        self.built = built
        self.posture = Posture(built.figure.model)
        self._holding = Holding(built.robot, self.posture)
        self.pose: Array = self.posture.rest
        self.adopt()

    def adopt(self) -> None:
        """Bring the body into the chosen pose."""
        self.pose, _ = self.posture.towards(self.posture.rest, self._goal(self.choice.pose))

    def turn(self, joint: str, value: float, time: float) -> bool:
        """Bring a joint to a position, rad or m; return whether loops and limits let it.

        Args:
            joint: Its name; one that is not there is left alone.
            value: Where to; beyond its range the nearest end is taken.
            time: When, s, for the history.
        """
        goal = self.pose[self.posture.places]
        for at, handle in enumerate(self.posture.handles):
            if handle.joint == joint:
                goal[at] = value
        return self._move(goal, f"joint {joint}", time)

    def rest(self, time: float) -> None:
        """Bring all joints to where the description has them."""
        self._move(self._goal({}), "rest", time)

    def random(self, rng: np.random.Generator, time: float) -> None:
        """Bring every joint anywhere in its range."""
        goal = [
            rng.uniform(handle.low, handle.high) if handle.ranged else handle.rest
            for handle in self.posture.handles
        ]
        self._move(np.array(goal), f"random {time}", time)

    def set(self, name: str, value: float | None, time: float) -> None:
        """Set a parameter; None, or where it changes nothing, leaves it as described.

        Args:
            name: Its name; one that is not there is left alone.
            value: Its value; beyond its range the nearest end is taken.
            time: When, s, for the history.
        """
        values = dict(self.choice.values)
        for parameter in self.plan.parameters:
            if parameter.name == name:
                values.pop(name, None)
                if value is not None and np.isfinite(value):
                    value = min(max(value, parameter.low), parameter.high)
                    if changes(parameter, value):
                        values[name] = value
        self.history.change(replace(self.choice, values=values), f"parameter {name}", time)

    def plain(self, time: float) -> None:
        """Leave all parameters as described."""
        self.history.change(replace(self.choice, values={}), "plain", time)

    @property
    def motors(self) -> tuple[HoldingMotor, ...]:
        """Its motors."""
        return self._holding.motors

    @property
    def limits(self) -> Array:
        """Their limits, N m or N, NaN where none is known, shape (motors,)."""
        return self._holding.limits

    def efforts(self) -> Array:
        """Return what each motor holds in this pose, N m or N, shape (motors,)."""
        return self._holding.at(self.pose)

    def position(self, handle: Handle) -> float:
        """Return where a joint is, rad or m."""
        at = int(self.posture.model.joint(handle.joint).qposadr[0])
        return float(self.pose[at])

    def seen(self, part: str | None) -> str | None:
        """Return the link to highlight for a link or joint: the first outward that is drawn."""
        model = self.posture.model
        links = [model.body(at).name for at in range(model.nbody)]
        for joint in self.built.robot.joints:
            if joint.name == part and part not in links:
                part = joint.link
        if part is None or part not in links:
            return None
        drawn = {shape.body for shape in self.built.figure.shapes}
        at = links.index(part)
        below = [at]
        for body in range(at, model.nbody):
            if body == at or int(model.body_parentid[body]) in below:
                below.append(body)
                if body in drawn:
                    return str(links[body])
        return None

    def state(self) -> dict[str, Any]:
        """Return the choice as JSON."""
        return {"parameters": dict(self.choice.values), "pose": dict(self.choice.pose)}

    def _goal(self, pose: Mapping[str, float]) -> Array:
        return np.array([pose.get(each.joint, each.rest) for each in self.posture.handles])

    def _move(self, goal: Array, what: str, time: float) -> bool:
        self.pose, arrived = self.posture.towards(self.pose, goal)
        pose = {
            handle.joint: value
            for handle in self.posture.handles
            if abs((value := self.position(handle)) - handle.rest) > FINE
        }
        # A joint that is locked for now keeps its place for when it is free again.
        here = {handle.joint for handle in self.posture.handles}
        pose |= {name: at for name, at in self.choice.pose.items() if name not in here}
        self.history.change(replace(self.choice, pose=pose), what, time)
        return arrived
