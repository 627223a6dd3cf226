"""What `morph weigh` takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from morph.app.cli.options import unset


@dataclass(frozen=True, kw_only=True)
class Weigh:
    """Correct a package by what a scale shows of its parts, and try its policy again.

    Readings add up over several commands; a later one of the same part replaces the earlier.
    Exit status 3: the policy is lost on the corrected robot, and none was found in time.

    Example: morph weigh package P-01=12.4 forearm=49.6/4
    """

    package: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="DIR")]
    """A folder that `morph print` wrote."""
    reading: Annotated[tyro.conf.Positional[tuple[str, ...]], unset("PART=GRAMS ...")] = ()
    """A part's name or number, and what one copy weighs, without support; PART=GRAMS/COUNT for
    several copies together, PART=predicted to forget a reading; none to try the policy alone."""
    anyway: bool = False
    """Take readings that are more than 30 % off what was predicted."""
    match: bool = True
    """Match a policy that no longer holds again; or only say whether it holds."""
    seconds: float = 60.0
    """Longest that matching the policy may take."""
    seed: int = 0
    """Random seed."""
    json: bool = False
    """Print package.json instead of words."""
    quiet: bool = False
    """Show no progress."""
