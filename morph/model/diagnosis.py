"""What a diagnosis found: frozen data that reports draw and programs read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from morph.arrays import JSON, Array
from morph.physics.effect import Effect

SCHEMA = "morph.diagnosis/1"
"""Name and version of the JSON."""


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
    """Posterior probability."""
    episodes: tuple[str, ...]
    """Training episodes that it explains better."""
    parameters: Mapping[str, Estimate]
    """Its parameters."""
    rivals: tuple[Rival, ...]
    """What could be mistaken for it, likeliest first."""
    separate_by: str
    """The experiment that would tell it from its likeliest rival."""
    gain: float
    """Share of the training loss that it takes away."""
    slide: bool = False
    """Whether its joint is a slide, so that forces are in N and lengths in m."""

    @property
    def statement(self) -> str:
        """The finding in one plain sentence."""
        return self.effect.statement(slide=self.slide)


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A stretch of a held-out episode and its share of the error."""

    episode: str
    """Its name."""
    start: float
    """From, s."""
    end: float
    """To, s."""
    share: float
    """Share of the held-out squared error, each channel in units of its noise."""


@dataclass(frozen=True, kw_only=True)
class Located:
    """Where, when and in which states the description and the recordings part."""

    channels: Mapping[str, float]
    """Share of the squared error by channel, largest first."""
    times: tuple[Stretch, ...]
    """The worst stretches, worst first."""
    states: str
    """The states in which the missing force is largest, in words."""


@dataclass(frozen=True, kw_only=True)
class Unexplained:
    """What the corrected model leaves of the training runs."""

    probability: float = 0.0
    """That physics is left which has no name here."""
    share: float = 0.0
    """Missing force over the inertial force of the motion, RMS, of the worst joint."""
    channels: Mapping[str, float] = field(default_factory=dict)
    """The same by each joint's position channel."""
    in_noise: float = 1.0
    """Mean squared error of the rollouts of a typical stretch over the noise's variance."""


@dataclass(frozen=True, kw_only=True)
class Trace:
    """One channel of one held-out rollout, for plots."""

    episode: str
    """The episode."""
    channel: str
    """The channel."""
    unit: str
    """Its unit."""
    time: Array
    """Within the episode, s, shape (readings,); NaN separates rollouts."""
    measured: Array
    """Readings; same shape."""
    models: Mapping[str, Array]
    """Predictions by model: nominal, refitted, corrected; same shape each."""


