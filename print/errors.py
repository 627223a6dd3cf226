"""The errors that print raises on purpose, each in three parts."""

from __future__ import annotations


class PrintError(Exception):
    """Base of every error that print raises on purpose.

    Args:
        what: What was found, with the value and the values allowed.
        where: The part, file, printer or setting concerned.
        fix: How to put it right.
    """

    def __init__(self, what: str, *, where: str, fix: str) -> None:
        super().__init__(f"{where}: {what}\n  fix: {fix}")
        self.what, self.where, self.fix = what, where, fix


class SolidError(PrintError):
    """A mesh encloses no solid that can be cut, joined or printed."""


class ProfileError(PrintError):
    """A printer, a material or a setting is unknown or out of range."""


class SeatError(PrintError):
    """A servo, a bearing or a screw is unknown, or does not fit where it is to sit."""


class SplitError(PrintError):
    """A part cannot be cut so that its pieces fit the bed and go together."""


class SlicerError(PrintError):
    """The slicer is missing, hung, died, or wrote what cannot be used."""


class PlateError(PrintError):
    """Parts cannot be laid on plates, or a plate cannot be written."""
