"""Baselines that learn accelerations, plan in them and try the most promising plan."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from morph.errors import SearchError
from morph.model.jointed.fit import JointedSettings
from morph.model.jointed.jointed import Jointed
from morph.model.jointed.transition import JointTransitions, transitions
from morph.policy_transfer.baselines.baseline import Baseline, NextStep
from morph.policy_transfer.baselines.source import Source, random_commands
from morph.search.learned_dynamics.learned_body import Dream, known, settings_of
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.learned_dynamics.plans import TrialBudget, chosen, plans
from morph.search.target import Experience
from morph.task.task import Task

WEAK = 0.3
"""Share of the bounds of the random commands that are tried where nothing can be learned."""


@dataclass(frozen=True, kw_only=True)
class Learner(Baseline):
    """What runs of the source and of the target say together differs; all else is one way.

    The first trial is the source's policy. After each, accelerations are learned, and of the
    plans that are good in their mean the one is tried that does best over all that they may be:
    the parts of the search gp-ddp.
    """

    @abstractmethod
    def learned(
        self, source: Source, memory: SearchCheckpoint, settings: JointedSettings
    ) -> Jointed:
        """Return the accelerations of the target, as far as all that was seen tells them.

        Raises:
            SearchError: It tells too little.
        """

    def step(self, source: Source, memory: SearchCheckpoint, rng: np.random.Generator) -> NextStep:
        """Return what is tried first, and from then on what promises most by what was seen."""
        if not memory.experience:
            return self.first(source, rng)
        settings = told(source.task)
        try:
            learned = self.learned(source, memory, settings)
        except SearchError as error:
            return randomly(source.task, rng, share=WEAK, why=error.what)
        return self.planned(source, learned, memory, rng)

    def first(self, source: Source, rng: np.random.Generator) -> NextStep:
        """Return what is tried before anything was seen of the target."""
        return NextStep(policy=source.policy, note="the source's policy")

    def planned(
        self, source: Source, learned: Jointed, memory: SearchCheckpoint, rng: np.random.Generator
    ) -> NextStep:
        """Return the plan, new or tried before, that does best over what is believed."""
        return best_plan(source.task, learned, memory, self.effort, rng)


def told(task: Task) -> JointedSettings:
    """Return what is told of a body before any run: which joints turn, and its bounds."""
    return settings_of(*known(task), slides=False, lawful=True)


def best_plan(
    task: Task,
    learned: Jointed,
    memory: SearchCheckpoint,
    effort: TrialBudget,
    rng: np.random.Generator,
) -> NextStep:
    """Return the plan that does best on average over the bodies that are believed possible.

    Args:
        task: What is to be done.
        learned: What is believed of the target.
        memory: What was seen of the target, and the plans that were tried there.
        effort: How much is computed.
        rng: Chance.
    """
    model, bounds = known(task)
    dream = Dream(task, model, bounds, learned)
    seen = transitions(
        [(each.position, each.velocity, each.command) for each in memory.experience], task.period
    )
    blur = learned.velocity_noise
    noise = np.concatenate([seen.position_noise(blur), blur])
    best = chosen(task, dream, plans(task, dream, effort, rng), memory.tried, noise, effort, rng)
    return NextStep(
        policy=best.plans.track(0, task),
        plan=best.plans,
        logs=learned.logs.numpy(),
        note=f"foreseen: loss {best.loss:.3g}, success {best.success:.2f}",
    )


def randomly(task: Task, rng: np.random.Generator, *, share: float, why: str) -> NextStep:
    """Return random commands to try."""
    note = f"random commands within {share:g} of their bounds: {why}"
    return NextStep(policy=random_commands(task, rng, share=share), note=note)


def periods(
    seen: tuple[Experience, ...], settings: JointedSettings, task: Task
) -> JointTransitions:
    """Return what runs showed, but for periods in which a joint turned too far.

    Raises:
        SearchError: Too few are left.
    """
    return SearchCheckpoint(experience=seen).periods(settings.turning, task.period, settings.names)
