"""What moves a body of a chain: the policy that a hop kept for it, or the next best."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from morph.alignment.maps.body_map import BodyMap
from morph.app.viewer.align.chain_bodies import ChainPlayer
from morph.app.viewer.align.joint_turns import moving
from morph.app.viewer.align.read import inside
from morph.app.viewer.align.transfer_record import Story
from morph.arrays import Array
from morph.errors import MorphError, ViewError
from morph.npz import load_npz
from morph.policy.store import load_policy
from morph.policy_transfer.body import Body, Law, linear_law
from morph.policy_transfer.controls import through
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.policy_conversion import law_of

MOST_BYTES = 20_000_000
"""Largest file of a law, packed or not."""


def law(
    story: Story, players: Sequence[ChainPlayer], maps: Sequence[BodyMap | None], at: int
) -> tuple[Law, str]:
    """Return what moves a body of a chain, and in words what that is.

    Args:
        story: What the folder tells.
        players: The bodies of the chain.
        maps: The map of each hop.
        at: Number of the body, which must have a simulation.
    """
    body, name = moving(players[at]), players[at].name
    result = kept(story, body, at)
    if result is not None:
        return linear_law(*result), f"{name} moves by the policy that was made for it"
    if at == len(players) - 1 and story.policy is not None:
        try:
            carried = law_of(body, load_policy(story.policy, body.task.robot))
        except MorphError:
            # Another body's, or spoilt; what moves it then is said.
            pass
        else:
            return carried, f"{name} moves by the policy that was made for it"
    before, body_map = (players[at - 1].body, maps[at - 1]) if at else (None, None)
    if before is not None and body_map is not None:
        gain = holding(before)
        words = f"{name} moves by the regulator of {players[at - 1].name}, seen through the map"
        return through(body_map, gain, np.zeros(len(gain))), words
    return linear_law(holding(body)), f"{name} moves by the regulator of its own description"


def kept(story: Story, body: Body, at: int) -> tuple[Array, Array] | None:
    """Return gain and shift that a hop kept for a body of the chain, None if there are none.

    Raises:
        ViewError: The file is spoilt.
    """
    path = inside(story.folder, f"hops/{at:02d}/law.npz") if at else None
    if path is None:
        return None
    gain, shift = _numbers(path)
    shape = (len(body.bounds[0]), body.size)
    return (gain, shift) if gain.shape == shape and shift.shape == shape[:1] else None


def _numbers(path: Path) -> tuple[Array, Array]:
    try:
        held = load_npz(path, MOST_BYTES)
        gain, shift = (np.asarray(held[name], dtype=float) for name in ("gain", "shift"))
        if not (np.isfinite(gain).all() and np.isfinite(shift).all()):
            raise ValueError("it holds numbers that are not finite")
    except (OSError, ValueError, KeyError) as error:
        raise ViewError(
            f"it cannot be read: {error}",
            where=str(path),
            fix="remove it, and another policy moves the body; or run `morph transfer` again",
        ) from error
    return gain, shift
