"""Planning again: a plan for a changed body that begins from what an old policy does there."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.plan.delayed_actuation import late
from morph.search.plan.evaluate_plan import concluded
from morph.search.plan.initial_trajectories import SWING_SHARE, SeedInputs, led, swung
from morph.search.plan.plan_selection import KINDS, SURE, Planned, joined, judged, sifted
from morph.search.plan.policy import track_of
from morph.search.plan.terminal_controller import grounded
from morph.search.plan.warm_start import recalled
from morph.search.search import Learned, Problem, Trial
from morph.search.trajectory.delay_augmented_plant import is_late
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator
from morph.sim.threads import one_thread
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True)
class ReplanBudget:
    """What one stage of planning again spends."""

    recalled: int
    """Commands of the old policy that are stretched and scaled."""
    rows: int
    """Fresh bang-bang swings; 0 for none."""
    keep: int
    """Guesses that are improved."""
    most: int
    """Most steps of dynamic programming."""
    runs: int
    """Noisy runs by which plans are judged."""
    kinds: tuple[tuple[float, float], ...] = KINDS
    """What feedback is tried."""
    margin: float = 0.0
    """Share of each command's range, at both its ends, that is left to the feedback."""
    share: float = SWING_SHARE
    """Share of the horizon within which a swing must reach the top: a weak motor takes longer."""


STAGES = (
    ReplanBudget(recalled=32, rows=96, keep=2, most=8, runs=16, kinds=KINDS[1:4]),
    ReplanBudget(recalled=64, rows=128, keep=3, most=15, runs=24),
    ReplanBudget(recalled=0, rows=768, keep=4, most=20, runs=32),
    ReplanBudget(recalled=0, rows=768, keep=4, most=20, runs=32, margin=0.1),
    ReplanBudget(recalled=0, rows=1536, keep=6, most=30, runs=32),
)
"""Ever greater effort, until a plan succeeds; the last three are what a fresh search does."""


def again(
    task: Task,
    simulator: Simulator,
    old: Policy | None,
    *,
    seed: int,
    others: Sequence[Simulator] = (),
    stages: Sequence[ReplanBudget] = STAGES,
    seconds: float = np.inf,
) -> Learned:
    """Return a plan with feedback for a task in a changed simulator, from an old policy.

    What the old policy commands in the new simulator, as it is, stretched in time and scaled, is
    improved by dynamic programming. Only while no plan succeeds in the noise are fresh swings
    drawn, ever more of them.

    Args:
        task: The task, of the body as it is known now.
        simulator: That body under the effects that are known now.
        old: What did the task before the change; None to begin with fresh swings.
        seed: Chance begins from it.
        others: Further simulators of the same body, such as draws of what is known of it: plans
            and feedback are chosen by how they do in all of them together.
        stages: What is spent, stage after stage.
        seconds: No further stage begins after so long, s.

    Raises:
        SearchError: The body cannot rest where its goals are met, or nothing holds it there.
        SimulationFailed: The task's control period does not fit the simulator.
    """
    if is_late(simulator):
        return late(task, simulator, old, seed=seed, others=others)
    began = time.monotonic()
    best: tuple[SeedInputs, Planned] | None = None
    record: list[Trial] = []
    grounds: dict[float, SeedInputs] = {}
    plants = [Plant(each, task.period) for each in others]
    with one_thread():
        for number, effort in enumerate(stages, start=1):
            if old is None and effort.rows == 0:
                continue
            if best is not None and time.monotonic() - began > seconds:
                break
            rng = np.random.default_rng([seed, number])
            if effort.margin not in grounds:
                chance = np.random.default_rng(seed)
                grounds[effort.margin] = grounded(task, simulator, margin=effort.margin, rng=chance)
            ground = grounds[effort.margin]
            result = _stage(ground, simulator, old, effort, plants, rng)
            best = (ground, result) if best is None or result.score < best[1].score else best
            record.append(
                Trial(
                    number=number,
                    loss=best[1].loss,
                    success=best[1].success,
                    seconds=time.monotonic() - began,
                )
            )
            if best[1].success >= SURE:
                break
        if best is None:
            raise SearchError(
                "it was given no stage to search in",
                where=f"planning again for {task.robot.name}",
                fix="give a stage, and one with fresh swings if there is no old policy",
            )
        return concluded(
            Problem(task=task, simulator=simulator),
            track_of(*best),
            tuple(record),
            seed=seed,
            what="the best plan",
            hint="the change may be beyond what its motors can do",
        )


def _stage(
    ground: SeedInputs,
    simulator: Simulator,
    old: Policy | None,
    effort: ReplanBudget,
    plants: Sequence[Plant],
    rng: np.random.Generator,
) -> Planned:
    """Return the best plan of one stage."""
    guesses = []
    if old is not None and effort.recalled:
        guesses.append(
            recalled(ground, simulator, old, rows=effort.recalled, keep=effort.keep, rng=rng)
        )
    if effort.rows:
        guesses.append(swung(ground, effort.rows, effort.keep, rng, share=effort.share))
        if ground.plant.model.nu >= ground.plant.model.nv:
            guesses.append(led(ground, effort.keep))
    plans = sifted(ground, joined(guesses), keep=effort.keep, most=effort.most)
    bodies = (ground.plant, *plants) if plants else ()
    return judged(ground, plans, runs=effort.runs, rng=rng, plants=bodies, kinds=effort.kinds)
