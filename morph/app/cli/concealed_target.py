"""Concealed changes of a target: given openly, or drawn from a seed and sealed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.model.latent.candidates import places
from morph.model.latent.unknowns import turned, unknowns
from morph.physics.effect import Effect, Parameter
from morph.policy.policy import UNLIMITED, Policy, actions_of
from morph.policy_transfer.retask import task_for
from morph.search.evaluate import attempt
from morph.search.target import Simulated
from morph.task.moved import Moved
from morph.task.run import run
from morph.task.task import Task

LEAST, MOST = 1.25, 2.0
"""A drawn figure is off by a factor of so much, up or down."""

WEAK, STRONG = 0.05, 0.3
"""Shares of what moves a joint in the source's run that a drawn effect has."""

STILL = 0.1
"""A joint that the policy moves by less than so much of what chance does is as good as still."""

SHAKEN = 0x54A
"""Seed of the commands by chance that show how a body moves."""

KINDS = ("joint", "actuator")
"""Kinds of effects that are drawn."""


@dataclass(frozen=True, kw_only=True)
class Concealed:
    """In what a target differs from its description."""

    factors: Mapping[str, float] = field(default_factory=dict)
    """Factors on figures: `{"length:pole": 2.0}`."""
    effects: tuple[Effect, ...] = ()
    """What acts on it that the description leaves out."""

    @property
    def values(self) -> dict[str, float]:
        """Each factor, and each parameter of an effect, by the name that a finding would have."""
        statement = dict(self.factors)
        for effect in self.effects:
            for known in effect.parameters():
                statement[f"{effect.label}:{known.name}"] = float(getattr(effect, known.name))
        return statement

    def target(self, task: Task) -> Simulated:
        """Return the simulation that stands for the target of a task.

        Raises:
            DiagnosisError: A figure is not one of the body's.
        """
        there = task_for(task, turned(task.robot, self.factors)) if self.factors else task
        return Simulated(task=there, simulator=there.simulator(self.effects))


def changes(texts: Sequence[str]) -> dict[str, float]:
    """Return factors by figures, of `FIGURE=FACTOR`.

    Raises:
        TransferError: One is no such pair, its factor is none, or it is given twice.
    """
    results: dict[str, float] = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        try:
            factor = float(value)
        except ValueError:
            factor = np.nan
        if not name or not 0.0 < factor < np.inf or name in results:
            raise TransferError(
                f"{name} is given twice" if name in results else f"{text!r} is no FIGURE=FACTOR",
                where="--change",
                fix="write each figure once, for example length:pole=2",
            )
        results[name.strip()] = factor
    return results


def drawn(task: Task, policy: Policy, seed: int) -> Concealed:
    """Return one or two differences that a seed conceals.

    Each is, by even chance, a figure of the description or an effect on a joint or an actuator;
    how strong an effect typically is, is taken from the run of the source's policy and from one
    under commands by chance.

    Args:
        task: The source's task.
        policy: The source's policy.
        seed: Of the draw.
    """
    rng = np.random.default_rng([seed, 0x5EA1ED])
    knobs = unknowns(task.robot)
    figures = [knob.name for knob in knobs]
    missing = [each for each in places(task.robot, knobs) if each.kind in KINDS]
    scales = _Scales(attempt(task, policy, task.simulator(), rows=1, rng=None), _shaken(task))
    result = Concealed()
    for _ in range(int(rng.integers(1, 3))):
        if missing and rng.random() < 0.5:
            effect = missing.pop(int(rng.integers(len(missing))))
            # Two of one place would say much the same.
            missing = [each for each in missing if each.where != effect.where]
            result = replace(result, effects=(*result.effects, _typical(effect, scales, rng)))
        else:
            name = figures.pop(int(rng.integers(len(figures))))
            size = rng.uniform(np.log(LEAST), np.log(MOST)) * rng.choice([-1, 1])
            result = replace(result, factors={**result.factors, name: _rounded(np.exp(size))})
    return result


