"""The cart-pole of the thesis with one of its five parameters changed."""

from __future__ import annotations

from collections.abc import Mapping

from morph.body.load import load
from morph.body.robot import Robot
from morph.model.latent.unknowns import turned
from morph.physics.effect import Effect
from morph.search.target import Simulated
from morph.task.swing_up import swing_up
from morph.task.task import Task

FIGURES: Mapping[str, str] = {
    "g": "gravity:world",
    "l": "length:pole",
    "m": "weight:pole",
    "M": "weight:cart",
    "b": "damping:slide",
}
"""What morph calls the parameters of figures 7 and 8 of the thesis."""


def cartpole(factors: Mapping[str, float] | None = None) -> Robot:
    """Return the cart-pole with parameters multiplied: `{"l": 2.0}`."""
    robot = load("cartpole")
    named = {FIGURES[name]: factor for name, factor in (factors or {}).items() if factor != 1.0}
    return turned(robot, named) if named else robot


def changed(name: str, factor: float) -> Task:
    """Return the swing-up of the cart-pole with one parameter multiplied."""
    return swing_up(cartpole({name: factor}))


def target_of(task: Task, effects: tuple[Effect, ...] = ()) -> Simulated:
    """Return a simulation that stands for the robot, under effects that nobody is told of."""
    return Simulated(task=task, simulator=task.simulator(effects))
