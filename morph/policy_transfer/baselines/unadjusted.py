"""Baseline: the source's policy, unchanged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.policy_transfer.baselines.baseline import Baseline, NextStep
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint


@dataclass(frozen=True, kw_only=True)
class Unadjusted(Baseline):
    """Tries what worked on the source in every trial, and learns nothing."""

    name: ClassVar[str] = "unadjusted"

    def step(self, source: Source, memory: SearchCheckpoint, rng: np.random.Generator) -> NextStep:
        """Return the source's policy."""
        return NextStep(policy=source.policy, note="the source's policy")
