"""Dry friction that holds a joint at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from morph.arrays import Array, Mask
from morph.inference.sampled import SampledRun
from morph.physics.effect import Effect
from morph.physics.motion import Motion

REST, STILL, CREEP = 0.25, 1.4, 0.7
"""Least duration of a rest, s; most standard deviation of readings in it, in units of their noise;
and how fast the joint may creep, noises a second."""


def sticking(effects: Sequence[Effect], motion: Motion, run: SampledRun) -> Array:
    """Return the damping that stands for dry friction where a joint rests, (samples, dofs).

    Friction is that of a damper, whose force at the velocity of the motion is the friction's, and
    at velocities that noise hides less. A joint at rest thus withstands what drives it.

    Source: Hunter and Lange 2004, The American Statistician 58(1), eq. 5 (a quadratic that
    majorizes the absolute value).

    Args:
        effects: What acts beside the model.
        motion: The smoothed motion.
        run: Its readings, one of each joint's position.
    """
    found = np.zeros_like(motion.position)
    for effect in (each for each in effects if each.holds):
        dof = motion.joints[effect.where]
        friction = np.abs(effect.regressor(motion)[:, dof] @ effect.coefficients)
        still = resting(run, dof)
        # Velocities follow the noise where nothing holds the joint yet: take their mean.
        mean = uniform_filter1d(motion.speed(effect.where), max(2, round(REST / run.step)))
        speed = np.maximum(np.abs(mean), CREEP * run.noise[dof])
        found[still, dof] += (friction.max() / speed)[still]
    return found


def resting(run: SampledRun, channel: int) -> Mask:
    """Return where a reading varies by little more than its noise over `REST`, shape (samples,)."""
    width = max(2, round(REST / run.step))
    valid = run.valid[:, channel]
    value = np.where(valid, run.reading[:, channel], 0.0)
    value -= value.sum() / max(valid.sum(), 1) * valid
    count, total, squares = (
        uniform_filter1d(each.astype(float), width) for each in (valid, value, value**2)
    )
    count = np.maximum(count, 1.0 / width)
    quiet = squares / count - (total / count) ** 2 < (STILL * run.noise[channel]) ** 2
    # A window is about its middle. Its ends may still move, as may the joint near them.
    return np.asarray(maximum_filter1d(quiet.astype(float), max(1, width // 2)) > 0.0)
