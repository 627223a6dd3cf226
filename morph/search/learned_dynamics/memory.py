"""Checkpoint of a search from trials: its data, its plans and its initial settings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.errors import StateError
from morph.model.jointed.transition import JointTransitions, transitions
from morph.search.learned_dynamics.plan_choice import Plans, joined
from morph.search.search import State, Trial
from morph.search.target import Experience

FARTHEST = 1.2
"""Angle by which a joint may turn in a control period that is learned from, rad: in more, a
command meets too many postures for one acceleration to say what it did."""

SEEN = ("position", "velocity", "command")
"""What is kept of each trial, beside its period, loss and success."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SearchCheckpoint:
    """All that a search needs to go on after a kill."""

    experience: tuple[Experience, ...] = ()
    """Every trial, those with random commands first."""
    tried: Plans | None = None
    """What was tried in each but the random ones."""
    lines: tuple[Trial, ...] = ()
    """The learning record."""
    logs: Array | None = None
    """Logarithms of the settings of the last model."""

    @property
    def seconds(self) -> float:
        """Wall time until the last trial, s."""
        return self.lines[-1].seconds if self.lines else 0.0

    @property
    def begun(self) -> int:
        """How many trials had random commands."""
        return len(self.experience) - (0 if self.tried is None else len(self.tried.command))

    def periods(
        self, turning: tuple[int, ...], period: float, names: tuple[str, ...] = ()
    ) -> JointTransitions:
        """Return what all trials showed, but for periods in which a joint turned too far."""
        runs = [(each.position, each.velocity, each.command) for each in self.experience]
        return transitions(runs, period).slower(turning, FARTHEST, names)

    def after(
        self, shown: Experience, plan: Plans | None, seconds: float, note: str
    ) -> SearchCheckpoint:
        """Return it with one more trial."""
        line = Trial(
            number=0 if plan is None else len(self.experience) - self.begun + 1,
            loss=shown.loss,
            success=float(shown.success),
            seconds=seconds,
            experience=sum(each.seconds for each in (*self.experience, shown)),
            note=note,
        )
        tried = [each for each in (self.tried, plan) if each is not None]
        return replace(
            self,
            experience=(*self.experience, shown),
            tried=joined(tried) if tried else None,
            lines=(*self.lines, line),
        )

    def state(self) -> State:
        """Return it as arrays by name."""
        state: dict[str, Array] = {
            "seen.period": np.array([each.period for each in self.experience]),
            "seen.loss": np.array([each.loss for each in self.experience]),
            "seen.success": np.array([float(each.success) for each in self.experience]),
            "seconds": np.array([each.seconds for each in self.lines]),
            "begun": np.array([float(self.begun)]),
        }
        for name in SEEN:
            state[f"seen.{name}"] = np.stack([getattr(each, name) for each in self.experience])
        if self.tried is not None:
            state |= {f"tried.{name}": value for name, value in vars(self.tried).items()}
        if self.logs is not None:
            state["logs"] = self.logs
        return state


def recalled(state: State) -> SearchCheckpoint:
    """Return what `SearchCheckpoint.state` kept; the notes of the record are lost.

    Raises:
        StateError: An array is missing.
    """
    try:
        parts = zip(
            *(state[f"seen.{name}"] for name in (*SEEN, "period", "loss", "success")),
            state["seconds"],
            strict=True,
        )
        memory, begun = SearchCheckpoint(), int(state["begun"][0])
        for at, (position, velocity, command, period, loss, success, seconds) in enumerate(parts):
            plan = None
            if at >= begun:
                kept = {name: state[f"tried.{name}"] for name in ("state", "command", "gain")}
                plan = Plans(**kept).rows(slice(at - begun, at - begun + 1))
            shown = Experience(
                position=position,
                velocity=velocity,
                command=command,
                period=float(period),
                loss=float(loss),
                success=bool(success),
            )
            memory = memory.after(shown, plan, float(seconds), "")
    except (KeyError, ValueError) as error:
        raise StateError(
            f"its state cannot be read: {error}",
            where="a search to be resumed",
            fix="begin anew, or give the state as this search kept it",
        ) from error
    return replace(memory, logs=state.get("logs"))
