"""Baseline: the target's data alone; of the source the first trial's policy only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.learner import Learner, periods
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class Alone(Learner):
    """Learns from the target alone, which is what pooled data must beat to be worth anything."""

    name: ClassVar[str] = "target data alone"

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what runs of the target say."""
        return fit(periods(memory.experience, settings, source.task), settings, memory.logs)
