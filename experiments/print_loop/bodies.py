"""The bodies of the study, and what moves them so that their masses show."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from morph.arrays import Array
from morph.body.card import PrintTable
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.body.vary.apply import edited
from morph.body.vary.drop import Drop
from morph.body.vary.lock import Lock

Command = Callable[[Array], Array]


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A body, and how hard its actuators are driven."""

    robot: Robot
    """As designed."""
    effort: Mapping[str, tuple[float, float]]
    """Middle and half range of each actuator's commands, in its own unit."""
    links: tuple[str, ...]
    """Links that are printed."""
    speed: float = 1.0
    """Highest frequency of the commands, Hz."""
    start: Mapping[str, float] = field(default_factory=dict)
    """Half range of each joint's start, rad or m."""


def subject(name: str) -> Subject:
    """Return a body of the study by its name."""
    if name == "so101":
        robot = load("so101")
        reach = {joint.name: joint.limits or (-1.0, 1.0) for joint in robot.joints}
        effort = {
            a.name: (
                0.5 * (reach[a.name][0] + reach[a.name][1]),
                0.3 * (reach[a.name][1] - reach[a.name][0]),
            )
            for a in robot.actuators
        }
        links = tuple(link.name for link in robot.links if link.name != "base")
        return Subject(robot=robot, effort=effort, links=links)
    if name == "double_pendulum":
        return Subject(
            robot=printable(name, "upper", "lower"),
            effort={"shoulder": (0.0, 0.7), "elbow": (0.0, 0.3)},
            links=("upper", "lower"),
            speed=2.0,
            start={"shoulder": 0.6, "elbow": 0.6},
        )
    if name == "cartpole":
        return Subject(
            robot=printable(name, "cart", "pole"),
            effort={"slide": (0.0, 4.0)},
            links=("cart", "pole"),
            speed=2.0,
            start={"hinge": 1.5},
        )
    return Subject(
        robot=leg(),
        effort={"front_left_hip": (0.0, 0.6), "front_left_knee": (0.4, 0.7)},
        links=("front_left_upper_leg", "front_left_lower_leg"),
        speed=2.0,
    )


def printable(name: str, *links: str) -> Robot:
    """Return a body of the shelf as if its card said that links are printed."""
    robot = load(name)
    if robot.card is None:
        return robot
    return replace(robot, card=replace(robot.card, print=PrintTable(printed=links)))


def leg() -> Robot:
    """Return one leg of the printed quadruped, its body bolted down on its side.

    Upright, the hip's axis is, and its motor never feels a weight.
    """
    whole = load("quadruped_printed")
    spec = bare_spec(whole)
    spec.modelname = whole.name
    for other in ("rear_left", "rear_right", "front_right"):
        Drop(link=f"{other}_upper_leg").apply(spec)
    Lock(joint="body").apply(spec)
    spec.body("body").quat = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
    return edited(whole, spec, "printed_leg", f"{whole.sha256} one leg")


BODIES = ("so101", "double_pendulum", "cartpole", "leg")
"""Names of the bodies."""


def commands(body: Subject, rng: np.random.Generator) -> dict[str, Command]:
    """Return what each actuator is told: slow and fast waves, and steps that last a second.

    Steps let gravity show at rest, waves let inertia show.
    """
    return {name: _wave(*body.effort[name], body.speed, rng) for name in body.effort}


def _wave(middle: float, half: float, speed: float, rng: np.random.Generator) -> Command:
    frequency = np.array([0.13, 0.31, 0.71]) * speed * rng.uniform(0.8, 1.2, 3)
    phase, share = rng.uniform(0.0, 2.0 * np.pi, 3), np.array([0.25, 0.2, 0.15])
    levels = rng.uniform(-0.4, 0.4, 64)

    def told(times: Array) -> Array:
        waves = share @ np.sin(2.0 * np.pi * frequency[:, None] * times + phase[:, None])
        steps = levels[np.clip(times / 1.3, 0, 63).astype(int)]
        return np.asarray(middle + half * (waves + steps))

    return told
