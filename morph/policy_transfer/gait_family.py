"""Gaits of one walker transferred to another, through foot motion learned from transitions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action, actions_of
from morph.search.family.family import Family, Number
from morph.search.family.gait import Gait
from morph.sim.closed_loop import closed_loop
from morph.task.moved import Moved
from morph.task.task import Task
from morph.task.torso import feet_of, torso

HOLD = 0.1
"""How long a set point is held while joints are tried, s: servos settle in it."""

EACH = 10
"""Transitions of a run, for a body that trembles falls in time."""

TREMBLE = 0.06
"""Standard deviation of the set points, rad."""

NUMBERS = 4
"""Of each foot: ahead, aside and above the torso, and its pitch."""

RIDGE = 1e-3
"""Share of the largest squared response below which a response counts as noise."""

SWAY = 0.15
"""Greatest amplitude of what leans aside, rad."""

Told = Callable[[Array, Array, Array], Array]
"""From positions (m, nq), velocities (m, nv) and set points (m, nu) to commands."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """What set points do to feet, once servos have settled: z = z0 + gain g."""

    gain: Array
    """Shape (feet * NUMBERS, nu), m or rad per rad."""
    rest: Array
    """z0, shape (feet * NUMBERS,)."""
    samples: int
    """From how many transitions it was learned."""

    @property
    def leg(self) -> float:
        """How far below the torso the feet are, m."""
        return float(-self.rest.reshape(-1, NUMBERS)[:, 2].mean())


def feet(moved: Moved, task: Task) -> Array:
    """Return where the feet are as the torso sees them, shape (..., samples, feet * NUMBERS).

    The pitch is that of the foot's long axis, x, over the torso's.
    """
    model = moved.model
    trunk = moved.pose(model.body(torso(task.robot, task.name)).id)
    turned = np.swapaxes(trunk.rotation, -1, -2)
    seen = []
    for name in feet_of(task.robot):
        foot = moved.pose(model.body(name).id)
        place = np.einsum("...ij,...j->...i", turned, foot.position - trunk.position)
        ahead = np.einsum("...ij,...j->...i", turned, foot.rotation[..., 0])
        pitch = np.arctan2(-ahead[..., 2], ahead[..., 0])
        seen += [place, pitch[..., None]]
    return np.concatenate(seen, axis=-1)


def tried(
    task: Task, progress: Told, count: int, rng: np.random.Generator, *, noise: float = 0.001
) -> Response:
    """Return what set points do to the feet, from so many transitions of random ones.

    On its feet a body cannot move each joint by itself, so what joints do to feet is fitted to
    where the joints came to be, z = z0 + J q, with a ridge for noise; and which way a set point
    moves its joint, to where each went.

    Args:
        task: The body, standing where its start has it.
        progress: From set points to commands.
        count: How many transitions of HOLD s.
        rng: The chance of starts, set points and noise.
        noise: Of every angle and every number of the feet, rad or m.

    Raises:
        TransferError: There are fewer transitions than numbers to be learned.
    """
    commands = len(task.robot.actuators)
    rows = -(-count // EACH)
    simulator = task.simulator()
    q, v = task.start.sample(task.robot, simulator.model, rows, rng)
    points = TREMBLE * rng.standard_normal((EACH, rows, commands))

    def act(position: Array, velocity: Array, time: float) -> Array:
        return progress(position, velocity, points[min(int(time / HOLD + 1e-6), EACH - 1)])

    loop = closed_loop(simulator, act, q, v, period=task.period, seconds=EACH * HOLD)
    moved = Moved(
        robot=task.robot,
        model=simulator.model,
        time=loop.time,
        position=loop.position,
        velocity=loop.velocity,
        command=loop.command,
    )
    every = round(HOLD / task.period)
    z = feet(moved, task)[:, ::every][:, : EACH + 1]
    z = z + noise * rng.standard_normal(z.shape)
    driven = [simulator.model.joint(each.joint).qposadr[0] for each in task.robot.actuators]
    angle = loop.position[:, ::every][:, : EACH + 1][..., driven]
    angle = angle + noise * rng.standard_normal(angle.shape)
    known, after = (each[:, 1:].reshape(-1, each.shape[-1])[:count] for each in (angle, z))
    moved_by = np.diff(angle, axis=1).reshape(-1, commands)[:count]
    requested = np.swapaxes(points, 0, 1).reshape(-1, commands)[:count]
    if not np.isfinite(after).all() or len(known) <= commands:
        raise TransferError(
            f"{len(known)} transitions of {commands} joints do not tell what each does",
            where=f"gait of {task.robot.name}",
            fix="give more transitions than it has joints, of a body that stands",
        )
    x, centre = known - known.mean(axis=0), after.mean(axis=0)
    square = x.T @ x + len(x) * noise**2 * np.eye(commands)
    slope = np.linalg.solve(square, x.T @ (after - centre)).T
    gain = slope * np.sign((requested * moved_by).sum(axis=0))
    return Response(gain=gain, rest=centre, samples=count)


def joint_map(source: Response, target: Response) -> Array:
    """Return which set points of the target move its feet as those of the source move its own.

    M minimises |G_t M - D G_s|^2 with a ridge, D scaling places by the ratio of the legs: only
    what walkers in a plane have is asked for, ahead, above and pitch; aside is to stay.

    Returns:
        M, shape (commands of the target, commands of the source).

    Raises:
        TransferError: The bodies have not as many feet as each other.
    """
    if len(source.rest) != len(target.rest):
        raise TransferError(
            f"one has {len(source.rest) // NUMBERS} feet, the other {len(target.rest) // NUMBERS}",
            where="a gait carried from walker to walker",
            fix="give two bodies with as many feet",
        )
    ratio = target.leg / source.leg
    scale = np.tile([ratio, ratio, ratio, 1.0], len(source.rest) // NUMBERS)
    wanted = scale[:, None] * source.gain
    wanted[1::NUMBERS] = 0.0
    return _solved(target, wanted)


def leaning(target: Response) -> Array:
    """Return the set points that move all feet aside by one leg, shape (commands,)."""
    wanted = np.zeros((len(target.rest), 1))
    wanted[1::NUMBERS] = target.leg
    # Only aside is asked for: what else moves a little is for the gait to undo.
    return _solved(target, wanted, counted=(0.1, 1.0, 0.1, 0.1))[:, 0]


def _solved(
    target: Response, wanted: Array, *, counted: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
) -> Array:
    # A radian of pitch counts as much as a place that is one leg away.
    unit = np.array([1.0, 1.0, 1.0, target.leg]) / target.leg
    weight = np.tile(np.array(counted) * unit, len(target.rest) // NUMBERS)
    gain, requested = weight[:, None] * target.gain, weight[:, None] * wanted
    square = gain.T @ gain
    ridge = RIDGE * float(np.linalg.eigvalsh(square)[-1])
    return np.asarray(np.linalg.solve(square + ridge * np.eye(len(square)), gain.T @ requested))


@dataclass(frozen=True, kw_only=True, eq=False)
class TransferredGaits(Family):
    """The gaits of a source as a target's patterns: p + M g_s(t) + s a sin(2 pi F t + f).

    What a source in a plane cannot know, how the target leans aside (a and f), is added.
    """

    gait: Gait
    """The source's gaits, g_s; their numbers are the first of this family's."""
    map: Array
    """M, shape (commands of the target, commands of the source)."""
    sway: Array
    """s, the set points that lean aside by a radian, shape (commands of the target,)."""
    posture: Array
    """p, rad, shape (commands of the target,)."""
    action: tuple[Action, ...]
    """Every actuator of the target."""
    period: float
    """How long each command is held, s."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values: those of the gait, then sway and its phase."""
        *walked, lean, phase = values
        source = self.gait.make(np.array(walked)).swings
        offset = np.array([swing.offset for swing in source])
        turned = np.array([swing.amplitude * np.exp(1j * swing.phase) for swing in source])
        swung = self.map @ turned + self.sway * lean * np.exp(1j * phase)
        place = self.posture + self.map @ offset
        swings = tuple(
            Swing(
                offset=float(middle),
                amplitude=float(abs(each)),
                frequency=source[0].frequency,
                phase=float(np.angle(each)),
            )
            for middle, each in zip(place, swung, strict=True)
        )
        return Pattern(swings=swings, action=self.action, period=self.period)


