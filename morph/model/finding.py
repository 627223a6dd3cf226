"""What a diagnosis found: estimates, findings, changes of a robot."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from morph.arrays import JSON
from morph.physics.effect import Effect

IDLE = 0.01
"""Share of its strength after a change below which a law is said not to have acted before."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """One parameter with its 90 % interval."""

    value: float
    """The best value."""
    low90: float
    """Lower end."""
    high90: float
    """Upper end."""
    unit: str
    """Its unit."""
    bounded: bool = False
    """Whether the best value is at a bound, so that it may lie beyond."""
    prior_only: bool = False
    """Whether the runs say nothing about it that was not assumed before."""

    def as_json(self) -> JSON:
        """Return it with the flags that hold."""
        flags = {"bounded": self.bounded, "prior_only": self.prior_only}
        ends = {"low90": self.low90, "high90": self.high90}
        given = {name: True for name, holds in flags.items() if holds}
        return {"value": self.value, **ends, "unit": self.unit, **given}


@dataclass(frozen=True, kw_only=True)
class Rival:
    """Another effect that could pass for a finding."""

    effect: str
    """Its name."""
    kind: str
    """The kind of part."""
    where: str
    """The part."""
    probability: float
    """Posterior probability that it is there in the finding's place."""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One piece of physics that was left out."""

    effect: Effect
    """The effect as fitted."""
    probability: float
    """Posterior probability, tempered and at most .75; see docs/diagnosis.md."""
    episodes: tuple[str, ...]
    """Training episodes that it explains better."""
    parameters: Mapping[str, Estimate]
    """Its parameters."""
    rivals: tuple[Rival, ...]
    """What could be mistaken for it, likeliest first."""
    separate_by: str
    """The experiment that would tell it from its likeliest rival."""
    gain: float
    """By how much the geometric mean over channels of 1 + MSE / variance falls in rollouts."""
    slide: bool = False
    """Whether its joint is a slide, so that forces are in N and lengths in m."""
    onset: float | None = None
    """When it began in the first of its episodes, s; None where it acts in all that was fitted."""

    @property
    def statement(self) -> str:
        """The finding in one plain sentence, and which parameters it does not determine."""
        free = [name for name, each in self.parameters.items() if each.prior_only]
        rest = f" These runs do not determine {', '.join(free)}." if free else ""
        return self.effect.statement(slide=self.slide) + rest

    @property
    def said(self) -> str:
        """The same, below a probability of one half with that."""
        doubt = f"Perhaps (probability {self.probability:.2g}): " if self.probability < 0.5 else ""
        return f"{doubt}{self.statement}"

    def as_json(self) -> JSON:
        """Return what `diagnosis.json` holds of it."""
        effect = self.effect
        lasts = (
            [self.parameters[name].value for name in ("start", "end")] if effect.passing else None
        )
        return {
            "effect": effect.name,
            "where": {"kind": effect.kind, "name": effect.where},
            "probability": self.probability,
            "onset_s": lasts[0] if lasts else self.onset,
            "interval_s": lasts,
            "episodes": list(self.episodes),
            "parameters": {name: each.as_json() for name, each in self.parameters.items()},
            "rivals": [
                {
                    "effect": rival.effect,
                    "where": {"kind": rival.kind, "name": rival.where},
                    "probability": rival.probability,
                }
                for rival in self.rivals
            ],
            "separate_by": self.separate_by,
            "statement": self.statement,
        }


@dataclass(frozen=True, kw_only=True)
class Change:
    """A law that acts otherwise from one time on, in all later episodes too."""

    before: Effect
    """The law before; without strength where it did not act."""
    after: Effect
    """The law from then on."""
    episode: str
    """The episode in which it changes."""
    time: float
    """When, s from the start of that episode; 0 where it changed before that."""
    gain: float
    """Log evidence for the change, less its price, nats."""
    since: bool
    """Whether what else is said is of the runs since then; otherwise of those until then."""
    slide: bool = False
    """Whether its joint is a slide, so that forces are in N and lengths in m."""

    @property
    def statement(self) -> str:
        """What changed and when, in one plain sentence or two."""
        when = f"{self.time:.1f} s of {self.episode}" if self.time > 0.0 else self.episode
        before, after = (e.statement(slide=self.slide) for e in (self.before, self.after))
        if self.ceases:
            return f"Until {when}, and not since: {before}"
        if self.begins:
            return f"From {when} on, and not before: {after}"
        return f"From {when} on: {after} Before: {before}"

    @property
    def begins(self) -> bool:
        """Whether the law did not act before, beside what it does since."""
        return _idle(self.before, self.after)

    @property
    def ceases(self) -> bool:
        """Whether the law does not act any more, beside what it did."""
        return _idle(self.after, self.before)

    @property
    def alters(self) -> bool:
        """Whether the law acts before and after, with other parameters."""
        return not (self.begins or self.ceases)

    @property
    def stays(self) -> bool:
        """Whether the law acts in the runs of which all else is said."""
        return not (self.ceases if self.since else self.begins)

    def said(self, results: Collection[str]) -> tuple[str, str]:
        """Return the change in words, and of which runs all else is said.

        Args:
            results: Labels of the laws that were found in these runs.
        """
        runs = "since" if self.since else "until"
        rest = f"The robot changed then: what follows is of the runs {runs} then."
        if self.since and not self.ceases and self.after.label not in results:
            rest += " A twin stands for this law in what follows."
        return self.statement, rest

    def as_json(self) -> JSON:
        """Return what `diagnosis.json` holds of it."""
        sides = {
            name: {each.name: getattr(effect, each.name) for each in effect.free()}
            for name, effect in (("before", self.before), ("after", self.after))
        }
        return {
            "effect": self.after.name,
            "where": {"kind": self.after.kind, "name": self.after.where},
            "episode": self.episode,
            "time_s": self.time,
            **sides,
            "gain_nats": self.gain,
            "since": self.since,
            "statement": self.statement,
        }


def _idle(effect: Effect, other: Effect) -> bool:
    """Return whether an effect does nothing, or a hundredth of what another does."""
    small = np.abs(effect.coefficients) <= IDLE * np.abs(other.coefficients)
    return effect == effect.neutral() or bool(small.all())
