"""Will a policy cost on the target what the model says: a model may err where no task cares."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch

from morph.arrays import Array, Integers
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.kwik.certify import EPSILONS, Answer
from morph.model.kwik.features import Unnamed
from morph.model.kwik.refine_linearisation import closer
from morph.model.latent.run import Run
from morph.model.latent.transition_model import Transit
from morph.policy.observing import Observer
from morph.policy.policy import LARGEST, Policy
from morph.sim.rollout import Variant, quiet, rollout
from morph.sim.threads import batch_threads
from morph.task.moved import Moved
from morph.task.task import Task

WITHIN = 0.1
"""By what share of the model's cost the target's may differ, if nothing else is said."""

TARGETS = 24
"""Targets drawn from what is believed."""

RUNS = 8
"""Noisy runs on each, whose mean is its cost: what chance leaves in it counts as doubt."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictedCost:
    """What a policy will cost on the target."""

    verdict: Answer
    """`good`: within the tolerance; `not good`: outside; `cannot say`."""
    probability: float
    """That the target's cost is within the tolerance of the model's."""
    model: float
    """What the policy costs in the model, over noisy runs."""
    targets: Array
    """What it costs on targets drawn from what is believed, shape (targets,)."""

    @property
    def text(self) -> str:
        """What is foretold in a sentence."""
        low, high = np.quantile(self.targets, [0.05, 0.95])
        return (
            f"The policy costs {self.model:.3g} in the model, and on the target {low:.3g} to "
            f"{high:.3g} with 90 %: within the tolerance with probability {self.probability:.2f}."
        )


def foretell(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    task: Task,
    policy: Policy,
    *,
    within: float = WITHIN,
    delta: float = 0.05,
    rng: np.random.Generator,
) -> PredictedCost:
    """Return whether a policy will cost on the target what it costs in the model.

    Targets are drawn from what the runs say, figures and what is not named, and the policy runs
    on all of them and on the model itself in one batch.

    Args:
        hypothesis: The model as it stands, and what may be wrong in it.
        runs: What was observed on the target, under this policy or another.
        task: Whose cost counts; its robot is the hypothesis', its noise that of the runs.
        policy: Tried.
        within: Tolerance, as a share of the model's cost.
        delta: How often an answer may be wrong.
        rng: Of targets, starts and noise.

    Raises:
        DiagnosisError: The tolerance is no positive number, or there is no noise.
        SearchError: The policy's period is not the task's.
    """
    if not (0.0 < within < math.inf and 0.0 < delta < 0.5 and task.noise > 0.0):
        raise DiagnosisError(
            f"a tolerance of {within:g}, a delta of {delta:g} and a noise of {task.noise:g} "
            "foretell nothing",
            where=f"the cost of task {task.name}",
            fix="give a tolerance and a noise above 0, and a delta between 0 and 0.5",
        )
    loss = _losses(hypothesis, runs, task, policy, rng)
    model, targets = float(loss[0]), loss[1:]
    near = float(np.mean(np.abs(targets - model) <= within * model))
    answer: Answer = (
        "good" if near >= 1.0 - delta else "not good" if near <= delta else "cannot say"
    )
    return PredictedCost(verdict=answer, probability=near, model=model, targets=targets)


def _losses(
    hypothesis: Hypothesis,
    runs: Sequence[Run],
    task: Task,
    policy: Policy,
    rng: np.random.Generator,
) -> Array:
    """Return the mean cost on the model itself, then on each drawn target, (1 + targets,)."""
    integrator = task.simulator().integrator
    transit = Transit(hypothesis=hypothesis, period=task.period, integrator=integrator)
    noise = np.full(runs[0].state.shape[1], task.noise) if runs else np.zeros(0)
    points, weights, unnamed = closer(transit, runs, noise, EPSILONS * noise, TARGETS, rng)
    points = np.concatenate([hypothesis.start[None], points])
    weights = np.concatenate([np.zeros((1, weights.shape[1])), weights])
    variants = [transit.variant(point) for point in points]
    which = np.repeat(np.arange(len(variants)), RUNS)
    moved = _moved(variants, which, unnamed, weights[which], task, policy, rng)
    return np.asarray(task.loss(moved).reshape(len(variants), RUNS).mean(axis=1))


def _moved(
    variants: list[Variant],
    which: Integers,
    unnamed: Unnamed,
    weights: Array,
    task: Task,
    policy: Policy,
    rng: np.random.Generator,
) -> Moved:
    """Return what every row does in a closed loop, pushed each period by what is not named."""
    model = variants[0].model
    nq, rows, steps = model.nq, len(which), round(task.period / task.step)
    q, v = task.start.sample(task.robot, model, rows, rng)
    state = np.concatenate([q, v], axis=1)
    observer = Observer(policy, task.robot, model, rows, rng=rng, noise=task.noise)
    advance = _advance(variants, which, steps)
    states: list[Array] = [state]
    stable = np.ones(rows, dtype=bool)
    commanded: list[Array] = []
    for at in range(task.samples - 1):
        seen = observer.see(state[:, :nq], state[:, nq:])
        command = policy.act(seen, np.full(rows, at * task.period))
        change = unnamed(model, state, command, commanded[-1] if commanded else command)
        moved = advance(state, command) + np.einsum("rnk,rk->rn", change, weights)
        stable &= (np.abs(moved) < LARGEST).all(axis=1)
        state = np.where(stable[:, None], moved, state)
        states.append(state)
        commanded.append(command)
    path, command = np.stack(states, axis=1), np.stack([*commanded, commanded[-1]], axis=1)
    return Moved(
        robot=task.robot,
        model=model,
        time=np.asarray(task.period * np.arange(task.samples), dtype=float),
        position=path[..., :nq],
        velocity=path[..., nq:],
        command=command,
        stable=stable,
    )


def _advance(
    variants: list[Variant], which: Integers, steps: int
) -> Callable[[Array, Array], Array]:
    """Return what leads states under held commands one control period on."""
    nq = variants[0].model.nq
    if any(effect.stepped for effect in variants[0].effects):
        # Such effects forget what they remembered, a period at a time.
        def each(state: Array, command: Array) -> Array:
            held = np.repeat(command[:, None], steps, axis=1)
            q, v = rollout(variants, which, state[:, :nq], state[:, nq:], held)
            return np.concatenate([q[:, -1], v[:, -1]], axis=1)

        return each
    batch = Batch(variants[0].model, len(which), batch_threads(len(which)))
    batch.set_models([variants[at].model for at in which])
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    q, v, control = batch.bind("qpos"), batch.bind("qvel"), batch.bind("ctrl")

    def whole(state: Array, command: Array) -> Array:
        q[:], v[:], control[:] = state[:, :nq], state[:, nq:], command
        with quiet():
            batch.step(nstep=steps)
        return np.concatenate([q, v], axis=1)

    return whole
