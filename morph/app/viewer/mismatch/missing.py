"""The force that a model lacks along a recording, and what each finding makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.app.viewer.mismatch.freedoms import freedoms
from morph.app.viewer.mismatch.rollouts import hypothesis_of
from morph.app.viewer.mismatch.window import MismatchModel, Missing
from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.episodes import Episode
from morph.model.motion import Needed, needed
from morph.physics.effect import Effect

LOOKED = 0.5
"""Seconds over which a finding's share is averaged, so that one sample decides nothing."""


def missing(model: MismatchModel, episode: Episode, effects: Sequence[Effect] = ()) -> Missing:
    """Return the generalized force that a model lacks along an episode.

    The motion is smoothed as the diagnosis smooths it, and the force with it: it comes at
    most 40 times a second, and not near the ends, where smoothing makes up accelerations.

    Args:
        model: What is held against the recording.
        episode: The recording or a window of it.
        effects: Findings, whose shares are told.
    """
    hypothesis = hypothesis_of(model, episode.step)
    result = needed(hypothesis, hypothesis.start, episode)
    return Missing(
        time=result.time,
        force=result.missing,
        share={effect.label: _share(effect, result) for effect in effects},
    )


def _share(effect: Effect, result: Needed) -> Array:
    """Return an effect's own force times the one that is missing, shape (samples,)."""
    if effect.kind == "body" and effect.where not in result.motion.bodies:
        own = np.zeros_like(result.missing)
    else:
        known = {each.name: each.neutral or 0.0 for each in effect.parameters()}
        strengths = np.array([getattr(effect, name) - known[name] for name in effect.strengths])
        own = result.smooth(effect.regressor(result.motion) @ strengths)
    return np.asarray(np.nan_to_num((own * result.missing).sum(axis=1)))


def clearest(missed: Missing, label: str, joint: str | None, robot: Robot) -> float | None:
    """Return when a finding shows most, s since the window began; None if nowhere.

    That is where its own force and the missing one agree most over half a second; if they
    agree nowhere, where most is missing at its joint.

    Args:
        missed: What the description lacks.
        label: The finding's effect.
        joint: Name of its joint, None for one that is nowhere in particular.
        robot: The description.
    """
    if not len(missed.time):
        return None
    period = float(np.median(np.diff(missed.time))) if len(missed.time) > 1 else 1.0
    width = max(1, round(LOOKED / period))
    share = missed.share.get(label, np.zeros(len(missed.time)))
    if share.max() <= 0.0:
        own = [at for at, f in enumerate(freedoms(robot)) if joint in (None, f.joint.name)]
        force = missed.force[:, own]
        share = (force**2).sum(axis=1)
    mean = np.convolve(share, np.ones(width) / width, mode="same")
    if mean.max() <= 0.0:
        return None
    first = max(0, int(np.argmax(mean)) - width // 2)
    # Of that half second, the sample in which most of it is to be seen.
    return float(missed.time[first + int(np.argmax(share[first : first + width]))])


def joint_of(effect: Effect, robot: Robot) -> str | None:
    """Return the joint that an effect concerns; None if it is no single one."""
    names = {joint.name for joint in robot.joints}
    place = effect.where
    if effect.kind == "actuator":
        place = robot.actuator(place).joint or ""
    elif effect.kind == "sensor":
        place = place.removesuffix(".position")
    elif effect.kind == "body":
        place = next((joint.name for joint in robot.joints if joint.link == place), "")
    return place if place in names else None


def link_of(effect: Effect, robot: Robot) -> str | None:
    """Return the link that an effect concerns; None if it is no single one."""
    if effect.kind == "body":
        return effect.where
    joint = joint_of(effect, robot)
    return None if joint is None else robot.joint(joint).link
