"""What one person chose to see of a case."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass

from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.window import DESCRIBED, Ask
from morph.app.viewer.mismatch.window_content import BY_ERROR, COLOURINGS
from morph.arrays import JSON
from morph.errors import ViewError

BOTH = "both"
"""Models, when all are shown."""


@dataclass(frozen=True, kw_only=True)
class MismatchChoices:
    """What one person chose."""

    ask: Ask
    """Recording, window, and how it is simulated."""
    models: str = BOTH
    """Name of the model that is shown, or `both`."""
    colouring: str = BY_ERROR
    """What links are coloured by."""

    @classmethod
    def of(cls, case: MismatchCase) -> MismatchChoices:
        """Return what is shown first: a recording that no model had seen, restarted."""
        unseen = (at for at in range(len(case.recordings)) if case.never_seen(at))
        models = BOTH if len(case.models) > 1 else DESCRIBED
        return cls(ask=Ask(episode=next(unseen, 0), horizon=case.horizon), models=models)

    @property
    def shown(self) -> tuple[str, ...]:
        """Names of the models that are shown."""
        return ("described", "corrected") if self.models == BOTH else (self.models,)

    def state(self, case: MismatchCase) -> JSON:
        """Return it as JSON, the recording by its name."""
        return {
            "recording": case.recordings[self.ask.episode].name,
            "window": self.ask.window,
            "horizon_s": self.ask.horizon,
            "models": self.models,
            "colouring": self.colouring,
        }

    @classmethod
    def restored(cls, case: MismatchCase, state: JSON) -> MismatchChoices:
        """Return what `state` said.

        Raises:
            ViewError: It names a recording, a window, a model or a way that is not here.
        """
        first = cls.of(case)
        merged = first.state(case) | dict(state)
        if len(merged) > len(first.state(case)):
            unknown = next(key for key in merged if key not in first.state(case))
            raise _bad("key", unknown, list(first.state(case)))
        names = [recording.name for recording in case.recordings]
        models = [model.name for model in case.models]
        episode = names.index(_one_of("recording", merged["recording"], names))
        windows = range(len(case.windows(episode)))
        horizon = merged["horizon_s"]
        if horizon is not None and (
            isinstance(horizon, bool) or not isinstance(horizon, int | float) or not horizon >= 0.1
        ):
            raise _bad("horizon_s", horizon, ["null", "0.1 or more"])
        if type(merged["window"]) is not int or merged["window"] not in windows:
            raise _bad("window", merged["window"], [str(each) for each in windows])
        both = [BOTH] if len(models) > 1 else []
        return cls(
            ask=Ask(
                episode=episode,
                window=merged["window"],
                horizon=None if horizon is None else float(horizon),
            ),
            models=_one_of("models", merged["models"], [*models, *both]),
            colouring=_one_of("colouring", merged["colouring"], COLOURINGS),
        )


def _one_of(key: str, value: object, known: Sequence[str]) -> str:
    if not isinstance(value, str) or value not in known:
        raise _bad(key, value, known)
    return value


def _bad(key: str, value: object, known: Sequence[str]) -> ViewError:
    near = difflib.get_close_matches(str(value)[:200], known, n=1)
    return ViewError(
        f"there is no {key} {str(value)[:200]!r}; there are {', '.join(known)}",
        where="the saved view of mismatch",
        fix=f"did you mean {near[0]!r}?" if near else "name one of these",
    )
