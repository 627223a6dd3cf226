"""Dry friction along a smoothed motion: where joints stick, and what holds them there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import erf

from morph.arrays import Array, Mask
from morph.inference.sampled import Reference
from morph.physics.effect import Effect
from morph.physics.motion import Motion

SLIPS = 2.5
"""Velocity in units of its standard deviation from which a joint slips, at first sight."""
HELD = 0.999
"""Most share of friction that holds a joint, at first sight."""
STIFF = 30.0
"""Damping of a joint that sticks, in units of its inertia over a step: what is left of a velocity
after a step is 1 / (1 + STIFF)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Friction:
    """Dry friction of all joints, set-valued at rest.

    Its force is minus its level times its sense. A joint of which the sense lies between -1 and 1
    sticks: it is held by a stiff damper, and the damper's force goes into the sense.

    Source: Alart and Curnier 1991, Computer Methods in Applied Mechanics and Engineering 92(3),
    sections 3 and 4 (the augmented Lagrangian of friction, and which contacts stick).
    """

    senses: Mapping[str, Array]
    """The sense by joint, from -1 to 1, shape (samples,) each."""
    level: Array
    """Greatest friction, N m or N, shape (samples, dofs)."""
    damping: Array
    """Where a joint sticks, N m s/rad or N s/m, same shape."""


def friction(effects: Sequence[Effect], motion: Motion, about: Reference) -> Friction:
    """Return the friction of some effects along a motion; see `sensed` for its senses.

    Args:
        effects: What acts beside the model.
        motion: The smoothed motion.
        about: Its velocities and how far they may be off.
    """
    motion = sensed([each.where for each in effects if each.holds], motion, about)
    level, damping = np.zeros_like(about.velocity), np.zeros_like(about.velocity)
    inertia = 1.0 / np.einsum("tii->ti", about.mobility)
    for effect in (each for each in effects if each.holds):
        joint, dof = effect.where, motion.joints[effect.where]
        full = replace(motion, senses={joint: np.ones(len(level))})
        level[:, dof] += np.abs(effect.regressor(full)[:, dof] @ effect.coefficients)
        sticks = np.abs(motion.senses[joint]) < 1.0
        damping[:, dof] = np.where(sticks, STIFF / about.tangent.step * inertia[:, dof], 0.0)
    return Friction(senses=motion.senses, level=level, damping=damping)


def sensed(joints: Sequence[str], motion: Motion, about: Reference) -> Motion:
    """Return a motion with senses of dry friction on some joints, those it has unchanged.

    A joint slips that surely moves. One at rest is held by the missing force, if that opposes
    the motion of a joint that slips: as a share of what it does there.

    Args:
        joints: Their names.
        motion: The smoothed motion.
        about: Its velocities, how far they may be off, and the missing force.
    """
    velocity, senses = ending(about), dict(motion.senses)
    spread = np.maximum(np.concatenate([about.spread[1:], about.spread[-1:]]), 1e-12)
    for joint in joints:
        if joint in senses:
            continue
        dof = motion.joints[joint]
        ratio = velocity[:, dof] / spread[:, dof]
        slips, sign = np.abs(ratio) > SLIPS, np.sign(ratio)
        opposes = -about.force[:, dof] * sign
        level = float(np.median(opposes[slips])) if slips.any() else 0.0
        held = erf(ratio / math.sqrt(2.0))
        if level > 0.0:
            held = np.clip(-about.force[:, dof] / level, -HELD, HELD)
        senses[joint] = np.where(slips, sign, held)
    return replace(motion, senses=senses)


def moved(before: Friction, motion: Motion, about: Reference) -> Motion:
    """Return a motion with the senses of friction after a step of the augmented Lagrangian.

    A joint that stuck goes on unless more than its friction was needed to hold it. One that slipped
    and has turned sticks where friction could stop it within a step.

    Args:
        before: The friction under which the motion was smoothed.
        motion: The smoothed motion.
        about: Its velocities.
    """
    velocity, mobility = ending(about), np.einsum("tii->ti", about.mobility)
    sticks = before.damping > 0.0
    within_a_step = velocity / (about.tangent.step * mobility)
    change = np.where(sticks, before.damping * velocity - about.force, within_a_step)
    change /= np.maximum(before.level, 1e-12)
    senses = {
        joint: np.clip(sense + change[:, motion.joints[joint]], -1.0, 1.0)
        for joint, sense in before.senses.items()
    }
    return replace(motion, senses=senses)


def ending(about: Reference) -> Array:
    """Return the velocity at each step's end, which friction brings to zero, (samples, dofs)."""
    return np.concatenate([about.velocity[1:], about.velocity[-1:]])


def slipping(effect: Effect, motion: Motion) -> Mask | bool:
    """Return where more friction would be felt: not where it holds a joint, shape (samples,)."""
    return np.abs(motion.sign(effect.where)) >= 1.0 if effect.holds else True
