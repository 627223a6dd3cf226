"""Whether runs are explained to their noise, so that evidence decides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.inference.observed import Observed, missing

LITTLE_FORCE, LITTLE_VIBRATION = 0.03, 1.0
"""Missing force over the inertial force, and vibration in units of the noise, up to which runs are
explained to their noise."""
SOME_FORCE = 0.1
"""The same force, up to which its model holds, and evidence decides that rollouts do not refute."""
CERTAIN, EVENT = 20.0, 15.0
"""Gain in evidence, nats, that needs no gain in rollouts where readings are at their noise; and of
what happens in one run alone, which is looked for only where a force stands out."""


def evidence_decides(runs: Sequence[Observed]) -> bool:
    """Return whether the model of what remains holds: there is little beside the noise."""
    return at_noise(runs, SOME_FORCE)


def certain(gain: float, runs: Sequence[Observed], *, event: bool = False) -> bool:
    """Return whether an effect needs no gain in rollouts, such is its evidence.

    Args:
        gain: Gain in evidence by it, nats.
        runs: Smoothed runs.
        event: Whether it happens in one run alone. The few rollouts in which it acts are never sure
            of it, so that evidence decides beside vibration too.
    """
    if event:
        return gain > EVENT and missing(runs) < SOME_FORCE
    return gain > CERTAIN and evidence_decides(runs)


def at_noise(runs: Sequence[Observed], force: float = LITTLE_FORCE) -> bool:
    """Return whether runs are explained to their noise, but for a little missing force."""
    known = [(run.about.disturbance.vibration, run.about.sensed) for run in runs]
    # Sensors of velocity, the last channels, do not vibrate.
    vibrations = [(each / noise[: len(each)]) ** 2 for each, noise in known if each is not None]
    return missing(runs) < force and float(np.sqrt(np.mean(vibrations))) < LITTLE_VIBRATION
