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
        MorphError: An input or a number cannot be used, or the search cannot be made.
    """
    require("learn", "morph.learn")
    from time import perf_counter

    from morph.app.report.learn.outcome import LearnOutcome
    from morph.body.load import load
    from morph.physics.worlds import world as world_of
    from morph.search.search import check_numbers
    from morph.search.searches import default
    from morph.search.searches import search as search_of
    from morph.task.tasks import task as task_of

    check_numbers(trials, seed)
    body = load(robot)
    asked = task_of(task, body)
    around = asked.effects if world is None else world_of(world, body).effects
    asked = replace(asked, world=world or asked.world, effects=(*around, *effects))
    method = search_of(search or default(task, body))()

    def told(trial: Trial, state: State) -> None:
        if progress is not None:
            progress(trial)

    began = perf_counter()
    learned = method.run(method.problem(asked), seed=seed, trials=trials, progress=told)
    return LearnOutcome.of(
        asked,
        method,
        learned,
        seed=seed,
        asked=trials,
        seconds=perf_counter() - began,
        command=f"morph.learn({task!r}, {str(robot)!r}, search={method.name!r}, seed={seed})",
    )
