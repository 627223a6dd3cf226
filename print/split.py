"""A part that is larger than the bed, cut into pieces that go together one way only."""

from __future__ import annotations

from print.errors import SplitError
from print.orient import fits
from print.part import Part
from print.printer import Profile


def split(part: Part, profile: Profile) -> tuple[Part, ...]:
    """Return the pieces of a part; the part itself where it fits the bed.

    Raises:
        SplitError: It cannot be cut so that its pieces fit the bed and go together.
    """
    if part.mesh is None or fits(part.mesh, profile):
        return (part,)
    raise SplitError(
        "the part is larger than the bed, and is not cut yet",
        where=f"part {part.name}",
        fix="name a larger printer",
    )
