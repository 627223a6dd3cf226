"""Every baseline."""

from __future__ import annotations

from morph.transfer.baselines.alone import Alone
from morph.transfer.baselines.baseline import Baseline
from morph.transfer.baselines.carried import Carried
from morph.transfer.baselines.ladder import Ladder
from morph.transfer.baselines.pooled import Pooled
from morph.transfer.baselines.prior import SourcePrior
from morph.transfer.baselines.scratch import Scratch
from morph.transfer.baselines.unadjusted import Unadjusted
from morph.transfer.baselines.values import Values

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
