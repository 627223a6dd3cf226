"""Along random tosses: no force at a distance, no adhesion, friction inside its cone."""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.restitution import Restitution
from morph.physics.effect import Effect
from morph.physics.world.ground import Ground
from morph.sim.simulator import Simulator

FLOOR = "any+floor"
MU = 0.4
CORNERS = np.array(list(product((-0.1, 0.1), (-0.1, 0.1), (-0.05, 0.05))))

FLOORS: dict[str, tuple[Effect, ...]] = {
    "as described": (),
    "soft": (ContactSoftness(contact=FLOOR, stiffness=5000.0, damping=50.0),),
    "bouncy": (Restitution(contact=FLOOR, e=0.7),),
}


def lowest(position: Array) -> float:
    """Return the height of the lowest corner, by the rotation that a quaternion is."""
    w, x, y, z = position[3:7]
    up = np.array([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)])
    return float(position[2] + (CORNERS @ up).min())


@pytest.mark.parametrize("pyramid", [0.0, 1.0])
@pytest.mark.parametrize("floor", FLOORS)
def test_forces_are_those_of_a_contact(block: Robot, floor: str, pyramid: float) -> None:
    effects = (Ground(), ContactFriction(contact=FLOOR, mu=MU, pyramid=pyramid), *FLOORS[floor])
    model = Simulator(block, effects).model
    data, force, rng = mujoco.MjData(model), np.zeros(6), np.random.default_rng(7)
    touched = flown = slid = 0
    for _ in range(6):
        mujoco.mj_resetData(model, data)
        data.qpos[2], data.qpos[3:7] = 0.3, rng.standard_normal(4)
        data.qvel[:] = rng.standard_normal(6) * [1.0, 1.0, 1.0, 5.0, 5.0, 5.0]
        mujoco.mj_normalizeQuat(model, data.qpos)
        for _ in range(400):
            mujoco.mj_step(model, data)
            mujoco.mj_forward(model, data)
            if lowest(data.qpos) > 0.0:
                flown += 1
                assert not data.qfrc_constraint.any()
                # Free flight: g and nothing else, to rounding.
                assert np.abs(data.qacc[:3] - [0.0, 0.0, -9.81]).max() < 1e-12
            for index in range(data.ncon):
                mujoco.mj_contactForce(model, data, index, force)
                normal, sideways = force[0], np.abs(force[1:3])
                assert data.contact[index].dist <= 0.0
                assert normal >= 0.0
                used = sideways.sum() if pyramid else np.hypot(*sideways)
                # The solver projects on the cone: what is outside it is rounding.
                assert used <= MU * normal * (1.0 + 1e-9) + 1e-12
                touched += 1
                slid += used > 0.999 * MU * normal > 0.0
    assert min(touched, flown, slid) > 100
