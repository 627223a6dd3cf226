"""Whether a robot that has learned to stand stays on its feet while it is pushed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from morph.app.cli.policy_rollout import driven
from morph.body.limbs import torso_of
from morph.body.load import load
from morph.physics.body.external_push import ExternalPush
from morph.physics.worlds import start_in, world
from morph.policy.store import load_policy
from morph.sim.simulator import Simulator
from morph.sim.stable import as_far_as_stable

SECONDS, STEP = 10.0, 0.002
"""How long it has to stand, and in what steps it is simulated, s."""
WEIGHTS, LONG = 0.1, 0.1
"""Each push in body weights, and for how long, s."""
PUSHES = ((2.0, 1.0, 0.0), (4.0, -1.0, 0.0), (6.0, 0.0, 1.0), (8.0, 0.0, -1.0))
"""When each begins, s, and which way it goes."""
SUNK = 0.2
"""Heights of the trunk by which it may sink or rise."""


def stands_pushed(path: Path, policy: Path, *, base: str | None, floor: str) -> bool:
    """Return whether a trunk stays within `SUNK` of its height through all pushes, upright.

    Args:
        path: The robot's description.
        policy: Folder of the policy that commands it.
        base: As `load` takes it.
        floor: Name of the world.
    """
    robot = load(path, base=base)
    trunk = torso_of(robot)
    if trunk is None:
        return False
    impulse = WEIGHTS * LONG * 9.81 * robot.mass
    pushes = [
        ExternalPush(body=trunk, start=at, end=at + LONG, x=x * impulse, y=y * impulse, z=0.0)
        for at, x, y in PUSHES
    ]
    simulator = Simulator(robot, (*world(floor, robot).effects, *pushes), step=STEP)
    start, learned = start_in(robot, floor), load_policy(policy, robot)
    if learned.observation:
        moved, why = driven(simulator, learned, seconds=SECONDS, start=start)
    else:
        commands: dict[str, Any] = dict(learned.commands())
        moved, why = as_far_as_stable(simulator, seconds=SECONDS, start=start, command=commands)
    if why is not None:
        return False
    run = simulator.recorded(moved, "pushed")
    height = run[f"{trunk}.position.z"] if f"{trunk}.position.z" in run.channels else None
    if height is None:
        return False
    tilt = [run[f"{trunk}.orientation.{axis}"] for axis in ("x", "y")]
    upright = 1.0 - 2.0 * (tilt[0] ** 2 + tilt[1] ** 2)
    level = np.abs(height - height[0]) < SUNK * max(abs(float(height[0])), 1e-9)
    return bool(level.all() and (upright > np.cos(np.radians(45.0))).all())
