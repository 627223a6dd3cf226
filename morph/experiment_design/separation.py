"""Runs to record, and how surely they tell laws apart."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

from scipy.stats import norm

from morph.arrays import JSON
from morph.body.robot import Robot
from morph.experiment_design.excitation import Excitation
from morph.record.recording import Channel, Recording

SCHEMA = "morph.experiment/1"
DECIDED = 10.0
"""Nats by which the true law is to be likelier than its rival; a diagnosis takes the likelier of
two twins from 3 on."""
POWER = 0.9
"""Probability of that from which an experiment is taken to be enough."""


def power(nats: float) -> float:
    """Return the probability that a difference of log likelihoods of mean `nats` decides."""
    if nats <= 0.0:
        return 0.0
    return float(norm.cdf((nats - DECIDED) / math.sqrt(2.0 * nats)))


@dataclass(frozen=True, kw_only=True)
class Separation:
    """How surely one law is told from another by the planned runs."""

    law: str
    """The label of the law that acts."""
    rival: str
    """The label of the other, or `none`: masses, gains and the like alone."""
    size: Mapping[str, float]
    """The parameters of the law that acts."""
    nats: float
    """Expected log likelihood of the readings under the law less that under the rival, each with
    all its parameters and the description's own parameters refitted."""

    @property
    def power(self) -> float:
        """The probability that the law is `DECIDED` nats likelier than its rival.

        For linear models with known noise that difference is normal, of mean d and variance 2 d.
        """
        return power(self.nats)

    @property
    def enough(self) -> bool:
        """Whether that is at least `POWER`."""
        return self.power >= POWER


@dataclass(frozen=True, kw_only=True, eq=False)
class PlannedRun:
    """One run to record."""

    excitation: Excitation
    """What is told."""
    seconds: float
    """How long it lasts."""

    @property
    def inputs(self) -> Recording:
        """The commands alone, to its end, and the positions that are to be followed."""
        channels = self.excitation.recording.channels.items()
        commands = {name: each for name, each in channels if name.endswith(".command")}
        given = {**commands, **self.excitation.references}
        kept = {name: _until(each, self.seconds) for name, each in given.items()}
        return replace(self.excitation.recording, channels=kept)


@dataclass(frozen=True, kw_only=True, eq=False)
class ExperimentPlan:
    """Runs to record, and what they are expected to tell apart."""

    robot: Robot
    """The description."""
    runs: tuple[PlannedRun, ...]
    """In the order in which they are worth recording."""
    separations: tuple[Separation, ...]
    """By all runs together, the least sure first."""
    noise: float
    """Standard deviation of readings that is reckoned with, rad or m."""
    unmodelled: float
    """Missing force over the inertial force that is reckoned with, even under the right law."""
    tried: int
    """How many motions were compared."""

    def as_json(self, files: Sequence[str]) -> JSON:
        """Return it by the schema morph.experiment/1, the commands in files of these names."""
        runs = [
            {
                "file": file,
                "kind": run.excitation.kind,
                "amplitude": run.excitation.amplitude,
                "seconds": run.seconds,
            }
            for run, file in zip(self.runs, files, strict=True)
        ]
        separations = [{**asdict(each), "power": each.power} for each in self.separations]
        return {
            "schema": SCHEMA,
            "robot": self.robot.name,
            "sha256": self.robot.sha256,
            "noise": self.noise,
            "unmodelled": self.unmodelled,
            "tried": self.tried,
            "runs": runs,
            "separations": separations,
        }


def _until(channel: Channel, end: float) -> Channel:
    kept = channel.time < end
    return replace(channel, time=channel.time[kept], value=channel.value[kept])
