"""What effects have said of a pair, kept with the pair so that their order does not matter."""

from __future__ import annotations

from typing import Any


def marks(pair: Any) -> frozenset[str]:
    """Return the names of the effects that have set a pair's spring or damper."""
    return frozenset(str(pair.info).split())


def marked(pair: Any, name: str) -> None:
    """Add an effect's name to a pair; MuJoCo shows it with errors of that pair."""
    pair.info = " ".join(sorted(marks(pair) | {name}))
