"""Simulations of all bodies, computed once and shared by all sessions."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from morph.app.viewer.compare.body_show import Show, at_rest, performs, sweeps
from morph.app.viewer.compare.learned import LearnedPolicy, kept, learned
from morph.app.viewer.compare.match_policies import LEARNED, matched, task_of
from morph.app.viewer.compare.shared_work import Crew, Longer, Work
from morph.app.viewer.view_request import ViewRequest
from morph.body.robot import Robot
from morph.errors import ViewError
from morph.physics.worlds import world, world_names
from morph.task.task import Task
from morph.task.tasks import TASKS, check_name, task, tasks_of

HURRY = 1.5
"""s; where it takes longer to find out whether a body can do the task, the page says so."""


@dataclass(frozen=True, kw_only=True)
class Cast:
    """What is known of each body in one task, or will be."""

    tasks: tuple[Work[Task], ...]
    """Its task; nothing where no task is done."""
    shows: tuple[Work[Show], ...]
    """What is shown of it."""

    @property
    def done(self) -> int:
        """How many bodies are ready, or failed."""
        return sum(show.done for show in self.shows)

    @property
    def goals(self) -> tuple[str, ...]:
        """What the task asks of the bodies, as far as that is known."""
        known = [task.found for task in self.tasks if task.found is not None]
        return tuple(goal.name for task in known for goal in task.goals)


class Troupe:
    """The bodies that are compared.

    Args:
        given: What the viewer was given.

    Raises:
        PolicyError: A folder holds no policy that can be used.
        ViewError: A policy is of none of the bodies, or there is no task for it.
        TaskError: There is no such task, or no body can do it.
        EffectError: There is no such world.
    """

    def __init__(self, given: ViewRequest) -> None:
        """Check what was given; nothing is simulated yet."""
        self._given = given
        self.robots = given.robots
        self.names = named(given.robots)
        """What each body is called."""
        self._policies = matched(given.robots, given.policies)
        self._crew, self._lock = Crew(), threading.Lock()
        self._casts: dict[str | None, Cast] = {}
        self.task = given.task if given.task is not None else task_of(self._policies)
        """The task that is shown first; None for none."""
        if self.task is not None:
            check_name(self.task)
        elif LEARNED in given.policies:
            raise ViewError(
                "nothing says what is to be learned",
                where=f"--policy {LEARNED}",
                fix=f"say it by --task: {', '.join(self.tasks) or ', '.join(TASKS)}",
            )
        if given.world is not None and given.world not in world_names():
            world(given.world, given.robots[0])
        self.rest = tuple(map(at_rest, self.robots, self.names))
        """Every body as it is described."""
        if self.task is not None:
            self._check(self.task)

    @property
    def tasks(self) -> tuple[str, ...]:
        """The tasks that all bodies name on their cards, and the one that was asked for."""
        all_of = [set(tasks_of(robot)) for robot in self.robots]
        return tuple(
            name for name in TASKS if name == self.task or all(name in names for names in all_of)
        )

    def cast(self, name: str | None) -> Cast:
        """Return what is known of each body in a task; whoever asks first has it computed."""
        with self._lock:
            if name not in self._casts:
                self._casts[name] = self._asked(name)
            return self._casts[name]

    def _asked(self, name: str | None) -> Cast:
        ask, numbers = self._crew.ask, range(len(self.robots))
        if name is None:
            return Cast(tasks=(), shows=tuple(ask(partial(self._sweeps, at)) for at in numbers))
        # All tasks come before the first run: a task that nobody can do is told at once.
        tasks = tuple(ask(partial(self._made, name, at)) for at in numbers)
        shows = tuple(ask(partial(self._performs, tasks[at], at)) for at in numbers)
        return Cast(tasks=tasks, shows=shows)

    def _check(self, name: str) -> None:
        cast = self.cast(name)
        for each in cast.tasks:
            if not each.wait(HURRY) or each.error is None:
                return
        if cast.tasks and cast.tasks[0].error is not None:
            raise cast.tasks[0].error

    def _made(self, name: str, at: int, work: Work[Task]) -> Task:
        robot = self.robots[at]
        result = task(name, robot)
        if self._given.world is None:
            return result
        around = world(self._given.world, robot)
        return replace(result, world=around.name, effects=around.effects)

    def _sweeps(self, at: int, work: Work[Show]) -> Show:
        given = self._given
        return sweeps(
            self.robots[at], self.names[at], surroundings=given.world, seconds=given.seconds
        )

    def _performs(self, made: Work[Task], at: int, work: Work[Show]) -> Show | Longer[Show]:
        made.wait()
        if made.found is None:
            raise made.error or ViewError("it has no task", where=self.names[at], fix="name one")
        requested, own, given = made.found, self._policies[at], self._given
        show = partial(
            performs, requested, name=self.names[at], seed=given.seed, seconds=given.seconds
        )
        # A folder's policy is for the task that was asked for, whatever its file calls it.
        if own is not None and requested.name in (own.task, self.task):
            return show(own.policy, text=f"the policy in {own.folder}")
        if LEARNED not in given.policies:
            return show(None, text="no policy: every command is zero")
        before = kept(requested, given.seed)
        if before is not None:
            return show(before.policy, text=_said(before, "kept from an earlier search"))
        work.tell("looking for a policy")
        return Longer(job=partial(self._learns, requested, show))

    def _learns(self, wanted: Task, show: partial[Show], work: Work[Show]) -> Show:
        def told(text: str) -> None:
            self._crew.check()
            work.tell(f"looking for a policy by {text}")

        result = learned(wanted, self._given.seed, told)
        work.tell("simulating")
        return show(result.policy, said=_said(result, "just learned"))


def named(robots: Sequence[Robot]) -> tuple[str, ...]:
    """Return a name for each body; those that share one are numbered."""
    count, seen = Counter(robot.name for robot in robots), Counter[str]()
    names = []
    for robot in robots:
        seen[robot.name] += 1
        number = f" ({seen[robot.name]})" if count[robot.name] > 1 else ""
        names.append(f"{robot.name}{number}")
    return tuple(names)


def _said(result: LearnedPolicy, when: str) -> str:
    doubt = "" if result.succeeded else ", which did not succeed"
    return f"a policy by {result.search}{doubt} ({when})"
