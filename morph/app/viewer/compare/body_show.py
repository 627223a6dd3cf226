"""What is shown of one body: motion, forces and figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.app.viewer.compare.arrows import Felt, size_of
from morph.app.viewer.compare.figures import MARGIN, TaskVerdict, margin, series, verdict
from morph.app.viewer.compare.forces import forces
from morph.app.viewer.compare.run import SimulatedRun, ran
from morph.app.viewer.compare.sweep import SECONDS, swept
from morph.app.viewer.figure import Figure, figure
from morph.app.viewer.motion import MotionFrames, motion, posed
from morph.body.holding import Holding
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.physics.worlds import world
from morph.policy.policy import Policy
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class Show:
    """One body, ready to be shown."""

    figure: Figure
    """What it looks like."""
    motion: MotionFrames
    """How it moves, but for arrows."""
    felt: Felt | None = None
    """What acted on it, if it was simulated."""
    policy: str = ""
    """What commands it, in words."""
    verdict: TaskVerdict | None = None
    """Whether it did its task, if that can be said."""
    notes: tuple[str, ...] = ()
    """What is to be known of it."""


def at_rest(robot: Robot, name: str) -> Show:
    """Return a body as it is described."""
    drawn = figure(robot, name=name)
    still = posed(drawn.model, drawn.model.qpos0[None])
    return Show(figure=drawn, motion=still)


def sweeps(robot: Robot, name: str, *, surroundings: str | None, seconds: float | None) -> Show:
    """Return a body whose joints go through their ranges, by no physics.

    Args:
        robot: The body.
        name: What to call it.
        surroundings: Name of the world that it is in; None for none.
        seconds: How long it takes; None for some seconds.

    Raises:
        EffectError: There is no such world.
        RobotError: The body has no shapes that the world could act on.
    """
    around = None if surroundings is None else world(surroundings, robot)
    drawn = figure(robot, () if around is None else around.effects, name=name)
    posture = Posture(drawn.model)
    poses, whole = swept(posture, SECONDS if seconds is None else seconds)
    held = Holding(robot, posture)
    left = margin(np.array([held.at(pose) for pose in poses]), held.limits)
    moved = replace(posed(drawn.model, poses), series={MARGIN: 100.0 * left})
    notes = () if around is None else around.notes
    if not whole:
        notes += ("its closed chains stop some joints before their limits",)
    if not posture.sound:
        notes += ("its closed chains do not close as it is described",)
    return Show(figure=drawn, motion=moved, notes=_named(name, notes))


def performs(
    task: Task, policy: Policy | None, name: str, *, text: str, seed: int, seconds: float | None
) -> Show:
    """Return a body at its task.

    Args:
        task: The task, in its world.
        policy: What commands it; None for nothing.
        name: What to call the body.
        text: What commands it, in words.
        seed: Of its start.
        seconds: How long; None for as long as the task.

    Raises:
        MorphError: The body cannot be simulated, or its policy does not fit its simulation.
    """
    run = ran(task, policy, seed=seed, seconds=seconds)
    acted = forces(run)
    drawn = figure(task.robot, task.effects, name=name)
    moved = replace(motion(run.model, run.time, run.position), series=series(task, run, acted))
    judged = verdict(task, run)
    notes = []
    if run.why:
        notes.append(f"{run.why}; it is shown as far as it was stable")
    if judged is not None and judged.missed:
        notes.append(f"missed {len(judged.missed)} goals: {', '.join(judged.missed)}")
    return Show(
        figure=drawn,
        motion=moved,
        felt=Felt(forces=acted, weight=_weight(run), size=size_of(drawn, moved)),
        policy=text,
        verdict=judged,
        notes=_named(name, notes),
    )


def _weight(run: SimulatedRun) -> float:
    """Return what a body weighs, N; where there is no gravity, what it would on the ground."""
    gravity = float(np.linalg.norm(run.model.opt.gravity)) or 9.81
    return float(run.model.body_mass.sum()) * gravity


def _named(name: str, notes: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{name}: {note}" for note in notes)