def carried(
    gait: Gait,
    values: Array | None,
    responses: tuple[Response, Response],
    target: Task,
    *,
    map: Array | None = None,
) -> TransferredGaits:
    """Return the gaits of a source on a target, begun at the source's own.

    Time goes with the square root of the legs, as of pendulums.

    Source: Alexander 1989, Physiological Reviews 69(4), for gaits that are dynamically similar.

    Args:
        gait: The source's gaits.
        values: What was found for the source; None to begin where the gaits begin.
        responses: What set points do to the feet of the source and of the target.
        target: Its task, which begins in the posture about which it is to walk.
        map: Which set points of the target do what the source's do; learned if none is given.
    """
    source, seen = responses
    faster = float(np.sqrt(source.leg / seen.leg))
    numbers = []
    for at, number in enumerate(gait.numbers):
        start = number.start if values is None else float(values[at])
        low, high = number.low, number.high
        if number.name == "frequency":
            low, high, start = faster * low, faster * high, faster * start
        numbers.append(
            Number(name=number.name, low=low, high=high, start=float(np.clip(start, low, high)))
        )
    numbers += [
        Number(name="sway", low=0.0, high=SWAY, start=0.3 * SWAY),
        Number(name="sway's phase", low=-0.5 * np.pi, high=2.5 * np.pi, start=0.0),
    ]
    posture = [
        target.start.position.get(target.robot.driven_by(each).name, 0.0)
        for each in target.robot.actuators
    ]
    return TransferredGaits(
        numbers=tuple(numbers),
        sigma=0.15,
        gait=gait,
        map=joint_map(source, seen) if map is None else map,
        sway=leaning(seen),
        posture=np.array(posture),
        action=actions_of(target.robot),
        period=target.period,
    )
