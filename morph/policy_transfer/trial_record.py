"""Record of one trial on a target and its outcome."""

from __future__ import annotations

from dataclasses import dataclass

from morph.policy.policy import Policy
from morph.search.target import Experience


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialRecord:
    """One trial on a target."""

    policy: Policy
    """What was tried."""
    experience: Experience
    """What it showed."""
    origin: str
    """Where the policy came from: `source`, `adjusted`, `searched again`."""
