"""Laws at the sizes at which an experiment is to show them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.inference.dictionary import dictionary
from morph.inference.observed import Observed
from morph.physics.body.tether import Tether
from morph.physics.effect import Effect
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.wet import WetEffect

FORCE, READING = 0.05, 0.01
"""Size at which a law is looked for where none is told: its force over the force of the joint's
actuators, or its change of a reading over the motion, RMS, in the strongest quick motion."""
IDLE = 1e-6
"""Size of a law's column over that of its greatest, below which it does nothing here."""


def sized(
    robot: Robot, laws: Sequence[Effect], runs: Iterable[Observed]
) -> list[tuple[Effect, ...]]:
    """Return laws, each first at its size and then at other shapes that it might be taken for.

    Args:
        robot: The description.
        laws: As they were asked for, neutral ones at a usual size; none for every law of the robot,
            also those that do nothing if others do.
        runs: Motions, a strong one of all joints first, by which sizes are set; the size of a law
            that does nothing there, by the next in which it does.

    Raises:
        DiagnosisError: A law that was asked for does nothing in any motion.
    """
    more = iter(runs)
    tried = [next(more)]
    there = {grid[0].label: grid for grid in dictionary(robot, tried, tuple(laws))}
    if not laws:
        # Pushes and cables come from outside: no laws of the robot. In air fluids hardly act.
        wet = robot.card is not None and robot.card.water is not None
        every = [
            at_share(grid[len(grid) // 2], tried[0])
            for grid in there.values()
            if not (grid[0].of_a_run or isinstance(grid[0], Tether))
            and (wet or not isinstance(grid[0], WetEffect | FluidCurrent))
        ]
        return [(law,) for law in every] if any(_acts(law, tried[0]) for law in every) else []
    results = []
    for law in laws:
        grid = there.get(law.label, (law,))
        if law.of_a_run or isinstance(law, Tether) or law.kind == "contact":
            raise DiagnosisError(
                f"{law.label} comes from outside: no command of the robot's brings it about",
                where="--separate",
                fix="name laws of joints, actuators, sensors, links or a fluid",
            )
        # Parameters that are law_there stay; a law without any has the middle shape of its grid.
        shape = grid[len(grid) // 2] if law == type(law).at(law.where) else law
        for seen in chain(tuple(tried), more):
            tried = tried if seen in tried else [*tried, seen]
            law_there = law if law.coefficients.any() else at_share(shape, seen)
            if _acts(law_there, seen):
                break
        else:
            raise DiagnosisError(
                f"{law.label} does nothing in any motion of this robot that was tried",
                where="--separate",
                fix="give it parameters at which it acts within the robot's limits, as a lower "
                "limit or a nearer stop, or name a law of a joint that moves or an actuator that "
                "drives",
            )
        results.append((law_there, *grid))
    return results


def _acts(effect: Effect, seen: Observed) -> bool:
    sensor = effect.kind == "sensor"
    columns = (effect.reading_regressor if sensor else effect.regressor)(seen.motion)
    return bool((columns @ effect.coefficients).any())


def at_share(effect: Effect, seen: Observed, share: float | None = None) -> Effect:
    """Return a law at a size relative to what moves the part on which it acts most.

    Args:
        effect: The law, at its shape.
        seen: A motion.
        share: Its force over that of the joint's actuators or the inertial one, whichever is more,
            or its change of a reading over the motion, RMS; None for `FORCE` or `READING`.
    """
    motion = seen.motion
    if effect.kind == "sensor":
        columns = effect.reading_regressor(motion)
        usual = (share or READING) * np.std(motion.reading, axis=0)
    else:
        columns = effect.regressor(motion)
        driven = np.sqrt(np.mean(motion.drive.sum(axis=1) ** 2, axis=0))
        usual = (share or FORCE) * np.maximum(driven, seen.about.inertial)
    sizes = np.sqrt(np.mean(columns**2, axis=0))
    # The part on which it acts most is where its size counts; some strengths do nothing here.
    most, size = np.argmax(sizes, axis=0), sizes.max(axis=0)
    works = size > IDLE * float(np.max(size, initial=0.0))
    strength = np.where(works, usual[most] / np.maximum(size, 1e-300), 0.0)
    strength /= math.sqrt(max(1, int(np.count_nonzero(works))))
    one = effect.with_strengths(strength)
    return one if one.coefficients.any() else effect.with_strengths(-strength)
