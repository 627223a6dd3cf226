"""Forces of contact that are as large as they must be: legs that stand, by Newton's law alone."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.contact import by_contact, contact_along
from morph.inference.diagnose import diagnose
from morph.inference.observed import observed
from morph.model.episodes import episode
from morph.record.recording import Channel, Recording

GRAVITY, TRUNK, LOAD = 9.81, 2.0, 0.8
"""m/s2; the trunk as described and what it carries, kg."""
LEGS = f"""
<mujoco model="legs"><worldbody>
 <geom name="floor" type="plane" size="0 0 1" solref="0.004 1"/>
 <body name="trunk" pos="0 0 0.5"><joint name="rail" type="slide" axis="0 0 1"/>
  <inertial pos="0 0 0" mass="{TRUNK}" diaginertia="0.01 0.01 0.01"/>
  <body name="left_foot" pos="0 0.1 -0.45"><joint name="left" type="slide" axis="0 0 -1"/>
   <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
   <geom type="sphere" size="0.05" solref="0.004 1"/></body>
  <body name="right_foot" pos="0 -0.1 -0.45"><joint name="right" type="slide" axis="0 0 -1"/>
   <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
   <geom type="sphere" size="0.05" solref="0.004 1"/></body></body></worldbody>
 <actuator><motor name="push_left" joint="left"/><motor name="push_right" joint="right"/></actuator>
</mujoco>
"""
TUMBLING = """
<mujoco><compiler angle="radian"/><worldbody><geom name="floor" type="plane" size="0 0 1"/>
 <body name="trunk"><freejoint/><geom type="box" size="0.2 0.1 0.05" mass="3"/>
  <body name="arm" pos="0.2 0 0"><joint name="elbow" axis="0 1 0" range="-1 1" limited="true"/>
   <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.5"/></body></body>
 </worldbody></mujoco>
"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("legs") / "legs.xml"
    path.write_text(LEGS)
    return load(path)


def stood(number: int, load: float) -> Recording:
    """Return a run in which the feet stand and the trunk goes up and down, (m + M) (z'' + g) = F.

    The feet do not move, as their legs grow as the trunk rises, and each bears a share of the
    trunk that changes. By its softness the floor gives way by 0.08 mm under 10 N.
    """
    rng, time = np.random.default_rng(number), np.arange(0.0, 4.0, 0.005)
    height, rising = np.zeros_like(time), np.zeros_like(time)
    for _ in range(3):
        rate, phase = 2.0 * np.pi * rng.uniform(0.3, 1.5), rng.uniform(0.0, 2.0 * np.pi)
        wide = 0.02 * np.sin(rate * time + phase)
        height, rising = height + wide, rising - rate**2 * wide
    share = 0.5 + 0.3 * np.sin(2.0 * np.pi * rng.uniform(0.2, 0.8) * time)
    forces = (TRUNK + load) * (rising + GRAVITY) * np.stack([share, 1.0 - share])

    def read(value: np.ndarray, noise: float) -> Channel:
        return Channel(time=time, value=value + noise * rng.normal(size=len(time)))

    # A command is held until the next: by half a period it is late.
    late = forces + 0.0025 * np.gradient(forces, time, axis=1)
    return Recording(
        name=f"run_{number}",
        channels={
            "rail.position": read(height, 1e-4),
            "left.position": read(height, 1e-4),
            "right.position": read(height, 1e-4),
            "push_left.command": read(late[0], 0.0),
            "push_right.command": read(late[1], 0.0),
        },
    )


def test_a_load_is_told_where_only_the_floor_carries_it(robot: Robot) -> None:
    found = diagnose(robot, [stood(number, LOAD) for number in range(4)])
    first = found.findings[0]
    # On a rail a load and a greater mass of the trunk are the same.
    loads = {
        "payload": lambda: first.parameters["m"],
        "link_inertia": lambda: first.parameters["mass"],
    }
    assert first.effect.where == "trunk"
    assert first.effect.name in loads
    assert found.held_out_rmse["corrected"]["rail.position"] < (
        0.1 * found.held_out_rmse["nominal"]["rail.position"]
    )


