"""Every rival."""

from __future__ import annotations

from morph.transfer.rivals.alone import Alone
from morph.transfer.rivals.carried import Carried
from morph.transfer.rivals.ladder import Ladder
from morph.transfer.rivals.pooled import Pooled
from morph.transfer.rivals.prior import Prior
from morph.transfer.rivals.rival import Rival
from morph.transfer.rivals.scratch import Scratch
from morph.transfer.rivals.unadjusted import Unadjusted
from morph.transfer.rivals.values import Values

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
