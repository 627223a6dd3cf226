"""What a diagnosis found: frozen data that reports draw and programs read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from morph.arrays import JSON, Array
from morph.model.finding import Change, Estimate, Finding
from morph.physics.effect import Effect
from morph.tabular import Tabular

SCHEMA = "morph.diagnosis/1"
"""Name and version of the JSON."""


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A stretch of a held-out episode and its share of the error."""

    episode: str
    """Name of the episode: of the recording, and when it begins there if it is a part of one."""
    recording: str
    """Name of the recording."""
    begin: float = 0.0
    """Seconds from the recording's first reading to the episode's start."""
    start: float
    """From, s from the episode's start."""
    end: float
    """To, s from there."""
    share: float
    """Share of the held-out squared error, each channel in units of its noise."""


@dataclass(frozen=True, kw_only=True)
class Located:
    """Where, when and in which states the description and the recordings part."""

    channels: Mapping[str, float]
    """Share of the refitted description's squared error by channel, largest first."""
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
    """The same by each channel of a position that was read."""
    in_noise: float = 1.0
    """Error of the rollouts of a typical segment: geometric mean over channels of 1 + MSE over the
    noise's variance, less 1."""
    contact: bool = False
    """Whether the robot touches a floor or stops, of whose forces rollouts alone tell."""


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
REJECTED = "The corrected model predicts held-out runs worse than the description: it is rejected."
OUT_OF_TIME = "The budget ended before anything could be said surely."
UNNAMED = (
    "The simulation does not explain these recordings, and no effect that was tried does so "
    "surely: a known law may have been missed, or what is missing has no name."
)


@dataclass(frozen=True, kw_only=True, repr=False)
class Diagnosis(Tabular):
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
    changes: tuple[Change, ...] = ()
    """When the robot changed; all else is of the runs since the last change, or until it."""
    horizon: float | None
    """Seconds of the rollouts that are scored; None for whole episodes."""
    train: tuple[str, ...]
    """Episodes that were fitted."""
    held_out: tuple[str, ...]
    """Episodes kept for testing, scored once after the model was chosen."""
    split: str
    """How they were set apart: by session, by episode, by time, or as named."""
    held_out_rmse: Mapping[str, Mapping[str, float]]
    """Error by model and channel. For one that is `rejected` the description stands."""
    improvement_low90: float
    """Share of the nominal squared error taken away, lower end of a 90 % interval."""
    refit: Mapping[str, Estimate]
    """Factors on the description's own parameters in the corrected model."""
    traces: tuple[Trace, ...]
    """Held-out rollouts, for plots."""
    data: JSON
    """Samples, dropped, repaired, duplicates."""
    overstated: tuple[str, ...] = ()
    """Damping, armature, friction or stiffness that the description states far too high."""
    notes: tuple[str, ...]
    """What was dropped, repaired or looks odd, in words."""
    provenance: JSON
    """Versions and hashes."""
    seconds: float
    """How long it took."""
    seed: int
    """Random seed."""
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

    def __repr__(self) -> str:
        named = [f"{each.effect.label} {each.probability:.2f}" for each in self.findings]
        short = ["stopped short"] if self.stopped_short else []
        return f"Diagnosis({', '.join([f'{self.robot}: {self.verdict}', *named, *short])})"

    def rows(self) -> list[JSON]:
        """Return one row for each parameter of each finding, with its 90 % interval."""
        return [
            {
                "effect": finding.effect.name,
                "where": finding.effect.where,
                "probability": finding.probability,
                "parameter": name,
                "value": each.value,
                "low90": each.low90,
                "high90": each.high90,
                "unit": each.unit,
            }
            for finding in self.findings
            for name, each in finding.parameters.items()
        ]

    def plotted(self) -> list[JSON]:
        """Return held-out errors, one row a channel and one column a model."""
        channels = dict.fromkeys(name for errors in self.held_out_rmse.values() for name in errors)
        return [
            {"channel": name}
            | {model: float(errors[name]) for model, errors in self.held_out_rmse.items()}
            for name in channels
        ]

    def save(self, folder: str | Path) -> None:
        """Write the report, the corrected model and diagnosis.json, as `morph diagnose` does.

        Raises:
            OutputError: The folder cannot be written, or holds something else.
        """
        # The report belongs to the layer of what users meet, above this one.
        import_module("morph.app.report.files").write_diagnosis(self, Path(folder))

    def summary(self) -> tuple[str, ...]:
        """Return the answer in words, a sentence each."""
        labels = {finding.effect.label for finding in self.findings}
        changed = tuple(text for change in self.changes for text in change.said(labels))
        if self.verdict == "consistent":
            return (*changed, EXPLAINED, *self.overstated)
        lines = [finding.said for finding in self.findings]
        if not lines:
            lines = [OUT_OF_TIME if self.stopped_short else UNNAMED]
            lines += (f"Perhaps {x.replace('@', ' at ')}." for x in self.probabilities if "@" in x)
        elif self.unexplained.probability > 0.5:
            shares = self.unexplained.channels
            worst = max(shares, key=shares.__getitem__, default="a joint")
            lines.append(
                f"At {worst.removesuffix('.position')} a force of "
                f"{round(100.0 * self.unexplained.share, 1):g} % of the inertial one is missing "
                "still, and no law that was tried explains it."
            )
        if "rejected" in self.held_out_rmse:
            lines.append(REJECTED)
        return (*changed, *lines, *self.overstated)

    def as_json(self) -> JSON:
        """Return the content of `diagnosis.json`."""
        times = [
            {
                "episode": each.episode,
                "recording": each.recording,
                "begin_s": each.begin,
                "start_s": each.start,
                "end_s": each.end,
                "share": each.share,
            }
            for each in self.located.times
        ]
        content = {
            "schema": SCHEMA,
            "robot": self.robot,
            "verdict": self.verdict,
            "summary": list(self.summary()),
            "findings": [each.as_json() for each in self.findings],
            "located": {
                "channels": [{"channel": c, "share": s} for c, s in self.located.channels.items()],
                "times": times,
                "states": self.located.states,
            },
            "probabilities": dict(self.probabilities),
            "unexplained": asdict(self.unexplained),
            "changes": [each.as_json() for each in self.changes],
            "fit": {
                "horizon_s": self.horizon if self.horizon is not None else "full",
                "train": list(self.train),
                "held_out": list(self.held_out),
                "split": self.split,
                "held_out_rmse": {model: dict(by) for model, by in self.held_out_rmse.items()},
                "improvement_low90": self.improvement_low90,
                "refit": {name: each.as_json() for name, each in self.refit.items()},
            },
            "provenance": self.provenance,
            "data": self.data,
            "notes": list(self.notes),
            "seconds": round(self.seconds, 1),
            "seed": self.seed,
            "candidates_tried": self.candidates_tried,
            "stopped_short": self.stopped_short,
        }
        return dict(_rounded(content))


def _rounded(value: Any) -> Any:
    """Return JSON with six figures: what follows differs from machine to machine."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, Mapping):
        return {name: _rounded(each) for name, each in value.items()}
    return [_rounded(each) for each in value] if isinstance(value, list) else value
