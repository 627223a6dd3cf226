"""A policy for a task, as `morph learn` finds it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from morph.extras import require

if TYPE_CHECKING:
    from morph.app.report.learn.outcome import LearnOutcome
    from morph.physics.effect import Effect
    from morph.search.search import State, Trial


def learn(
    task: str,
    robot: str | Path,
    *,
    search: str | None = None,
    trials: int | None = None,
    seed: int = 0,
    world: str | None = None,
    effects: Sequence[Effect] = (),
    progress: Callable[[Trial], None] | None = None,
) -> LearnOutcome:
    """Return the policy that a search finds for a task, and how good it is on held-out runs.

    `save` of the result writes the policy with a report.

    Args:
        task: A name from `morph list tasks`.
        robot: As `morph.load` takes it.
        search: A name from `morph list searches`; by default one that suits the task.
        trials: Most trials, generations or rounds; by default the search's own number.
        seed: Random seed.
        world: Where it learns, if not where the task says: a name that `morph.world` takes.
        effects: Physics that acts on it beside that of the world.
        progress: Called after each trial.

    Raises:
        MorphError: An input cannot be used, or the search cannot be made.
    """
    require("learn", "morph.learn")
    from time import perf_counter

    from morph.app.report.learn.judge import judge
    from morph.app.report.learn.outcome import LearnOutcome
    from morph.body.load import load
    from morph.physics.worlds import world as world_of
    from morph.search.search import Problem
    from morph.search.searches import default
    from morph.search.searches import search as search_of
    from morph.search.target import Simulated
    from morph.task.tasks import task as task_of

    body = load(robot)
    asked = task_of(task, body)
    around = asked.effects if world is None else world_of(world, body).effects
    asked = replace(asked, world=world or asked.world, effects=(*around, *effects))
    method, simulator = search_of(search or default(task, body))(), asked.simulator()
    problem = Problem(
        task=asked,
        simulator=None if method.from_trials else simulator,
        target=Simulated(task=asked, simulator=simulator),
    )

    def told(trial: Trial, state: State) -> None:
        if progress is not None:
            progress(trial)

    began = perf_counter()
    found = method.run(problem, seed=seed, trials=trials, progress=told)
    return LearnOutcome(
        task=asked,
        search=method,
        policy=found.policy,
        judged=judge(asked, found.policy, asked.simulator(), seed),
        trials=found.trials,
        claimed=found.succeeded,
        why_not=found.why,
        seed=seed,
        asked=trials,
        experience=max((trial.experience for trial in found.trials), default=0.0),
        seconds=perf_counter() - began,
        command=f"morph.learn({task!r}, {str(robot)!r}, search={method.name!r}, seed={seed})",
    )
