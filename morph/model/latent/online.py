"""Hidden parameters, inferred while a body runs: the figures in which an ensemble differs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.latent.infer import Inferred, infer
from morph.model.latent.run import FEWEST, Run
from morph.model.latent.unknowns import turned, unknowns
from morph.sim.integrator import Integrator

LEAST_WIDTH = 0.02
"""Least standard deviation of a hidden parameter's logarithm: an ensemble is never all there is."""


def hidden(robot: Robot, members: Sequence[Mapping[str, float]], *, step: float) -> Hypothesis:
    """Return a body whose hidden parameters are the figures in which an ensemble's members differ.

    Each is log-normal, with the members' mean and spread; what is equal in all of them is known.

    Source: Doshi-Velez and Konidaris 2016, Hidden parameter Markov decision processes, IJCAI: a
    family of dynamics is a few parameters that stay the same through one body's life.

    Args:
        robot: The body as described.
        members: For each member, factors on figures, such as `{"length:pole": 1.2}`.
        step: Step of the simulation, s.

    Raises:
        DiagnosisError: There are fewer than two members, all are equal, or a figure is none.
    """
    names = sorted({name for member in members for name in member})
    logs = np.log([[member.get(name, 1.0) for name in names] for member in members])
    spread = logs.std(axis=0, ddof=1) if len(members) > 1 else np.zeros(len(names))
    varied = [at for at in range(len(names)) if spread[at] > 0.0]
    if not varied:
        raise DiagnosisError(
            f"{len(members)} members differ in nothing",
            where=f"an ensemble of {robot.name}",
            fix="give two members or more that differ in a figure",
        )
    middle = turned(robot, dict(zip(names, np.exp(logs.mean(axis=0)).tolist(), strict=True)))
    known = {knob.name: knob for knob in unknowns(middle)}
    knobs = tuple(
        replace(known[names[at]], fraction=max(float(spread[at]), LEAST_WIDTH)) for at in varied
    )
    return Hypothesis(robot=middle, step=step, knobs=knobs)


class OnlineInference:
    """What is known of hidden parameters, sample after sample.

    Args:
        hypothesis: The body with its hidden parameters, such as `hidden` gives.
        noise: Standard deviation of each observation, positions then velocities, shape (n,).
        period: Time from one sample to the next, s.
        integrator: What the simulation steps with.
        every: New samples after which the parameters are inferred again.
        most: Latest samples that are remembered: a few hundred tell what there is to tell.
    """

    def __init__(
        self,
        hypothesis: Hypothesis,
        noise: Array,
        period: float,
        *,
        integrator: Integrator = "implicitfast",
        every: int = 20,
        most: int = 300,
    ) -> None:
        self.hypothesis, self.noise, self.period = hypothesis, noise, period
        self._integrator, self._every, self._most = integrator, max(every, 1), most
        self._states: list[Array] = []
        self._commands: list[Array] = []
        self._new = 0
        self.known: Inferred | None = None
        """What is known now; None before the first inference."""

    def see(self, state: Array, command: Array) -> Inferred | None:
        """Take in an observed state (n,) and what is commanded from then on (nu,).

        Returns:
            What is known now; None before the first inference.

        Raises:
            DiagnosisError: A number is not finite.
        """
        self._states.append(np.array(state, dtype=float))
        self._commands.append(np.array(command, dtype=float))
        del self._states[: -self._most - 1], self._commands[: -self._most - 1]
        self._new += 1
        if self._new >= self._every and len(self._states) > FEWEST + 1:
            self._new = 0
            self.known = self._inferred()
        return self.known

    def _inferred(self) -> Inferred:
        seen, half = np.array(self._states), len(self.noise) // 2
        run = Run(
            position=seen[:, :half],
            velocity=seen[:, half:],
            command=np.array(self._commands[:-1]),
            period=self.period,
        )
        return infer(
            self.hypothesis,
            [run],
            self.noise,
            integrator=self._integrator,
            point=None if self.known is None else self.known.point,
        )
