"""The source of a transfer: its task, policy and data."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.arrays import Array
from morph.model.jointed.fit import fit
from morph.model.jointed.jointed import Jointed
from morph.physics.effect import Effect
from morph.policy.policy import Policy
from morph.search.learned_dynamics.learned_body import known, settings_of
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.target import Experience, Simulated
from morph.task.task import Task

HELD = 4
"""Control periods that each random command is held for: long enough to swing."""

SHAKEN = 0.3
"""Share of the bounds by which random commands shake those of the policy."""

EXPERIENCE = (1, 2, 0)
"""Runs of a source's experience: with random commands, of the policy, and of it shaken."""

ABUNDANT = (3, 1, 2)
"""The same where a simulator is to be learned: 360 control periods of a run of 3 s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """A task that is done on one body: how, and what was seen."""

    task: Task
    """The task with the source's body; the cost is told of by it on the target too."""
    policy: Policy
    """What does it there."""
    experience: tuple[Experience, ...] = ()
    """What was seen there."""
    effects: tuple[Effect, ...] = ()
    """What acts on the source's body beyond the task's own effects."""

    @cached_property
    def target(self) -> Simulated:
        """The source itself as something to make trials on; there they cost nothing."""
        return Simulated(task=self.task, simulator=self.task.simulator(self.effects))

    @cached_property
    def believed(self) -> Jointed:
        """The accelerations that many runs of the source show; the same each time it is asked."""
        model, bounds = known(self.task)
        settings = settings_of(model, bounds, slides=False, lawful=True)
        runs = lived(self, np.random.default_rng(0), ABUNDANT)
        data = SearchCheckpoint(experience=runs).periods(
            settings.turning, self.task.period, settings.names
        )
        return fit(data, settings)

    def with_experience(self, rng: np.random.Generator) -> Source:
        """Return it with a few runs as its experience."""
        return replace(self, experience=lived(self, rng, EXPERIENCE))


def lived(
    source: Source, rng: np.random.Generator, runs: tuple[int, int, int]
) -> tuple[Experience, ...]:
    """Return runs of a source: so many with random commands, of its policy, and of it shaken.

    What is shaken are the commands of one run of the policy, which then no feedback corrects.
    """
    task, target = source.task, source.target
    _, (low, high) = known(task)
    random, own, shaken = runs
    seen = [target.trial(random_commands(task, rng), rng) for _ in range(random)]
    seen += [target.trial(source.policy, rng) for _ in range(own)]
    if shaken:
        plain = target.trial(source.policy, rng).command
        for _ in range(shaken):
            off = random_commands(task, rng, share=SHAKEN)
            seen.append(target.trial(np.clip(plain + off, low, high), rng))
    return tuple(seen)


def random_commands(task: Task, rng: np.random.Generator, *, share: float = 1.0) -> Array:
    """Return commands drawn within a share of their bounds, held a while, (periods, nu)."""
    _, (low, high) = known(task)
    periods = task.samples - 1
    drawn = rng.uniform(low, high, size=(-(-periods // HELD), len(low)))
    return share * np.repeat(drawn, HELD, axis=0)[:periods]
