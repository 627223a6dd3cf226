"""Baseline: source and target data pooled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.baseline import needs_experience
from morph.policy_transfer.baselines.learner import Learner, periods
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class Pooled(Learner):
    """Learns from all runs as if one body had made them.

    Where both bodies were in a state, what is learned is the mean of the two, and their
    difference is taken for noise.

    Source: one Gaussian process of all experience, Meger, Gamboa Higuera, Xu and Dudek 2015,
    Learning legged swimming gaits from experience, ICRA; that transfer may harm, Taylor and
    Stone 2009, Transfer learning for reinforcement learning domains, JMLR 10.
    """

    name: ClassVar[str] = "pooled data"

    def check(self, source: Source) -> None:
        """Refuse a source without experience."""
        needs_experience(self, source)

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what all runs say."""
        both = (*source.experience, *memory.experience)
        return fit(periods(both, settings, source.task), settings, memory.logs)
