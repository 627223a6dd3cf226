"""Every rival."""

from __future__ import annotations

from morph.transfer.baselines.alone import Alone
from morph.transfer.baselines.carried import Carried
from morph.transfer.baselines.ladder import Ladder
from morph.transfer.baselines.pooled import Pooled
from morph.transfer.baselines.prior import Prior
from morph.transfer.baselines.rival import Rival
from morph.transfer.baselines.scratch import Scratch
from morph.transfer.baselines.unadjusted import Unadjusted
from morph.transfer.baselines.values import Values

RIVALS: tuple[type[Rival], ...] = (
    Unadjusted,
    Scratch,
    Alone,
    Pooled,
    Prior,
    Carried,
    Values,
    Ladder,
)
"""All of them, controls first."""
