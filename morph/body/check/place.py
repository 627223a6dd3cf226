"""Where in a description a finding stands."""

from __future__ import annotations

from morph.body.draft import Draft, DraftJoint, DraftLink
from morph.body.finding import Where

WORLD = "world"
"""What descriptions, and MuJoCo, call what does not move."""


def at_link(draft: Draft, link: DraftLink, line: int = 0) -> Where:
    """Return the place of a link, or of a line in it."""
    return Where(kind="link", name=link.name, file=str(draft.file), line=line or link.line)


def at_joint(draft: Draft, joint: DraftJoint) -> Where:
    """Return the place of a joint."""
    return Where(kind="joint", name=joint.name, file=str(draft.file), line=joint.line)


def at_robot(draft: Draft) -> Where:
    """Return the place of the whole description."""
    return Where(kind="robot", name=draft.name, file=str(draft.file))
