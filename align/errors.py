"""The errors that align raises on purpose, each in three parts."""

from __future__ import annotations


class AlignError(Exception):
    """Base of every error that align raises on purpose.

    Args:
        what: What was found, with the value and the values allowed.
        where: Which data or which setting.
        fix: How to put it right.
    """

    def __init__(self, what: str, *, where: str, fix: str) -> None:
        super().__init__(f"{where}: {what}\n  fix: {fix}")
        self.what, self.where, self.fix = what, where, fix


class SamplesError(AlignError):
    """Data from which something is to be learned are too few, unequal in number, or no numbers."""


class SettingError(AlignError):
    """A setting is out of range."""


class MapError(AlignError):
    """A map between two bodies cannot be learned, read, inverted or composed."""