EXPLAINED = "The simulation explains these recordings: nothing was left out that shows."
OUT_OF_TIME = "The budget ended before anything could be said surely."
UNNAMED = (
    "The simulation does not explain these recordings, and no effect that was tried does so "
    "surely: a known law may have been missed, or what is missing has no name."
)


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """The answer to: where do simulation and recordings part, and what was left out?"""

    robot: str
    """The description's name."""
    verdict: str
    """consistent, mismatch or unknown."""
    findings: tuple[Finding, ...]
    """What was left out, in the order of what each explains."""
    located: Located
    """Where the two part."""
    probabilities: Mapping[str, float]
    """Of none, unknown, each finding and its rivals; of likeliest effects where none is found."""
    unexplained: Unexplained = field(default_factory=Unexplained)
    """What the corrected model leaves."""
    horizon: float | None
    """Seconds of the rollouts that are scored; None for whole episodes."""
    train: tuple[str, ...]
    """Episodes that were fitted."""
    held_out: tuple[str, ...]
    """Episodes that were opened once, after the choice."""
    split: str
    """How they were set apart: by session, by episode, by time, or as named."""
    held_out_rmse: Mapping[str, Mapping[str, float]]
    """Error by model and channel."""
    improvement_low90: float
    """Share of the nominal squared error taken away, lower end of a 90 % interval."""
    refit: Mapping[str, Estimate]
    """Factors on the description's own figures in the corrected model."""
    traces: tuple[Trace, ...]
    """Held-out rollouts, for plots."""
    data: JSON
    """Samples, dropped, repaired, duplicates."""
    overstated: tuple[str, ...] = ()
    """Figures of joints that are less than `--vary` lets them be, in words."""
    notes: tuple[str, ...]
    """What was dropped, repaired or looks odd, in words."""
    provenance: JSON
    """Versions and hashes."""
    seconds: float
    """How long it took."""
    seed: int
    """Of every draw."""
    candidates_tried: int
    """Effects at places that were looked at, over all rounds."""
    stopped_short: bool = False
    """Whether the budget ended before the search did."""
    corrected: str = ""
    """The corrected description as MJCF."""
    corrected_effects: tuple[Effect, ...] = ()
    """Effects that MuJoCo cannot hold, to be simulated by morph beside it."""
    residual: Mapping[str, Any] = field(default_factory=dict)
    """Arrays of the learned residual that training runs speak for; empty for none."""

    def summary(self) -> tuple[str, ...]:
        """Return the answer in words, a sentence each."""
        if self.verdict == "consistent":
            return (EXPLAINED, *self.overstated)
        said = [finding.statement for finding in self.findings]
        if not said:
            said = [OUT_OF_TIME if self.stopped_short else UNNAMED]
            said += (f"Perhaps {x.replace('@', ' at ')}." for x in self.probabilities if "@" in x)
        elif self.unexplained.probability > 0.5:
            said.append(
                f"A force of {round(100.0 * self.unexplained.share, 1):g} % of the inertial force "
                "remains, and no effect that was tried explains it: something else is missing."
            )
        elif self.verdict == "unknown":
            said.append("The corrected model is no better on held-out runs: nothing was changed.")
        return (*said, *self.overstated)

    def as_json(self) -> JSON:
        """Return the content of `diagnosis.json`."""
        return {
            "schema": SCHEMA,
            "robot": self.robot,
            "verdict": self.verdict,
            "summary": list(self.summary()),
            "findings": [_finding(f) for f in self.findings],
            "located": {
                "channels": [
                    {"channel": c, "share": _round(s)} for c, s in self.located.channels.items()
                ],
                "times": [
                    {
                        "episode": s.episode,
                        "start_s": _round(s.start),
                        "end_s": _round(s.end),
                        "share": _round(s.share),
                    }
                    for s in self.located.times
                ],
                "states": self.located.states,
            },
            "probabilities": {k: _round(v) for k, v in self.probabilities.items()},
            "unexplained": {
                "probability": _round(self.unexplained.probability),
                "share": _round(self.unexplained.share),
                "channels": {k: _round(v) for k, v in self.unexplained.channels.items()},
                "in_noise": _round(self.unexplained.in_noise),
            },
            "fit": {
                "horizon_s": self.horizon if self.horizon is not None else "full",
                "train": list(self.train),
                "held_out": list(self.held_out),
                "split": self.split,
                "held_out_rmse": {
                    model: {c: _round(v) for c, v in by.items()}
                    for model, by in self.held_out_rmse.items()
                },
                "improvement_low90": _round(self.improvement_low90),
                "refit": {name: _estimate(e) for name, e in self.refit.items()},
            },
            "provenance": self.provenance,
            "data": self.data,
            "notes": list(self.notes),
            "seconds": round(self.seconds, 1),
            "seed": self.seed,
            "candidates_tried": self.candidates_tried,
            "stopped_short": self.stopped_short,
        }


def _finding(finding: Finding) -> JSON:
    return {
        "effect": finding.effect.name,
        "where": {"kind": finding.effect.kind, "name": finding.effect.where},
        "probability": _round(finding.probability),
        "onset_s": None,
        "interval_s": None,
        "episodes": list(finding.episodes),
        "parameters": {name: _estimate(e) for name, e in finding.parameters.items()},
        "rivals": [
            {
                "effect": rival.effect,
                "where": {"kind": rival.kind, "name": rival.where},
                "probability": _round(rival.probability),
            }
            for rival in finding.rivals
        ],
        "separate_by": finding.separate_by,
        "statement": finding.statement,
    }


def _estimate(estimate: Estimate) -> JSON:
    return {
        "value": _round(estimate.value),
        "low90": _round(estimate.low90),
        "high90": _round(estimate.high90),
        "unit": estimate.unit,
        **({"bounded": True} if estimate.bounded else {}),
        **({"prior_only": True} if estimate.prior_only else {}),
    }


def _round(value: float) -> float:
    """Return a value with six figures: what follows differs from machine to machine."""
    return float(f"{value:.6g}")
