"""Small moves of a state, as plans know them."""

from __future__ import annotations

from morph.sim.tangent import apart as apart
from morph.sim.tangent import moved_by as moved_by
from morph.sim.tangent import turning as turning
