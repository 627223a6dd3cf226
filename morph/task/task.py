"""A task: where a body begins, for how long, what costs, and what counts as success."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field

import numpy as np

from morph.arrays import Array, Mask
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.files import sha256
from morph.physics.effect import Effect
from morph.sim.integrator import Integrator
from morph.sim.simulator import Simulator
from morph.task.moved import Moved
from morph.task.start import Start
from morph.task.term import Goal, Term

MOST_SAMPLES = 100_000
"""Most control steps of a run."""

UNSTABLE = 1e9
"""Cost of a run in which the simulation became unstable: more than a full push all along costs."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a body is to do.

    A policy pi is sought that makes the expected long-term cost least,

        J(pi) = sum over t = 0..T of E[c(x_t, u_t)],  x_{t+1} = f(x_t, u_t) + w,  u_t = pi(x_t, t),

    where c is the sum of the terms and x_0 is drawn from the start.

    Source: Gamboa Higuera 2015, eq. 1.

    Raises:
        TaskError: A time is out of range, or a term or goal does not fit its quantity.
        RobotError: The body lacks a part that a term or goal names.
    """

    name: str
    """What it is called: `swing-up`."""
    robot: Robot
    """The body."""
    terms: tuple[Term, ...]
    """What costs."""
    goals: tuple[Goal, ...]
    """What must be reached, all of it."""
    start: Start = field(default_factory=Start)
    """Where runs begin."""
    horizon: float = 3.0
    """How long a run is, s."""
    period: float = 0.05
    """How long each command is held, s."""
    step: float = 0.005
    """Step of the simulation, s; the period is a multiple of it."""
    integrator: Integrator | None = None
    """What the simulation steps with; None for the simulator's own choice."""
    noise: float = 0.01
    """Standard deviation of every observation, in its unit."""
    world: str | None = None
    """The named world in which it is done."""
    effects: tuple[Effect, ...] = ()
    """What acts on the body beyond its description, that world's effects among it."""
    observes: tuple[str, ...] | None = None
    """The channels that a policy may see; None for every joint and floating body."""

    def __post_init__(self) -> None:
        """Check that times fit, and that terms and goals can be asked of this body."""
        if not self.robot.actuators:
            self._refuse("the body has no actuator", "give it a motor or a servo")
        if not (math.isfinite(self.noise) and self.noise >= 0.0):
            self._refuse(f"its noise {self.noise:g} is none", "give 0 or more")
        multiple = self.period / self.step if self.step > 0.0 else 0.0
        if not (multiple >= 1.0 and abs(multiple - round(multiple)) < 1e-6):
            self._refuse(
                f"its control period {self.period:g} s is no multiple of its step {self.step:g} s",
                "give a period of one step or more",
            )
        periods = self.horizon / self.period
        if not 0.5 < periods < MOST_SAMPLES or abs(periods - round(periods)) > 1e-6:
            self._refuse(
                f"its horizon {self.horizon:g} s is not 1 to {MOST_SAMPLES - 1} "
                f"control periods of {self.period:g} s",
                "give a horizon that is a multiple of the period",
            )
        for kind, named in (("term", self.terms), ("goal", self.goals)):
            names = [each.name for each in named]
            if not names or len(set(names)) < len(names):
                self._refuse(
                    f"its {kind}s are {', '.join(names) or 'none'}",
                    f"give a {kind} or more, each with a name of its own",
                )
        parts = {joint.name for joint in self.robot.joints} | {x.name for x in self.robot.links}
        for name in (*self.start.position, *self.start.speed):
            if name.partition(".")[0] not in parts:
                self._refuse(f"its start names {name!r}", "name joints and floating links of it")
        self._check_sizes()

    def _check_sizes(self) -> None:
        parts: tuple[Term | Goal, ...] = (*self.terms, *self.goals)
        for requested in parts:
            size = requested.quantity.size(self.robot)
            if size != len(requested.target):
                self._refuse(
                    f"{requested.name!r} has {len(requested.target)} targets, "
                    f"and {requested.quantity.name} has {size} numbers",
                    "give one target for each number",
                )

    def _refuse(self, what: str, fix: str) -> None:
        raise TaskError(what, where=f"task {self.name} of {self.robot.name}", fix=fix)

    @property
    def samples(self) -> int:
        """How many control times a run has, the first and the last included."""
        return round(self.horizon / self.period) + 1

    @property
    def sha256(self) -> str:
        """Hash of all that defines it but the body, which has a hash of its own."""
        document = {key: repr(value) for key, value in vars(self).items() if key != "robot"}
        return sha256(json.dumps(document, sort_keys=True))

    def simulator(self, effects: tuple[Effect, ...] = ()) -> Simulator:
        """Return the body in the world of the task, under further effects if given."""
        all_effects = (*self.effects, *effects)
        return Simulator(self.robot, all_effects, step=self.step, integrator=self.integrator)

    def costs(self, moved: Moved) -> dict[str, Array]:
        """Return what each term costs at each sample, (..., samples), by its name."""
        return {term.name: term.cost(moved) for term in self.terms}

    def loss(self, moved: Moved) -> Array:
        """Return the cost of each run over all its samples, shape (...,).

        A run that became unstable costs `UNSTABLE`, whatever else it shows.

        Raises:
            TaskError: A cost is no number.
        """
        total = np.zeros(moved.position.shape[:-1])
        for name, cost in self.costs(moved).items():
            if not np.isfinite(cost).all():
                self._refuse(
                    f"term {name!r} is no number in {int((~np.isfinite(cost)).sum())} samples",
                    "check the states that it was given, and the quantity of this term",
                )
            total += cost
        loss = total.sum(axis=-1)
        return np.asarray(loss if moved.stable is None else np.where(moved.stable, loss, UNSTABLE))

    def succeeded(self, moved: Moved) -> Mask:
        """Return which runs reach every goal, shape (...,); one that is unstable never does."""
        stable = moved.stable
        reached = (
            np.ones(moved.position.shape[:-2], dtype=bool) if stable is None else stable.copy()
        )
        for goal in self.goals:
            reached &= goal.reached(moved)
        return reached

    def said(self) -> dict[str, object]:
        """Return the task as plain data, for files and pages."""
        return {
            "name": self.name,
            "robot": self.robot.name,
            "horizon_s": self.horizon,
            "period_s": self.period,
            "noise": self.noise,
            "world": self.world,
            "terms": [_said(term) for term in self.terms],
            "goals": [_said(goal) for goal in self.goals],
            "sha256": self.sha256,
        }


def _said(part: Term | Goal) -> dict[str, object]:
    document = {
        key: None if value == math.inf else value
        for key, value in vars(part).items()
        if key != "quantity"
    }
    return {**document, "quantity": {"kind": part.quantity.name, **asdict(part.quantity)}}
