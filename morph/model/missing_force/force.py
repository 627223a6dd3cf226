"""The learned force as an effect, so that a corrected simulator can be searched in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.model.missing_force.fourier_features import FourierFeatures
from morph.physics.effect import Effect, Simulations
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class MissingForce(Effect):
    """A force on every joint that depends on positions and velocities, as a sum of waves.

    It has no name in the vocabulary of left-out physics: it is what is left when no name fits.

    Source: Gamboa Higuera 2015, eqs. 8 and 12, with the correction as a force and not as a jump
    of the state.
    """

    name: ClassVar[str] = "missing_force"
    kind: ClassVar[str] = "world"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ()
    excited_by: ClassVar[str] = "Motion through all states in which it is to hold."

    joints: tuple[str, ...]
    """The joints whose states it reads and on which it acts, in the robot's order."""
    waves: FourierFeatures
    """What it looks at."""
    weight: Array
    """Force of each feature on each joint, N or N m, shape (joints, features)."""

    def __post_init__(self) -> None:
        """Check the shape and the numbers."""
        shape = (len(self.joints), self.waves.count)
        if self.weight.shape != shape or not np.isfinite(self.weight).all():
            raise EffectError(
                f"its weights have the shape {self.weight.shape}, or are not all finite",
                where="effect missing_force@world",
                fix=f"give finite numbers of shape {shape}",
            )

    @property
    def where(self) -> str:
        """The world."""
        return "world"

    @classmethod
    def at(cls, where: str) -> MissingForce:
        """Refuse: it is learned, and has no neutral shape.

        Raises:
            EffectError: Always.
        """
        raise EffectError(
            "it is learned from runs, and cannot be made from a name",
            where=f"effect missing_force@{where}",
            fix="fit one with morph.model.missing_force.fit",
        )

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the world."""
        return ("world",)

    def force(self, state: Array) -> Array:
        """Return the force on each joint, (..., joints), in states (..., 2 joints)."""
        return np.asarray((self.waves.of(state) * self.weight).sum(axis=-1))

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Add the force to every joint."""
        now = [simulations.position(joint) for joint in self.joints]
        now += [simulations.velocity(joint) for joint in self.joints]
        force = self.force(np.nan_to_num(np.stack(now, axis=1)))
        for at, joint in enumerate(self.joints):
            simulations.force(joint)[:] += force[:, at]
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return nothing: it has no strengths."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return what it means that this is needed."""
        return "A force that depends on the state is left that no figure of the body explains."
