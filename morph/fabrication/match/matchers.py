"""All ways of matching, the cheapest first."""

from __future__ import annotations

from morph.fabrication.match.inverse import InverseMatcher
from morph.fabrication.match.matcher import Matcher
from morph.fabrication.match.regulator import RegulatorMatcher
from morph.fabrication.match.replan import Replan
from morph.fabrication.match.tune import Tune

MATCHERS: tuple[Matcher, ...] = (InverseMatcher(), RegulatorMatcher(), Replan(), Tune())
"""What is tried, one after the other, until a policy does or the time is up."""
