"""Noisy runs of the swimmer in worlds that are in the ensemble, near it, and not in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.swim.gaits import begun, straight
from experiments.waters.worlds import STEP, WORLDS, Disturbance, World, halfway
from morph.arrays import Array
from morph.model.latent.run import Run
from morph.sim.simulator import Simulator
from morph.sim.tangent import moved_by

PERIOD = 0.05
"""Control period and time between observations, s."""

SECONDS = 5.0
"""How long a run lasts."""

NOISE = 0.01
"""Of every observed number: m, rad, m/s and rad/s."""

KINDS = ("clean", "disturbed", "between", "none")
"""Kinds of truth."""

PAIRS = ((0, 3), (3, 4), (0, 2))
"""Neighbours between which a truth may lie: fresh and brackish, brackish and salt, overgrown."""

STRANGE = (
    (replace(WORLDS[0], name="brine", density=1100.0), Disturbance()),
    (replace(WORLDS[0], name="paddles torn"), Disturbance(thrust=0.2, paddle_drag=0.4)),
    (replace(WORLDS[0], name="strong current"), Disturbance(current=(-0.3, 0.2, 0.0))),
)
"""Worlds that no model is near."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """One run and what it came from."""

    kind: str
    """One of `KINDS`."""
    seed: int
    """Of its draws."""
    truth: tuple[int, ...]
    """The models that are right: one, two neighbours, or none."""
    unknown: Disturbance
    """What acts beside."""
    run: Run
    """What was recorded."""


def drawn(kind: str, seed: int) -> Case:
    """Return a case; worlds take turns with the seeds, so each is as frequent as the others."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    truth, world, unknown = _truth(kind, seed, rng)
    return Case(
        kind=kind,
        seed=seed,
        truth=truth,
        unknown=unknown,
        run=recorded(world.simulator(unknown), rng),
    )


def _truth(
    kind: str, seed: int, rng: np.random.Generator
) -> tuple[tuple[int, ...], World, Disturbance]:
    if kind == "none":
        return (), *STRANGE[seed % len(STRANGE)]
    if kind == "between":
        one, other = PAIRS[seed % len(PAIRS)]
        return (one, other), halfway(WORLDS[one], WORLDS[other]), Disturbance()
    right = seed % len(WORLDS)
    unknown = disturbance(rng) if kind == "disturbed" else Disturbance()
    return (right,), WORLDS[right], unknown


def disturbance(rng: np.random.Generator) -> Disturbance:
    """Return a current of up to 0.05 m/s and drags off by 10 to 20 %, either way."""
    flow = rng.normal(size=3)
    x, y, z = rng.uniform(0.0, 0.05) * flow / np.linalg.norm(flow)
    hull, paddle, thrust = 1.0 + rng.choice((-1.0, 1.0), 3) * rng.uniform(0.1, 0.2, 3)
    return Disturbance(
        current=(float(x), float(y), float(z)),
        hull_drag=float(hull),
        paddle_drag=float(paddle),
        thrust=float(1.0 + 0.5 * (thrust - 1.0)),
    )


def recorded(simulator: Simulator, rng: np.random.Generator) -> Run:
    """Return a run with a drawn stroke from a drawn start, with noise on all that is seen."""
    robot, model = simulator.robot, simulator.model
    gait = straight(
        robot,
        amplitude=float(rng.uniform(0.3, 0.6)),
        frequency=float(rng.uniform(1.5, 2.5)),
        lean=float(rng.uniform(-0.2, 0.2)),
        left=float(rng.uniform(0.7, 1.0)),
        phase=float(rng.uniform(0.0, 2.0 * np.pi)),
    )
    periods = round(SECONDS / PERIOD)
    # What is told holds for a whole period, as a controller on this clock would have it.
    held = {
        name: (lambda times, told=told: told(PERIOD * np.floor(times / PERIOD + 1e-6)))
        for name, told in gait.commands().items()
    }
    speed = {"hull.linear_velocity.x": float(rng.uniform(0.0, 0.2))}
    speed |= {f"hull.angular_velocity.{axis}": float(rng.normal(scale=0.1)) for axis in "xyz"}
    moved = simulator.trajectory(
        seconds=SECONDS, start=begun(gait, robot), speed=speed, command=held
    )
    every = round(PERIOD / STEP)
    told: Array = np.zeros((periods, model.nu))
    for name, values in moved.command.items():
        told[:, model.actuator(name).id] = values[::every]
    off = rng.normal(scale=NOISE, size=(2, periods + 1, model.nv))
    return Run(
        position=moved_by(model, moved.position[::every], off[0]),
        velocity=moved.velocity[::every] + off[1],
        command=told,
        period=PERIOD,
    )
