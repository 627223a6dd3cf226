"""Every kind of policy that can be read and exported."""

from __future__ import annotations

from morph.policy.linear import Linear
from morph.policy.network import Network
from morph.policy.pattern import Pattern
from morph.policy.policy import Policy
from morph.policy.radial import Radial
from morph.policy.track import Track

KINDS: tuple[type[Policy], ...] = (Pattern, Linear, Radial, Network, Track)
"""A new kind is listed here, in `LAWS` of `export.py`, and in `tests/morph/policy`."""
