"""Baseline: a ladder of fidelities (multi-fidelity reinforcement learning)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import torch

from morph.errors import SearchError, TransferError
from morph.model.jointed.fit import fit
from morph.model.jointed.jointed import Jointed, through
from morph.policy_transfer.baselines.baseline import Baseline, NextStep, needs_experience
from morph.policy_transfer.baselines.learner import WEAK, best_plan, periods, randomly, told
from morph.policy_transfer.baselines.source import Source, random_commands
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.search import Trial
from morph.search.target import Experience, Simulated, Target
from morph.sim.simulator import Simulator
from morph.task.task import Task

RUNGS = 3
"""The simulator in coarse steps, in its own, and the target."""

STEPS = 2
"""Steps of a control period in the lowest fidelity."""

WITHIN = 3.0
"""Standard deviations within which a period is no surprise."""


@dataclass(frozen=True, kw_only=True)
class Ladder(Baseline):
    """Tries each plan in simulation before it costs a trial, wherever it would lead to new places.

    The rungs are the source's simulator in coarse steps, the same in its own, and the target.
    What each rung shows corrects what the one below says, so that knowledge of the target counts
    on every rung, and that of simulators wherever the target was not seen yet. A run that
    surprises sends the search a rung down, with a new plan; one that does not, a rung up.

    Source: Cutler, Walsh and How 2014, Reinforcement learning with multi-fidelity simulators,
    ICRA. There values go up as heuristics of learners that know what they know, and what is
    known comes down; here each rung's accelerations are the mean of those of the next.
    """

    name: ClassVar[str] = "ladder of fidelities"

    most: int = 2
    """Most runs in simulation between two trials."""
    sure: float = 0.9
    """Share of periods that must be no surprise for a step up."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.most < 0 or not 0.0 < self.sure <= 1.0:
            raise TransferError(
                f"it has {self.most} runs between trials, and is sure at {self.sure:g}",
                where=f"rival {self.name}",
                fix="give 0 runs or more, and a share above 0 and at most 1",
            )

    def check(self, source: Source) -> None:
        """Refuse a source without experience."""
        needs_experience(self, source)

    def step(self, source: Source, memory: SearchCheckpoint, rng: np.random.Generator) -> NextStep:
        """Return the source's policy at first, and then what promises most by all rungs."""
        seen = (_coarsely(source), source.experience, memory.experience)
        return self._next(source, _models(source.task, seen), memory, rng)

    def _next(
        self,
        source: Source,
        models: Sequence[Jointed],
        memory: SearchCheckpoint,
        rng: np.random.Generator,
    ) -> NextStep:
        if not memory.experience:
            return NextStep(policy=source.policy, note="the source's policy")
        if len(models) < RUNGS:
            return randomly(source.task, rng, share=WEAK, why="too little was seen of the target")
        return best_plan(source.task, models[-1], memory, self.effort, rng)

    def _run(self, source: Source, target: Target, trials: int, seed: int) -> tuple[Trial, ...]:
        began, top = time.perf_counter(), RUNGS - 1
        rungs = (_coarse(source), source.target, target)
        seen = [_coarsely(source), source.experience, ()]
        models, memory, at, below = _models(source.task, seen), SearchCheckpoint(), top, 0
        step = self._next(source, models, memory, np.random.default_rng([seed, 0]))
        while True:
            number, here = len(memory.experience) + 1, at == top
            # Simulated runs have chance of their own: the target's is shared with other rivals.
            chance = [seed, number, 1] if here else [seed, number, 2, below]
            shown = rungs[at].trial(step.policy, np.random.default_rng(chance))
            sure = share_expected(models[: at + 1], shown, source.task) >= self.sure
            seen[at] = (*seen[at], shown)
            if here:
                note = f"{step.note}; runs in simulation before it: {below}"
                memory = memory.after(shown, step.plan, time.perf_counter() - began, note)
                if number == trials:
                    break
            if here or not sure:
                models = _models(source.task, seen)
                rng = np.random.default_rng([seed, number, 0, below])
                step = self._next(source, models, memory, rng)
            below = 0 if here else below + 1
            at = top if below >= self.most else min(max(at + (1 if sure else -1), 0), top)
        return tuple(replace(line, number=n) for n, line in enumerate(memory.lines, 1))


def share_expected(models: Sequence[Jointed], shown: Experience, task: Task) -> float:
    """Return the share of a run's periods that end as the last of some models foresees.

    The others are what it stands on, whose doubt adds to its own. A period counts if the change
    of every joint's velocity is within `WITHIN` standard deviations.
    """
    model = models[-1]
    try:
        data = periods((shown,), told(task), task)
    except SearchError:
        return 0.0
    q, v, u = (torch.as_tensor(a) for a in (*data.middle, data.command))
    begin = torch.as_tensor(data.position), torch.as_tensor(data.velocity)
    with torch.no_grad():
        _, came = through(model.mean, *begin, u, data.period)
        doubt = sum((each.variance(q, v, u).numpy() for each in models), np.zeros(q.shape))
    spread = np.sqrt(doubt * data.period**2 + 2.0 * model.velocity_noise**2)
    off = np.abs(data.next_velocity - came.numpy()) / spread
    return float((off < WITHIN).all(axis=1).mean())


def _models(task: Task, seen: Sequence[tuple[Experience, ...]]) -> list[Jointed]:
    """Return what each rung says, each with the one below as its mean, as far as runs tell."""
    models: list[Jointed] = []
    for runs in seen:
        try:
            data = periods(runs, told(task), task) if runs else None
            base = models[-1].mean if models else None
            models += [fit(data, told(task), base=base)] if data is not None else []
        except SearchError:
            break
    return models


def _coarse(source: Source) -> Simulated:
    """Return the source's simulator in coarse steps."""
    task, effects = source.task, source.target.simulator.effects
    step = task.period / STEPS
    simulator = Simulator(task.robot, effects, step=step, integrator="implicitfast")
    return Simulated(task=replace(task, step=step, integrator="implicitfast"), simulator=simulator)


def _coarsely(source: Source) -> tuple[Experience, ...]:
    """Return what the source's experience is on the lowest rung."""
    coarse, rng = _coarse(source), np.random.default_rng(0)
    policies = (random_commands(source.task, rng), source.policy)
    return tuple(coarse.trial(each, rng) for each in policies)