def test_legs_that_stand_as_described_is_consistent(robot: Robot) -> None:
    found = diagnose(robot, [stood(number, 0.0) for number in range(4)])
    assert (found.findings, found.verdict) == ((), "consistent")


def test_nothing_that_a_model_says_moves_feet_that_stand(robot: Robot) -> None:
    model = spec_of(robot).compile()
    about = observed(model, robot, episode(stood(0, 0.0), robot, 0.005)).about
    feet = about.contact.rows @ about.tangent.jacobian
    assert about.contact.rows.any(axis=(1, 2)).all()
    # By positions, velocities and forces of the three joints: rounding of accelerations that are
    # up to 1 / 0.1 kg, and by the feet's own acceleration that of each.
    assert np.abs(feet[:, :, :9]).max() < 1e-9
    assert np.allclose(np.trace(feet[:, :, 9:], axis1=1, axis2=2), 2.0)
    # Each leg alone, and the rail, take the force that moves the trunk: to 1e-6 of it, as readings
    # let the feet move a little.
    assert about.inertial == pytest.approx(np.full(3, about.inertial[0]), rel=1e-4)


def test_points_in_contact_move_as_told_and_do_no_work_on_the_rest() -> None:
    model = mujoco.MjModel.from_xml_string(TUMBLING)
    data = mujoco.MjData(model)
    position = np.tile(np.r_[0.0, 0.0, 0.05, 1.0, 0.0, 0.0, 0.0, -0.3], (4, 1))
    position[0, 2] = 0.3  # In the air.
    position[2] = [0.0, 0.0, 0.085, np.cos(0.2), np.sin(0.2), 0.0, 0.0, -0.3]  # On an edge.
    position[3, [2, 7]] = 0.3, 0.999  # In the air, the elbow at its end.
    masses = []
    for at in position:
        data.qpos[:] = at
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        masses.append(mass)
    # Impacts happen between two samples: what touches in one counts in its neighbours too.
    falling = np.zeros((12, model.nv))
    falling[:, 2] = -2.0
    shown = np.repeat(position, 3, axis=0)
    # Where smoothed positions round off a knock, those that were read tell of it, and by noise the
    # others do.
    high = shown + np.r_[0.0, 0.0, 1.0, np.zeros(5)]
    whole = contact_along(model, shown, high, falling, 0.02)
    other = contact_along(model, high, shown, falling, 0.02)
    assert np.allclose(other.impact, whole.impact, rtol=1e-9)
    assert [np.linalg.matrix_rank(each, tol=1e-9) for each in whole.rows[1:4]] == [0, 6, 6]
    # The trunk loses 2 m/s within 50 ms, while the arm may go on about its elbow, from the third
    # sample on, a neighbour of the first that touches: in a step of 20 ms the root of 2/5 of it.
    borne = masses[1][2, 2] - masses[1][2, 6] ** 2 / masses[1][6, 6]
    assert whole.impact[1] == 0.0
    assert whole.impact[2] == pytest.approx(np.sqrt(0.4 * borne) * 2.0, rel=1e-6)
    rows = whole.rows[1::3]
    mobility = np.linalg.inv(np.array(masses))
    contact = by_contact(rows, mobility)
    for at in range(4):
        moves = rows[at] @ contact[at]
        kept = np.linalg.matrix_rank(rows[at], tol=1e-9)
        assert kept == (0, 6, 5, 1)[at]
        # Half of their squares is kinetic energy: of a velocity that contact would stop, all of it.
        stopped = mobility[at] @ rows[at].T
        energy = np.einsum("ij,ik,kj->j", stopped, masses[at], stopped)
        assert np.allclose(((rows[at] @ stopped) ** 2).sum(axis=0), energy, rtol=1e-9)
        # They are changed by one, and what no force of contact reaches is not, in the
        # metric of the inertia: N' M A = 0 for all velocities N that leave the points where they
        # are.
        assert np.allclose(moves @ moves, moves, atol=1e-9)
        assert np.trace(moves) == pytest.approx(kept, abs=1e-9)
        idle = np.linalg.svd(rows[at])[2][kept:] if kept < model.nv else np.zeros((0, model.nv))
        assert np.allclose(idle @ masses[at] @ contact[at], 0.0, atol=1e-9)
