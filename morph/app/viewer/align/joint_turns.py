"""A body at rest, posed by hand, or with each mapped joint turned in sequence."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.app.viewer.align.chain_bodies import ChainPlayer
from morph.app.viewer.align.transfer_record import Told
from morph.app.viewer.content import Moment
from morph.app.viewer.motion import RATE, MotionFrames, posed
from morph.arrays import Array
from morph.policy_transfer.body import Body
from morph.policy_transfer.parts import names_of

SWING, SECONDS = 0.35, 2.0
"""How far a part is moved in its turn, rad, and for how long, s."""

SHIFT = 0.15
"""How far a part that slides is moved, by the size of its body."""


def turns(player: ChainPlayer, hop: Told) -> tuple[Array, Array, tuple[Moment, ...], str]:
    """Return times, states about rest, when each part has its turn, and what moves in words.

    Args:
        player: The source of a hop.
        hop: The hop; parts that its map leaves out have no turn.
    """
    body = moving(player)
    ends = {arrow.end for arrow in hop.parts.states}
    names = names_of(body).state[: body.size // 2]
    which = [at for at, name in enumerate(names) if name in ends] or [*range(len(names))]
    samples = round(SECONDS * RATE)
    wave = np.sin(2.0 * np.pi * np.arange(samples) / samples)
    states = np.zeros((samples * len(which), body.size))
    model = body.plant.model
    for turn, at in enumerate(which):
        slides = model.jnt_type[model.dof_jntid[at]] == mujoco.mjtJoint.mjJNT_SLIDE.value
        far = SHIFT * float(model.stat.extent) if slides else SWING
        states[turn * samples : (turn + 1) * samples, at] = far * wave
    moments = tuple(
        Moment(time=turn * SECONDS, title=f"{names[at]} of {player.name}")
        for turn, at in enumerate(which)
    )
    text = f"Each part of {player.name} is moved in its turn, by hand"
    return np.arange(len(states)) / RATE, states, moments, text


def rest(player: ChainPlayer) -> MotionFrames:
    """Return a body that stands where it rests, or as it is described if it can rest nowhere."""
    if player.figure is None:
        raise RuntimeError(f"{player.name} is not drawn")
    model = player.figure.model
    at = model.qpos0 if player.body is None else player.body.still.position
    return posed(model, np.asarray(at)[None])


def moving(player: ChainPlayer) -> Body:
    """Return the simulation of a body that has one."""
    if player.body is None:
        raise RuntimeError(f"{player.name} cannot move")
    return player.body
