"""Baseline: the source's accelerations as the prior mean of the target's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.learner import Learner, periods
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class SourcePrior(Learner):
    """Learns what the source misses: far from the target's runs it believes the source.

    The mean of the target's Gaussian process is that of one learned from many runs in the
    source's simulator.

    Source: Cutler and How 2015, Efficient reinforcement learning for robots using informative
    simulated priors, ICRA; there the mean is a network of radial basis functions, and the policy
    PILCO's.
    """

    name: ClassVar[str] = "simulator as prior"

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what the source says, corrected by what runs of the target say."""
        data = periods(memory.experience, settings, source.task)
        return fit(data, settings, memory.logs, source.believed.mean)
