"""A learned residual: the force that no named effect explains, as a function of the state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.motion import all_needed
from morph.physics.effect import Effect, Simulations
from morph.physics.motion import Motion

FEATURES = 80
"""Random waves whose sum the force is."""
RIDGE = 1e-2
"""Price of a wave, as a share of the data."""


@dataclass(frozen=True, kw_only=True)
class LearnedResidual(Effect):
    """A force on every hinge and slide: ridge regression on random waves of their states.

    It has no name in the vocabulary: it is what a model falls back on when no effect
    fits, and the measure that an effect must beat.

    Source: Rahimi and Recht 2007, NeurIPS 20, algorithm 1.
    """

    name: ClassVar[str] = "learned_residual"
    kind: ClassVar[str] = "world"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ()
    excited_by: ClassVar[str] = "Motion through all states in which it is to hold."

    joints: tuple[str, ...]
    """The joints whose states it reads and on which it acts."""
    arrays: Mapping[str, Any]
    """centre, spread (2 joints,); waves (2 joints, features); phase (features,);
    weight (features, joints); most (joints,)."""

    @property
    def where(self) -> str:
        """The world."""
        return "world"

    def content(self) -> dict[str, Any]:
        """Return what `residual.npz` holds: the joints' names and the arrays."""
        return {"joints": np.array(self.joints), **self.arrays}

    @classmethod
    def at(cls, where: str) -> LearnedResidual:
        """Return a residual of no force on no joint."""
        return cls(joints=(), arrays={})

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the world."""
        return ("world",)

    def force(self, state: Array) -> Array:
        """Return the force on each joint, (n, joints), for states (n, 2 joints)."""
        a = self.arrays
        waves = _waves((state - a["centre"]) / a["spread"], a["waves"], a["phase"])
        return np.asarray(np.clip(waves @ a["weight"], -a["most"], a["most"]))

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Add the force to every joint."""
        now = [simulations.position(j) for j in self.joints]
        now += [simulations.velocity(j) for j in self.joints]
        force = self.force(np.nan_to_num(np.stack(now, axis=1)))
        for index, joint in enumerate(self.joints):
            simulations.force(joint)[:] += force[:, index]
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return nothing: it has no strengths."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return what it means that this is needed."""
        return "A force that depends on the state is left that no known effect explains."


def learned(
    hypothesis: Hypothesis, point: Array, episodes: Sequence[Episode], seed: int
) -> LearnedResidual:
    """Return the residual that explains what a fitted model leaves on its training episodes.

    Args:
        hypothesis: The fitted model, of a robot with a hinge or slide.
        point: Its figures.
        episodes: The training episodes.
        seed: Random seed of the waves.
    """
    parts = all_needed(hypothesis, point, episodes, suspects=False)
    joints = hinges_and_slides(hypothesis.robot)
    dofs = [parts[0].motion.joints[name] for name in joints]
    states = [np.hstack([p.motion.position[:, dofs], p.motion.velocity[:, dofs]]) for p in parts]
    state = np.concatenate(states)
    missing = np.concatenate([part.missing[:, dofs] for part in parts])
    centre, spread = state.mean(axis=0), state.std(axis=0) + 1e-9
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(state.shape[1], FEATURES))
    phase = rng.uniform(0.0, 2.0 * np.pi, FEATURES)
    columns = _waves((state - centre) / spread, waves, phase)
    inner = columns.T @ columns + RIDGE * len(columns) * np.eye(FEATURES)
    return LearnedResidual(
        joints=joints,
        arrays={
            "centre": centre,
            "spread": spread,
            "waves": waves,
            "phase": phase,
            "weight": np.linalg.solve(inner, columns.T @ missing),
            # Outside the data a regression may say anything: no more than was seen.
            "most": np.quantile(np.abs(missing), 0.98, axis=0),
        },
    )


def hinges_and_slides(robot: Robot) -> tuple[str, ...]:
    """Return the joints on which a residual acts."""
    return tuple(joint.name for joint in robot.joints if joint.kind in {"hinge", "slide"})


def _waves(state: Array, waves: Array, phase: Array) -> Array:
    return np.asarray(np.sqrt(2.0 / FEATURES) * np.cos(state @ waves + phase))
