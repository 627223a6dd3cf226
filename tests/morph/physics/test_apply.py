"""The order of effects does not matter."""

from __future__ import annotations

import itertools

import numpy as np

from morph.body.load import load
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.joint.armature import Armature
from morph.physics.world.ground import Ground
from morph.sim.simulator import Simulator


def test_effects_in_any_order_make_one_contact() -> None:
    effects: tuple[Effect, ...] = (
        ContactSoftness(contact="any+floor", stiffness=2000.0),
        Armature(joint="knee", J=0.05),
        AddedMass(body="foot", x=1.0, y=1.0, z=1.0),
        Ground(),
    )
    robot = load("hopper")
    made = [
        Simulator(robot, order, step=5e-4).model.pair_solref
        for order in itertools.permutations(effects)
    ]
    # The same sums, in the same order: the same numbers. A rotor and water make a contact heavier.
    assert all(np.array_equal(one, made[0]) for one in made)
    dry = Simulator(robot, (effects[0], effects[3]), step=5e-4).model.pair_solref
    assert np.all(np.abs(made[0][:, 0]) < np.abs(dry[:, 0]))
