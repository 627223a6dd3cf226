from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.sim.rollout import Variant, rollout
from morph.sim.simulator import compiled


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("double_pendulum")


def held_by_mujoco(row: int) -> tuple[Effect, ...]:
    return (
        ViscousFriction(joint="elbow", b=0.01 * row),
        CoulombFriction(joint="shoulder", c=0.05 * (1 + row)),
        TorqueScale(actuator="elbow", gain=1.0 - 0.1 * row),
    )


def stepped(row: int) -> tuple[Effect, ...]:
    return (
        StribeckFriction(joint="elbow", c=0.01 * row, s=0.05 + 0.02 * row, vs=0.1 * (1 + row)),
        ViscousFriction(joint="shoulder", b=0.02 * row),
        StribeckFriction(joint="shoulder", c=0.03, s=0.05 * row, vs=0.3),
    )


def starts(rows: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(0)
    position, velocity = rng.uniform(-1.0, 1.0, (2, rows, 2))
    return position, velocity, rng.normal(size=(rows, 300, 2))


@pytest.mark.parametrize("threads", ["1", "2"])
@pytest.mark.parametrize("effects", [held_by_mujoco, stepped])
def test_each_row_is_bit_for_bit_the_run_alone(
    robot: Robot, effects: object, threads: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    assert callable(effects)
    variants = [compiled(spec_of(robot), effects(row), robot) for row in range(4)]
    # Rows out of order, one variant twice, one not at all.
    which = np.array([3, 0, 1, 3, 0, 1])
    position, velocity, command = starts(len(which))
    q, v = rollout(variants, which, position, velocity, command)
    assert q.shape == v.shape == (6, 301, 2)
    for row, index in enumerate(which):
        one = slice(row, row + 1)
        alone = rollout(
            [variants[index]], np.zeros(1, dtype=int), position[one], velocity[one], command[one]
        )
        assert np.array_equal(q[row], alone[0][0])
        assert np.array_equal(v[row], alone[1][0])
    # Rows 0 and 3 share a variant but not a start: they differ all the same.
    assert not np.array_equal(q[0], q[3])


def test_a_rollout_begins_with_its_start(robot: Robot) -> None:
    variant = Variant(model=spec_of(robot).compile(), effects=())
    position, velocity, command = starts(3)
    q, v = rollout([variant], np.zeros(3, dtype=int), position, velocity, command)
    assert np.array_equal(q[:, 0], position)
    assert np.array_equal(v[:, 0], velocity)
    # A leapfrog moves positions by the new velocity: q1 = q0 + h v1, to roundoff.
    assert q[:, 1] == pytest.approx(q[:, 0] + 0.002 * v[:, 1], abs=1e-15)


def test_the_same_rollout_twice_is_the_same(robot: Robot) -> None:
    variants = [compiled(spec_of(robot), stepped(row), robot) for row in range(2)]
    position, velocity, command = starts(2)
    once = rollout(variants, np.arange(2), position, velocity, command)
    again = rollout(variants, np.arange(2), position, velocity, command)
    assert np.array_equal(once[0], again[0])
    assert np.array_equal(once[1], again[1])