def _shaken(task: Task) -> Moved:
    """Return a run under commands by chance: a policy that holds still shows no motion."""
    simulator, rng = task.simulator(), np.random.default_rng(SHAKEN)
    position, velocity = task.start.sample(task.robot, simulator.model, 1, None)
    bounds = np.array([(each.low, each.high) for each in actions_of(task.robot)])
    # A bound that is none would command a million radians.
    low, high = np.where(np.abs(bounds) < UNLIMITED, bounds, np.sign(bounds)).T
    return run(
        task, simulator, lambda q, v, now: rng.uniform(low, high, (1, len(low))), position, velocity
    )


class _Scales:
    """What is much for a parameter at a place, by what runs of the source show.

    Args:
        policy: The run of its policy.
        chance: A run under commands by chance.
    """

    def __init__(self, policy: Moved, chance: Moved) -> None:
        self._robot, self._model = policy.robot, policy.model
        self.period = float(policy.time[1] - policy.time[0])
        own, shaken = self._told(policy), self._told(chance)
        # Where the policy hardly moves a joint, what is much there is told by chance.
        force, mass, speed, span = (
            np.where(ours > STILL * theirs, ours, theirs)
            for ours, theirs in zip(own, shaken, strict=True)
        )
        self._force, self._mass, self._speed, self._span = force, mass, speed, span

    def _told(self, moved: Moved) -> tuple[Array, Array, Array, Array]:
        """Return of one run what accelerates each joint, its inertia, its speed and its span."""
        model = self._model
        data: Any = mujoco.MjData(model)
        change = np.diff(moved.velocity[0], axis=0) / self.period
        forces, masses, whole = [], [], np.zeros((model.nv, model.nv))
        for q, slope in zip(moved.position[0], change, strict=False):
            data.qpos[:] = q
            mujoco.mj_forward(model, data)
            mujoco.mj_fullM(model, data, whole)
            forces.append(whole @ slope)
            masses.append(np.diag(whole).copy())
        span = np.ptp(moved.position[0], axis=0)
        return _rms(forces), np.mean(masses, axis=0), _rms(moved.velocity[0]), span

    def of(self, effect: Effect, known: Parameter) -> float:
        """Return a size of a parameter at which its effect is as strong as what moves the joint."""
        if known.unit == "s":
            return self.period
        if effect.kind != "joint":
            return 1.0
        here = self._model.joint(effect.where)
        dof = int(here.dofadr[0])
        force, speed = float(self._force[dof]), max(float(self._speed[dof]), 1e-6)
        span = max(float(self._span[int(here.qposadr[0])]), 1e-6)
        # Of a slide the same with N for N m, and m for rad.
        return {
            "N m": force,
            "N m s/rad": force / speed,
            "N m s2/rad2": force / speed**2,
            "N m/rad": force / span,
            "rad": span,
            "rad/s": speed,
            "kg m2": float(self._mass[dof]),
        }.get(known.unit, 1.0)


def _typical(effect: Effect, scales: _Scales, rng: np.random.Generator) -> Effect:
    """Return an effect with a typical strength."""
    values: dict[str, float] = {}
    before: dict[str, float] = {}
    for known in effect.free():
        scale = scales.of(effect, known)
        if known.unit == "-":
            value = float(rng.choice([rng.uniform(0.6, 0.8), rng.uniform(1.25, 1.6)]))
        elif known.unit == "s":
            value = scale * rng.uniform(0.3, 1.0)
        elif known.neutral is None:
            value = scale * rng.uniform(0.05, 0.3)
        elif known.unit in before:
            # Friction at rest is more than friction in motion.
            value = before[known.unit] * rng.uniform(1.4, 2.5)
        else:
            value = scale * np.exp(rng.uniform(np.log(WEAK), np.log(STRONG)))
        before.setdefault(known.unit, value)
        values[known.name] = float(np.clip(_rounded(value), known.low, known.high))
    return replace(effect, **values)  # type: ignore[type-var]


def _rms(values: Any) -> Any:
    return np.sqrt(np.mean(np.square(np.asarray(values)), axis=0))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")
