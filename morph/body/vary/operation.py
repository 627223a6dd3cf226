"""What every variation of a body is: data that names a part and says what becomes of it."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from morph.errors import RobotError

MOST = 1e6
"""Greatest factor: from a millimetre to a kilometre."""


@dataclass(frozen=True, kw_only=True)
class Operation(ABC):
    """A change of a body, as a card or a chain of bodies names it."""

    name: ClassVar[str]
    """What cards call it."""
    amount: ClassVar[str] = ""
    """The field that a card's parameter sets; empty if it has none."""

    @abstractmethod
    def apply(self, spec: Any) -> None:
        """Change a `mujoco.MjSpec` that `bare_spec` gave.

        Raises:
            RobotError: The spec has no such part, or the part cannot be changed so.
        """

    @property
    def target(self) -> str:
        """The link or joint that it changes: its first field."""
        return str(getattr(self, dataclasses.fields(self)[0].name))

    def __str__(self) -> str:
        settings = [self.target]
        for field in dataclasses.fields(self)[1:]:
            value = getattr(self, field.name)
            if value != field.default:
                key = "" if field.name == self.amount else f"{field.name}="
                settings.append(key + _written(value))
        return f"{self.name}({','.join(settings)})"

    def refuse(self, what: str, fix: str) -> RobotError:
        """Return an error that names this operation and its part."""
        return RobotError(what, where=f"{self.name} of {self.target!r}", fix=fix)

    def check_positive(self, field: str) -> None:
        """Raise RobotError unless a field is between one millionth and a million."""
        value = getattr(self, field)
        if not 1 / MOST <= value <= MOST:
            raise self.refuse(
                f"{field} is {value}, not between {1 / MOST:g} and {MOST:g}",
                f"give a {field} above 0 that a body could have",
            )

    def check_finite(self, *fields: str) -> None:
        """Raise RobotError unless fields that hold numbers are finite."""
        for field in fields:
            value = getattr(self, field)
            numbers = value if isinstance(value, tuple) else (value,)
            if not all(math.isfinite(number) for number in numbers):
                raise self.refuse(f"{field} is {value}, not finite", f"give {field} in numbers")

    def check_length(self, field: str, *lengths: int) -> None:
        """Raise RobotError unless a tuple has one of the lengths given."""
        value = getattr(self, field)
        if len(value) not in lengths:
            wanted = " or ".join(str(length) for length in lengths)
            raise self.refuse(
                f"{field} has {len(value)} numbers, not {wanted}", f"give {field} {wanted} numbers"
            )


def _written(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(_written(item) for item in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
