"""All ways of matching, the cheapest first."""

from __future__ import annotations

from morph.make.match.inverse import InverseMatcher
from morph.make.match.matcher import Matcher
from morph.make.match.regulator import RegulatorMatcher
from morph.make.match.replan import Replan
from morph.make.match.tune import Tune

MATCHERS: tuple[Matcher, ...] = (InverseMatcher(), RegulatorMatcher(), Replan(), Tune())
"""What is tried, one after the other, until a policy does or the time is up."""
