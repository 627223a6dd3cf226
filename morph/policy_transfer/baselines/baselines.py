"""Every baseline."""

from __future__ import annotations

from morph.policy_transfer.baselines.alone import Alone
from morph.policy_transfer.baselines.baseline import Baseline
from morph.policy_transfer.baselines.carried import Carried
from morph.policy_transfer.baselines.ladder import Ladder
from morph.policy_transfer.baselines.pooled import Pooled
from morph.policy_transfer.baselines.prior import SourcePrior
from morph.policy_transfer.baselines.scratch import Scratch
from morph.policy_transfer.baselines.unadjusted import Unadjusted
from morph.policy_transfer.baselines.values import Values

BASELINES: tuple[type[Baseline], ...] = (
    Unadjusted,
    Scratch,
    Alone,
    Pooled,
    SourcePrior,
    Carried,
    Values,
    Ladder,
)
"""All of them, controls first."""
