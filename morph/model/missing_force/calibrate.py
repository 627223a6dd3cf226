"""Whether a forecast's spread is right, and what it must be multiplied by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.gaussian.information import Information
from morph.model.latent.run import Run
from morph.model.missing_force.corrected import Corrected, within
from morph.model.missing_force.periods import Periods
from morph.model.missing_force.problem import ForceProblem, Iterate

BLOCK = 20
"""Periods of a block that is left out."""

SCALES = np.geomspace(1.0, 12.0, 60)
"""Multiples of the standard deviation that are tried: a few blocks are no reason to be surer."""

USUAL = 1.4
"""That multiple where blocks say nothing: the posterior takes the settings that the evidence chose
for certain, and where force and figures are bent it is linear. Measured on cart-poles."""

TRUST = 0.3
"""Standard deviation of its logarithm before any data."""

WORTH = 3.0
"""Independent errors that each number of a block is worth; its errors go together."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """How often what was observed lay below each quantile that was foreseen."""

    level: Array
    """Probabilities, shape (levels,)."""
    seen: Array
    """Share of the observations below the quantile of each, shape (levels,)."""
    inside: Array
    """Share within the central interval of each, shape (levels,)."""

    @property
    def error(self) -> float:
        """Root of the mean square of what was seen less what was promised.

        Source: Kuleshov, Fenner and Ermon 2018, ICML, eq. 9, here its root with equal weights.
        """
        return float(np.sqrt(((self.seen - self.level) ** 2).mean()))

    def covered(self, level: float) -> float:
        """Return the share of observations within the central interval of a probability."""
        return float(np.interp(level, self.level, self.inside))


def ranks(draws: Array, observed: Array) -> Array:
    """Return how likely less than each observation was, by draws; shape of `observed`.

    Half of the draws that equal it count. A forecast that is right has ranks spread evenly
    between 0 and 1.

    Args:
        draws: Possible observations, shape (draws, ...).
        observed: What was seen, shape (...,).
    """
    with np.errstate(invalid="ignore"):
        below = (draws < observed).sum(axis=0) + 0.5 * (draws == observed).sum(axis=0)
    alive = np.isfinite(draws).sum(axis=0)
    # Between draws nothing is known: a rank of none is half a draw.
    return np.asarray((below + 0.5) / (alive + 1.0))


def calibration(rank: Array, levels: int = 49) -> Calibration:
    """Return how often observations lay where they were promised, from their ranks."""
    level = np.arange(1, levels + 1) / (levels + 1.0)
    flat = rank.ravel()
    return Calibration(
        level=level,
        seen=(flat[:, None] <= level).mean(axis=0),
        inside=(np.abs(2.0 * flat[:, None] - 1.0) <= level).mean(axis=0),
    )


def calibrated(
    corrected: Corrected, runs: Sequence[Run], rng: np.random.Generator, *, draws: int = 48
) -> Corrected:
    """Return it with standard deviations that blocks of its own runs, left out, have shown right.

    Runs are cut into blocks. Each is foreseen from its first observation by the posterior of all
    others, and one factor on the standard deviation of all that is uncertain but the observations
    makes these forecasts likeliest, under a prior about what it usually is.

    Args:
        corrected: What was fitted.
        runs: The runs that it was fitted to.
        rng: Chance.
        draws: Possible runs by which a block is foreseen.

    Raises:
        DiagnosisError: There are fewer than two blocks.
    """
    blocks = [(r, at) for r, run in enumerate(runs) for at in _cuts(len(run.command))]
    if len(blocks) < 2:
        raise DiagnosisError(
            f"{len(runs)} run of {len(runs[0].command)} periods makes one block",
            where="the calibration of a corrected simulator",
            fix=f"give {2 * BLOCK + 1} periods or more",
        )
    pieces = tuple(_cut(runs[r], at) for r, at in blocks)
    believed = tuple(corrected.states[r][at : at + BLOCK + 1] for r, at in blocks)
    given, start, variance = _information(corrected, pieces, believed)
    error, spread, still = [], [], []
    for out, piece in enumerate(pieces):
        first, *rest = (each for at, each in enumerate(given) if at != out)
        left = _with(corrected, sum(rest, first).with_prior(start, variance))
        begin, command = piece.state[:1], piece.command[None]
        seen = left.foresee(begin, command, rng, draws=draws)
        sure = left.scaled(1e-3).foresee(begin, command, rng, draws=draws)
        error.append((piece.state - seen.mean[0])[1:])
        still.append(sure.variance[0, 1:] + corrected.noise**2)
        spread.append(np.maximum(seen.variance - sure.variance, 0.0)[0, 1:])
    return corrected.scaled(_likeliest(np.array(error), np.array(spread), np.array(still)))


def _likeliest(error: Array, spread: Array, still: Array) -> float:
    """Return the factor on standard deviations under which errors are likeliest."""
    share = WORTH / error.shape[1]
    score = []
    for scale in SCALES:
        variance = still + scale**2 * spread
        fits = -0.5 * (error**2 / variance + np.log(variance)).sum()
        score.append(share * fits - 0.5 * (np.log(scale / USUAL) / TRUST) ** 2)
    return float(SCALES[int(np.nanargmax(score))])


def _cuts(periods: int) -> range:
    # The observation after a block is where no other begins: none speaks in two blocks.
    return range(0, periods - BLOCK + 1, BLOCK + 1)


def _cut(run: Run, at: int) -> Run:
    return Run(
        position=run.position[at : at + BLOCK + 1],
        velocity=run.velocity[at : at + BLOCK + 1],
        command=run.command[at : at + BLOCK],
        period=run.period,
    )


def _information(
    corrected: Corrected, pieces: tuple[Run, ...], believed: tuple[Array, ...]
) -> tuple[list[Information], Array, Array]:
    """Return what each block says of point and weights, and their prior."""
    problem = ForceProblem(
        periods=Periods(corrected.hypothesis, corrected.period, corrected.integrator),
        runs=pieces,
        noise=corrected.noise,
        waves=corrected.waves,
        unit=corrected.unit,
    )
    belief = Iterate(point=corrected.point, weight=corrected.weight, states=believed)
    slopes = problem.slopes(belief, corrected.settings)
    parts = problem.reduced(slopes, corrected.settings)
    given = problem.told(slopes, parts, corrected.settings)
    return given, *problem.prior(corrected.settings)


def _with(corrected: Corrected, result: Information) -> Corrected:
    """Return the same with another posterior."""
    size, weight = len(corrected.point), corrected.weight
    if corrected.unit is not None:
        weight = result.mean[size:].reshape(weight.shape)
    point = within(corrected.hypothesis, result.mean[:size])
    return replace(corrected, posterior=result, point=point, weight=weight)
