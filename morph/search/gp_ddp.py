"""Learning from trials alone: a model of the body, plans in it, and the one that promises most."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.jointed.fit import fit
from morph.search.learned_dynamics.learned_body import HINGE, Dream, known, settings_of
from morph.search.learned_dynamics.memory import FARTHEST, SearchCheckpoint, recalled
from morph.search.learned_dynamics.plans import Chosen, TrialBudget, chosen, plans
from morph.search.search import Learned, Problem, Search, State, Told, ignore

MOST_RANDOM = 4
"""Most trials with random commands: as long as they spin a joint, ever weaker ones follow."""

WEAKER = 0.3
"""By what factor."""

WILD = 0.2
"""Share of control periods in which they may."""

TRIALS = 4
"""Trials of policies, if nothing else is said."""


@dataclass(frozen=True, kw_only=True)
class LearnedPlans(Search):
    """Differential dynamic programming in a body that is learned from trials alone.

    First a trial with random commands. After each trial accelerations are learned as Gaussian
    processes (`morph.model.jointed`); bang-bang swings and differential dynamic programming give
    plans in their mean, each with feedback; every plan is tried in closed loop, with noise, in
    hundreds of bodies that the data allow; and the one that does best on average is tried on the
    robot. What is told of the body is which joints turn, the bounds of its commands, and where
    its links are in a posture, as the cost asks; nothing of masses, friction or gravity.

    The search ends early when a plan that succeeded still promises more than every new one.
    """

    name: ClassVar[str] = "gp-ddp"
    from_trials: ClassVar[bool] = True

    hold: float = 0.2
    """How long each random command of the first trial is held, s: long enough to swing."""
    strength: float = 1.0
    """Share of the bounds within which they are drawn, at first."""
    lawful: bool = True
    """Whether accelerations are known to be quadratic in velocities and affine in commands, as
    those of joints without dry friction, stops or fluid are; what is not is learned beside it."""
    slides: bool = False
    """Whether it matters where slides are: springs, or rails that end."""
    effort: TrialBudget = field(default_factory=TrialBudget)
    """How much is computed for each trial."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if not (self.hold > 0.0 and 0.0 < self.strength <= 1.0):
            raise SearchError(
                f"random commands of {self.strength:g} of the bounds are held for {self.hold:g} s",
                where=f"search {self.name}",
                fix="give a share above 0 and at most 1, and a time above 0 s",
            )

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the policy that promises most after so many trials on the target.

        Raises:
            SearchError: There is nothing to make trials on, the body floats or has commands
                without bounds, or the trials show too little.
        """
        task, target = problem.task, problem.trials
        most = TRIALS if trials is None else trials
        if most < 1:
            raise SearchError(
                f"it is given {most} trials",
                where=f"search {self.name} on {task.name} of {task.robot.name}",
                fix="give one trial or more",
            )
        model, bounds = known(task)
        memory = SearchCheckpoint() if state is None else recalled(state)
        begun = time.perf_counter() - memory.seconds
        while not memory.experience or (memory.tried is None and self._wild(memory, model)):
            rng = np.random.default_rng((seed, 0, memory.begun))
            share = self.strength * WEAKER**memory.begun
            shown = target.trial(share * self._random(problem, bounds, rng), rng)
            note = f"random commands within {share:g} of their bounds"
            memory = memory.after(shown, None, time.perf_counter() - begun, note)
            progress(memory.lines[-1], memory.state())
        while len(memory.experience) - memory.begun < most:
            rng = np.random.default_rng((seed, 1, len(memory.experience)))
            memory, best = self._best(problem, model, bounds, memory, rng, anew=True)
            if best.tried is not None and memory.experience[best.tried + memory.begun].success:
                break
            shown = target.trial(best.plans.track(0, task), rng)
            note = f"foreseen: loss {best.loss:.3g}, success {best.success:.2f}"
            memory = memory.after(shown, best.plans, time.perf_counter() - begun, note)
            progress(memory.lines[-1], memory.state())
        rng = np.random.default_rng((seed, 2))
        _, best = self._best(problem, model, bounds, memory, rng, anew=False)
        return self._learned(problem, memory, best)

    def _wild(self, memory: SearchCheckpoint, model: Any) -> bool:
        """Return whether the last random commands spun the body too fast to learn much from."""
        turns = model.jnt_type == HINGE
        steps = np.abs(np.diff(memory.experience[-1].position, axis=0))[:, turns]
        wild = steps.max(axis=1, initial=0.0) > FARTHEST
        return memory.begun < MOST_RANDOM and float(wild.mean()) > WILD

    def _random(
        self, problem: Problem, bounds: tuple[Array, Array], rng: np.random.Generator
    ) -> Array:
        """Return random commands, each held for a while, shape (periods, nu)."""
        task = problem.task
        periods, held = task.samples - 1, max(1, round(self.hold / task.period))
        drawn = rng.uniform(*bounds, size=(-(-periods // held), len(bounds[0])))
        return np.repeat(drawn, held, axis=0)[:periods]

    def _best(
        self,
        problem: Problem,
        model: Any,
        bounds: tuple[Array, Array],
        memory: SearchCheckpoint,
        rng: np.random.Generator,
        *,
        anew: bool,
    ) -> tuple[SearchCheckpoint, Chosen]:
        """Return what promises most by all that was seen, of new plans too if they are wanted."""
        task = problem.task
        settings = settings_of(model, bounds, slides=self.slides, lawful=self.lawful)
        try:
            data = memory.periods(settings.turning, task.period, settings.names)
            learned = fit(data, settings, memory.logs)
        except SearchError as error:
            # Whoever gave a task has no periods to mend: told is what can be asked for instead.
            raise SearchError(
                f"trials show too little to learn from: {error.what}",
                where=f"search {self.name} on {task.name} of {task.robot.name}",
                fix="take another seed, or a search that works in a simulator, such as ddp",
            ) from error
        dream = Dream(task, model, bounds, learned)
        new = plans(task, dream, self.effort, rng) if anew else None
        noise = np.concatenate(
            [data.position_noise(learned.velocity_noise), learned.velocity_noise]
        )
        best = chosen(task, dream, new, memory.tried, noise, self.effort, rng)
        return replace(memory, logs=learned.logs.numpy()), best

    def _learned(self, problem: Problem, memory: SearchCheckpoint, best: Chosen) -> Learned:
        number = best.tried or 0
        succeeded = memory.experience[number + memory.begun].success
        tried = len(memory.experience) - memory.begun
        why = (
            f"in trial {number + 1}, the best of {tried}, it missed a goal; by "
            f"all that was seen it should reach them in {100.0 * best.success:.0f} of 100 runs"
        )
        return Learned(
            policy=best.plans.track(0, problem.task),
            trials=memory.lines,
            succeeded=succeeded,
            why="" if succeeded else why,
            experience=memory.experience,
        )
