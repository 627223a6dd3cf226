"""Whether the model by which a policy was made is good enough for the target."""

from __future__ import annotations

import numpy as np

from morph.model.hypothesis import Hypothesis
from morph.model.kwik.certify import ModelVerdict, judge
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns
from morph.policy_transfer.repair import TaskModel, noise_of
from morph.sim.threads import one_thread
from morph.task.task import Task

DELTA = 0.05
"""How often a verdict may be wrong."""


def gated(
    model: TaskModel, run: Run, task: Task, *, seed: int, delta: float = DELTA
) -> ModelVerdict:
    """Return whether a model is good enough for what the target did in a run.

    The run must be one that the model was not fitted to.

    Source: Gamboa Higuera 2015, section 3.4.

    Raises:
        DiagnosisError: The body floats, or the run is not on the task's clock.
    """
    simulator = model.simulator
    hypothesis = Hypothesis(
        robot=model.task.robot,
        step=simulator.step,
        knobs=unknowns(model.task.robot),
        effects=simulator.effects,
    )
    with one_thread():
        return judge(
            hypothesis,
            [run],
            noise_of(task, simulator),
            integrator=simulator.integrator,
            delta=delta,
            rng=np.random.default_rng([seed, 3]),
        )
