"""The family of ways to match a policy to a printed body."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from morph.fabrication.match.case import Case
from morph.policy.policy import Policy


@dataclass(frozen=True, kw_only=True)
class Matcher(ABC):
    """One way; its fields are its settings. All of them stand in `matchers.py`."""

    name: ClassVar[str]
    """What a report calls it."""
    dear: ClassVar[bool] = False
    """Whether it takes all the time that it is given: only a policy that is lost is worth that."""

    @abstractmethod
    def suits(self, case: Case) -> bool:
        """Return whether it may have something to propose."""

    @abstractmethod
    def proposals(self, case: Case) -> Iterator[Policy]:
        """Yield policies for the printed body, ever better as it is thought.

        It looks at `case.left` before each, and begins nothing that takes longer. Whoever asks
        stops asking once a policy does.

        Raises:
            MorphError: There is no such policy for this body.
        """
