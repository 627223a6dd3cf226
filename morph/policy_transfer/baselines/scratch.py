"""Baseline: learning from scratch on the target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.policy_transfer.baselines.baseline import NextStep
from morph.policy_transfer.baselines.learner import Learner, periods, randomly
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class Scratch(Learner):
    """Begins with random commands; then it is the search gp-ddp, at this effort."""

    name: ClassVar[str] = "from scratch"

    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return what runs of the target say."""
        return fit(periods(memory.experience, settings, source.task), settings, memory.logs)

    def first(self, source: Source, rng: np.random.Generator) -> NextStep:
        """Return random commands."""
        return randomly(source.task, rng, share=1.0, why="nothing is known")
