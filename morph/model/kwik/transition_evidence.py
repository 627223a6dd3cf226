"""Information of runs on the unknown parameters, and the model error of every transition."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.gaussian.information import Information
from morph.model.kwik.features import Unnamed, unnamed
from morph.model.kwik.innovations import Account, account
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit

ROUGH = 0.05
"""What a period's linearisation leaves out, in standard deviations of the observations."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Visit:
    """Runs as evidence, transition by transition."""

    account: Account
    """All transitions of all runs, in order; its unknowns are changes from where it was made."""
    about: Array
    """Where it was made, less the model as it stands, shape (unknowns,)."""
    error: Array
    """Slope of the model's error over one control period, the target's next state less the
    model's, in epsilons, shape (transitions, n, unknowns)."""
    named: int
    """How many unknowns are figures of the hypothesis; the others are weights of what is not."""
    unnamed: Unnamed
    """What is not named."""

    def __len__(self) -> int:
        """The number of transitions."""
        return len(self.error)

    def until(self, count: int) -> Information:
        """Return what the first transitions say of the unknowns."""
        size = self.account.slope.shape[2]
        Z = self.account.slope[:count].reshape(-1, size)
        z = self.account.surprise[:count].ravel() + Z @ self.about
        return Information(H=Z.T @ Z, b=Z.T @ z, c=float(z @ z))


def visit(
    transit: Transit,
    runs: Sequence[Run],
    noise: Array,
    epsilon: Array,
    point: Array | None = None,
) -> Visit:
    """Return what runs say of a model, linearised at the observed states and at the model.

    A state observed wrongly by its noise has slopes that are wrong to first order and a transition
    that is wrong to second order: for a cart-pole and noise of 0.01 that is 2e-4, and counted.

    Args:
        transit: The model as it stands, with what may be wrong in it, and the clock.
        runs: What was observed on the target.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        epsilon: Error over one control period that is still good, shape (n,).
        point: Where to linearise in the figures, if not at the model as it stands.

    Raises:
        DiagnosisError: There is no run, or a run has another clock.
    """
    if not runs or any(abs(run.period - transit.period) > 1e-9 for run in runs):
        raise DiagnosisError(
            f"there are {len(runs)} runs, with control periods of "
            f"{sorted({run.period for run in runs})} s, and the model's is {transit.period:g} s",
            where=f"robot {transit.hypothesis.robot.name}",
            fix="give one run or more, recorded at the control period",
        )
    start = transit.hypothesis.start
    point = start if point is None else point
    model = transit.variant(start).model
    # What was commanded before a run is not known: taken as what was commanded first.
    before = [np.concatenate([run.command[:1], run.command[:-1]]) for run in runs]
    beside = unnamed(
        model,
        np.concatenate([run.state[:-1] for run in runs]),
        np.concatenate([run.command for run in runs]),
        np.concatenate(before),
        epsilon=epsilon,
        period=transit.period,
    )
    accounts, errors = [], []
    for run, late in zip(runs, before, strict=True):
        slopes = transit.slopes(point, run, run.state)
        weights = beside(model, run.state[:-1], run.command, late)
        unknown = np.concatenate([slopes.parameter, weights], axis=2)
        accounts.append(
            account(
                run.state, slopes.value, slopes.state, unknown, noise=noise, unsaid=ROUGH * noise
            )
        )
        errors.append(unknown / epsilon[:, None])
    return Visit(
        account=Account(
            surprise=np.concatenate([each.surprise for each in accounts]),
            slope=np.concatenate([each.slope for each in accounts]),
        ),
        about=np.concatenate([point - start, np.zeros(errors[0].shape[2] - len(point))]),
        error=np.concatenate(errors),
        named=len(point),
        unnamed=beside,
    )
