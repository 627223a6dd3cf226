"""One model of a body among several, with the figures of it that are in doubt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.hypothesis import Hypothesis
from morph.sim.rollout import Variant
from morph.sim.simulator import Simulator


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """One model of a body."""

    name: str
    """How reports call it."""
    robot: Robot
    """The body as this model has it."""
    variant: Variant
    """Its compiled simulation."""
    prior: float = 1.0
    """How probable it is before any run, beside the others'."""
    doubts: tuple[Variant, ...] = ()
    """For each of its figures that is in doubt, itself with that moved by a standard deviation.

    What it changes is taken for linear in the figure, and doubts for independent."""

    @classmethod
    def of(
        cls,
        name: str,
        simulator: Simulator,
        *,
        prior: float = 1.0,
        doubts: Sequence[Simulator] = (),
    ) -> Candidate:
        """Return a simulator as a candidate."""
        variant, *moved = (
            Variant(model=each.model, effects=each.effects) for each in (simulator, *doubts)
        )
        return cls(
            name=name, robot=simulator.robot, variant=variant, prior=prior, doubts=tuple(moved)
        )

    @classmethod
    def at(
        cls,
        name: str,
        hypothesis: Hypothesis,
        point: Array,
        *,
        prior: float = 1.0,
        covariance: Array | None = None,
    ) -> Candidate:
        """Return a hypothesis at a point as a candidate, perhaps in doubt by a covariance."""
        moves = (
            np.zeros((0, len(point))) if covariance is None else np.linalg.cholesky(covariance).T
        )
        return cls(
            name=name,
            robot=hypothesis.robot,
            variant=hypothesis.at(point),
            prior=prior,
            doubts=tuple(hypothesis.at(point + move) for move in moves),
        )
