from __future__ import annotations

import numpy as np

from morph.policy_transfer.baselines.source import Source
from morph.policy_transfer.baselines.values import ahead, worth_of
from morph.search.plan.feedback import feedback
from morph.search.plan.terminal_controller import grounded
from morph.search.trajectory.ddp import Trajectories


def test_on_the_source_itself_they_give_back_its_plan_and_the_best_feedback(
    source: Source,
) -> None:
    task, worth = source.task, worth_of(source)
    ground = grounded(task, source.target.simulator, margin=0.0, rng=np.random.default_rng(0))
    plan = ahead(worth, ground.plant)
    # The run is the body's own, so that nothing has to be corrected but rounding.
    np.testing.assert_allclose(plan.command[0, :-1], worth.command, atol=1e-6)
    path = Trajectories(
        position=worth.position[None],
        velocity=worth.velocity[None],
        command=worth.command[None],
        cost=np.zeros(1),
    )
    # A step ahead by the true values is the Riccati recursion's own gain (Bellman).
    best = feedback(ground, path, 1.0)
    np.testing.assert_allclose(plan.gain[0, :-1], best[0], rtol=1e-6, atol=1e-8)
