"""What can go wrong while planting."""

from __future__ import annotations

from typing import TypeVar

from morph.errors import MorphError

Thing = TypeVar("Thing")


class PlantError(MorphError):
    """A defect was to be planted where the description has nothing to plant it in."""


def there(thing: Thing | None, what: str) -> Thing:
    """Return a thing that the site's facts promised.

    Raises:
        PlantError: It is not there.
    """
    if thing is None:
        raise PlantError(
            f"there is no {what}",
            where="experiments.plant",
            fix="plant only at sites for which Defect.fact gives a fact",
        )
    return thing
