"""A run as inference sees it: noisy states at the control times, and what was commanded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import DiagnosisError

FEWEST = 3
"""Control periods that a run must have."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """One run of a body of hinges and slides.

    Raises:
        DiagnosisError: Shapes do not agree, a number is not finite, or it is too short.
    """

    position: Array
    """Observed `qpos` at the control times, shape (periods + 1, nq)."""
    velocity: Array
    """Observed `qvel`, shape (periods + 1, nv)."""
    command: Array
    """What was commanded from each time on, shape (periods, nu)."""
    period: float
    """Time from one sample to the next, s."""

    def __post_init__(self) -> None:
        """Check shapes and numbers."""
        periods = len(self.command)
        if not (len(self.position) == len(self.velocity) == periods + 1 > FEWEST):
            raise DiagnosisError(
                f"it has {len(self.position)} positions, {len(self.velocity)} velocities and "
                f"{periods} commands",
                where="a run to infer from",
                fix=f"give {FEWEST} control periods or more, and one state more than commands",
            )
        if not all(np.isfinite(each).all() for each in (self.state, self.command)):
            raise DiagnosisError(
                "a state or a command is no finite number",
                where="a run to infer from",
                fix="leave out the run in which a sensor failed, or cut it there",
            )

    @property
    def state(self) -> Array:
        """Observed states, positions then velocities, shape (periods + 1, nq + nv)."""
        return np.concatenate([self.position, self.velocity], axis=1)

    @property
    def seconds(self) -> float:
        """How long it lasted, s."""
        return len(self.command) * self.period
