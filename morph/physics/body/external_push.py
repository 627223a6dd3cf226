"""A push that the simulation knows nothing of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.ndimage import uniform_filter1d

from morph.arrays import Array
from morph.physics.effect import Effect, Simulations, parameter
from morph.physics.kinds import BodyEffect
from morph.physics.motion import Motion

TREND, APART = 1.0, 0.3
"""Seconds over which a missing force may drift, and least time between pushes and after a start."""
STANDS_OUT, ALONE = 8.0, 1.5
"""How high the missing force of a push is, in median absolute deviations and in units of the next
highest."""


@dataclass(frozen=True, kw_only=True)
class ExternalPush(BodyEffect):
    """A link is pushed from start to end by a constant force, at its centre of mass.

    Its impulse is (x, y, z) in the world's axes: the force times how long it lasts. Each step
    has the mean over the step. Times count from where a run starts; one that is shorter
    than a step is spread over a step. A push of one run happens to a robot and is no part of it:
    no simulation repeats it.

    Source: Newton 1687, Principia, law II: an impulse is the change of momentum.
    """

    name: ClassVar[str] = "external_push"
    strengths: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    suspected: ClassVar[bool] = False
    of_a_run: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = (
        "end_stop",
        "ground",
        "speed_torque_limit",
        "torque_saturation",
    )
    excited_by: ClassVar[str] = "The same run twice: a push is in one of them."
    separate_by: ClassVar[dict[str, str]] = {
        "end_stop": "Come to the same position twice: a stop is there every time.",
        "ground": "Come down twice: a floor is there every time.",
        "speed_torque_limit": "Command the same torque at the same speed twice.",
        "torque_saturation": "Command the same torque twice: a limit is there every time.",
    }

    body: str
    """Link it acts on."""
    run: str = ""
    """Name of the only run in which it acts; empty: it acts in all."""
    start: float = parameter(0.0, unit="s", low=0.0, high=1e6, spread=1.0)
    """When it begins."""
    end: float = parameter(0.1, unit="s", low=0.0, high=1e6, spread=1.0)
    """When it ends."""
    x: float = parameter(0.0, unit="N s", low=-1e5, high=1e5, neutral=0.0)
    """Impulse along the world's x."""
    y: float = parameter(0.0, unit="N s", low=-1e5, high=1e5, neutral=0.0)
    """Impulse along the world's y."""
    z: float = parameter(0.0, unit="N s", low=-1e5, high=1e5, neutral=0.0)
    """Impulse along the world's z."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return the time, s."""
        return np.zeros(len(simulations.push(self.body)))

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Push the link while it lasts."""
        if self.run:
            return state
        force = np.stack(np.broadcast_arrays(self.x, self.y, self.z), axis=-1)
        share = np.asarray(self._share(state, simulations.step))
        simulations.push(self.body)[:] += share[:, None] * force
        return state + simulations.step

    def regressor(self, motion: Motion) -> Array:
        """Return what one N s along each axis of the world does, spread over the push."""
        body = motion.bodies[self.body]
        if self.run not in ("", motion.run):
            return np.zeros((*motion.position.shape, 3))
        steps = np.diff(motion.time, append=2.0 * motion.time[-1] - motion.time[-2])
        share = self._share(motion.time, steps)
        return body.pulled(share[:, None, None] * np.eye(3), body.com)

    def shapes(self, motion: Motion) -> tuple[ExternalPush, ...]:
        """Return pushes of a run where one short missing force stands out, none where none does."""
        if len(motion.missing) < 3:
            return ()
        step = float(motion.time[1] - motion.time[0])
        rest = motion.missing - uniform_filter1d(motion.missing, round(TREND / step), axis=0)
        usual = np.median(np.abs(rest), axis=0) + 1e-12
        high = np.abs(rest / usual).max(axis=1)
        # At the start of a run what moves unseen, as a rotor in a gap, is not known yet.
        high[motion.time < APART] = 0.0
        peak = int(high.argmax())
        apart = np.abs(motion.time - motion.time[peak]) > APART
        if high[peak] < max(STANDS_OUT, ALONE * float(high[apart].max(initial=0.0))):
            return ()
        lasts = np.flatnonzero(high < 0.5 * high[peak])
        before, after = lasts[lasts < peak], lasts[lasts > peak]
        first = int(before[-1]) + 1 if len(before) else 0
        last = int(after[0]) if len(after) else len(high) - 1
        middle, length = 0.5 * (first + last) * step, max(1, last - first) * step
        # The force that a link takes changes as it turns: its push may lie beside what stands out.
        middles = [middle + shift * length for shift in (-0.5, 0.0, 0.5)]
        halves = [0.5 * share * length for share in (0.6, 1.2)]
        return tuple(
            replace(self, run=motion.run, start=max(0.0, at - half), end=at + half)
            for at in middles
            for half in halves
        )

    @property
    def passing(self) -> bool:
        """Whether it is an event of one run."""
        return bool(self.run)

    def beside(self, other: Effect) -> bool:
        """Return whether another effect may act too: of pushes one a run."""
        return not (isinstance(other, ExternalPush) and other.run == self.run)

    def within(self, run: str, begin: float) -> ExternalPush:
        """Return a push of a part of a run, which begins at a time of it, as one of the run."""
        return replace(self, run=run, start=self.start + begin, end=self.end + begin)

    def _share(self, time: Array, step: Any) -> Array:
        """Return the mean force over steps for one N s, 1/s."""
        end = np.maximum(self.end, self.start + step)
        lasts = np.minimum(time + step, end) - np.maximum(time, self.start)
        return np.asarray(np.maximum(lasts, 0.0) / (step * (end - self.start)))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        impulse = ", ".join(f"{value:.3g}" for value in (self.x, self.y, self.z))
        return (
            f"Link {self.body} is pushed{f' in {self.run}' if self.run else ''} "
            f"from {self.start:.4g} s to {self.end:.4g} s with an "
            f"impulse of ({impulse}) N s in the axes of the world: a push was left out."
        )
