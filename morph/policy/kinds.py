"""Every kind of policy that can be read and exported."""

from __future__ import annotations

from morph.policy.adjusted import SOURCES, Adjusted
from morph.policy.policy import Policy

KINDS: tuple[type[Policy], ...] = (*SOURCES, Adjusted)
"""A new kind is listed here, in `LAWS` of `export.py`, and in `tests/morph/policy`."""
