"""Baseline: samples of the source, until the target's own are near."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from morph.arrays import Array
from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.model.jointed.transition import JointTransitions
from morph.policy_transfer.baselines.baseline import needs_experience
from morph.policy_transfer.baselines.learner import Learner, periods
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class Carried(Learner):
    """Learns from the target's samples, and from the source's where there are none of these.

    Source: Taylor, Jong and Stone 2008, Transferring instances for model-based reinforcement
    learning, ECML, where a source's instances stand in until there are enough of the target's
    nearby.
    """

    name: ClassVar[str] = "samples carried over"

    near: float = 1.0
    """How near a sample of the target must be to replace one of the source, in units of the
    spread of velocities and commands, and of the radius of a turn for angles."""

    def check(self, source: Source) -> None:
        """Refuse a source without experience."""
        needs_experience(self, source)

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what the target's samples and those left of the source's say."""
        own = periods(memory.experience, settings, source.task)
        lent = periods(source.experience, settings, source.task)
        size = np.concatenate([lent.velocity.std(axis=0) + 1e-9, settings.command_size])
        places = [_placed(each, settings, size) for each in (own, lent)]
        away, _ = cKDTree(places[0]).query(places[1])
        kept = [np.flatnonzero(away > self.near), len(away) + np.arange(len(own.command))]
        return fit(_joined(lent, own).rows(np.concatenate(kept)), settings, memory.logs)


def _placed(data: JointTransitions, settings: JointedSettings, size: Array) -> Array:
    """Return periods as points: cos and sin of angles, velocities and commands over their sizes."""
    angle = data.position[:, list(settings.turning)]
    rates = np.concatenate([data.velocity, data.command], axis=1) / size
    return np.concatenate([np.cos(angle), np.sin(angle), rates], axis=1)


def _joined(first: JointTransitions, second: JointTransitions) -> JointTransitions:
    names = [each.name for each in fields(JointTransitions) if each.name != "period"]
    both = {name: np.concatenate([getattr(a, name) for a in (first, second)]) for name in names}
    return JointTransitions(**both, period=second.period)
