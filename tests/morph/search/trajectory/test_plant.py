"""A body as optimal control sees it: what its slopes are taken of."""

from __future__ import annotations

import numpy as np

from morph.body.load import load
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator


def test_slopes_of_a_joint_that_friction_holds_are_those_of_it_sliding() -> None:
    # At rest under 1 N of dry friction a small push moves nothing: its slope would be 0. Sliding,
    # the cart of 0.5 kg with a pole of 0.5 kg hanging from it gains dv = dF dt / m at first, where
    # m lies between the cart's own mass and both together: 0.05 to 0.1 per s and N in 0.05 s.
    robot = load("cartpole")
    dry = CoulombFriction(joint="slide", c=1.0)
    plant = Plant(Simulator(robot, (dry,), step=0.01, integrator="rk4"), 0.05)
    still = np.zeros(2)
    _, B = linearise(plant, still, still, np.zeros(1))
    held = plant.advance(still[None], still[None], np.array([[0.1]]))[1]
    assert abs(held[0, 0]) < 1e-4
    assert 0.05 < B[2, 0] < 0.1


def test_a_body_without_dry_friction_is_its_own_slope() -> None:
    plant = Plant(Simulator(load("cartpole"), step=0.01, integrator="rk4"), 0.05)
    assert plant.sliding is plant
