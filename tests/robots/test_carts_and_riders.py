"""Carts and riders of the shelf against equations written out by hand.

A planar chain in absolute angles (Goldstein, Classical Mechanics, section 1.6; Spong,
Robot Modeling and Control, chapter 7): link i leans by t_i, its centre of mass lies c_i
from its joint, and what it carries hangs l_i from there. With a_i = m_i c_i + l_i * (mass
beyond i), for a chain that hangs (s = 1) or stands (s = -1):

    M_00 = sum of masses,  M_0i = a_i cos t_i,  M_ij = l_i a_j cos(t_i - t_j) for i < j,
    M_ii = I_i + m_i c_i^2 + l_i^2 * (mass beyond i),
    h_0 = -sum a_i sin(t_i) w_i^2,  h_i = sum_j M'_ij sin(t_i - t_j) w_j^2 + s g a_i sin t_i,

where M'_ij is M_ij without its cosine. Joint angles q are the steps between the t, so
t = T q, the joint-space inertia is T' M T and the bias T' h.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of

H = 0.84
"""Stature of the riders, m."""

BOARD = 1.9 + 2 * 0.0145 * 3 + 4 * 0.1 / 2
"""Board, two feet, and what four rolling wheels add, kg."""


@dataclass(frozen=True, kw_only=True)
class Chain:
    """A chain on a cart, as its card states it."""

    m: Array
    """Mass of each link, kg."""
    c: Array
    """From its joint to its centre of mass, m; below zero if it hangs from a standing chain."""
    length: Array
    """From its joint to the next one, m."""
    inertia: Array
    """About its centre of mass, kg m2."""
    cart: float
    """What slides, kg."""
    g: float
    """Gravity, m/s2."""
    s: float
    """1 for a chain that hangs, -1 for one that stands."""
    damping: float = 0.0
    """Of the slide, N s/m."""
    last: float = 1.0
    """-1 where the last joint turns the other way."""

    def equations(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the joint-space inertia and the bias, by the formulas above."""
        n = len(self.m)
        T = np.eye(n + 1)
        T[1:, 1:] = np.tril(np.ones((n, n)))
        T[-1, -1] = self.last
        t, w = (T @ q)[1:], (T @ v)[1:]
        beyond = np.array([self.m[i + 1 :].sum() for i in range(n)])
        a = self.m * self.c + self.length * beyond
        bare = np.diag(self.inertia + self.m * self.c**2 + self.length**2 * beyond)
        for i in range(n):
            for j in range(i + 1, n):
                bare[i, j] = bare[j, i] = self.length[i] * a[j]
        M = np.zeros((n + 1, n + 1))
        M[0, 0] = self.cart + self.m.sum()
        M[0, 1:] = M[1:, 0] = a * np.cos(t)
        M[1:, 1:] = bare * np.cos(t[:, None] - t[None, :])
        h = np.zeros(n + 1)
        h[0] = -(a * np.sin(t)) @ w**2
        h[1:] = (bare * np.sin(t[:, None] - t[None, :])) @ w**2 + self.s * self.g * a * np.sin(t)
        return T.T @ M @ T, T.T @ h


def cart(n: int) -> Chain:
    """Return the cart with n uniform rods: I = m l^2 / 12."""
    m, length = np.full(n, 0.5), np.full(n, 0.6 if n == 2 else 0.5)
    inertia = m * length**2 / 12
    return Chain(
        m=m, c=length / 2, length=length, inertia=inertia, cart=0.5, g=9.82, s=1.0, damping=0.1
    )


# Uniform boxes of a person of 3 kg, left and right together: mass, from, to and depth
# (Winter 2009, table 4.1 and figure 4.1; depths as in the cards).
BOXES = {
    "shanks": [(2 * 0.0465 * 3, 0.039 * H, 0.285 * H, 0.05)],
    "thighs": [(2 * 0.100 * 3, 0.285 * H, 0.530 * H, 0.06)],
    "pelvis": [(0.142 * 3, 0.530 * H, 0.6137 * H, 0.08)],
    "trunk": [(0.355 * 3, 0.6137 * H, 0.818 * H, 0.08), (0.081 * 3, 0.818 * H, H, 0.10)],
    "arms": [(2 * 0.050 * 3, 0.378 * H, 0.818 * H, 0.035)],
}

JOINTS = {"shanks": 0.039, "thighs": 0.285, "pelvis": 0.530, "trunk": 0.6137, "arms": 0.818}
"""Height of the joint below each, in statures."""

RIDERS = {
    "rigid": (("shanks", "thighs", "pelvis", "trunk", "arms"),),
    "two_links": (("shanks", "thighs"), ("pelvis", "trunk", "arms")),
    "three_links": (("shanks",), ("thighs",), ("pelvis", "trunk", "arms")),
    "five_links": (("shanks",), ("thighs",), ("pelvis",), ("trunk",), ("arms",)),
}
"""What is one link in each rider."""


def rider(name: str) -> Chain:
    """Return a rider: boxes of mass m, height b and depth d have I = m (b^2 + d^2) / 12."""
    m, c, length, inertia = [], [], [], []
    heights = [JOINTS[parts[0]] * H for parts in RIDERS[name]]
    for i, parts in enumerate(RIDERS[name]):
        boxes = np.array([box for part in parts for box in BOXES[part]])
        mass, middle = boxes[:, 0], (boxes[:, 1] + boxes[:, 2]) / 2
        centre = mass @ middle / mass.sum()
        own = mass * ((boxes[:, 2] - boxes[:, 1]) ** 2 + boxes[:, 3] ** 2) / 12
        inertia.append((own + mass * (middle - centre) ** 2).sum())
        m.append(mass.sum())
        c.append(centre - heights[i])
        length.append(heights[i + 1] - heights[i] if i + 1 < len(heights) else 0.0)
    return Chain(
        m=np.array(m),
        c=np.array(c),
        length=np.array(length),
        inertia=np.array(inertia),
        cart=BOARD,
        g=9.81,
        s=-1.0,
        last=-1.0 if name == "five_links" else 1.0,
    )


CHAINS = {
    f"cart_{word}_links{servo}": cart(n)
    for word, n in (("two", 2), ("three", 3), ("five", 5))
    for servo in ("", "_servo")
} | {f"rider_{name}_{board}": rider(name) for name in RIDERS for board in ("driven", "passive")}


def model_of(name: str, *, timestep: float = 0.002) -> Any:
    """Return a body of the shelf compiled."""
    return spec_of(load(name), timestep=timestep).compile()


def inertia_of(model: Any, data: Any) -> Array:
    """Return MuJoCo's joint-space inertia."""
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


@pytest.mark.parametrize("name", CHAINS)
def test_inertia_and_bias_are_those_of_the_textbook(name: str) -> None:
    model, chain = model_of(name), CHAINS[name]
    data, rng = mujoco.MjData(model), np.random.default_rng(5)
    for _ in range(10):
        data.qpos[:], data.qvel[:] = rng.normal(size=(2, model.nq))
        mujoco.mj_forward(model, data)
        M, h = chain.equations(data.qpos, data.qvel)
        # Entries are up to 10 kg m2 and 200 N m: rounding is 1e-13, and no figure of a card
        # may be off by more than its last digit.
        assert np.abs(inertia_of(model, data) - M).max() < 1e-11
        assert np.abs(data.qfrc_bias - h).max() < 1e-11


@pytest.mark.parametrize("name", CHAINS)
def test_it_swings_as_the_textbooks_equations_do(name: str) -> None:
    model, chain = model_of(name, timestep=0.0005), CHAINS[name]
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    # The equations know no stops and no motors.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    data = mujoco.MjData(model)
    data.qpos[1:] = 0.3
    start = np.concatenate([data.qpos, data.qvel])

    def slope(_: float, state: Array) -> Array:
        q, v = np.split(state, 2)
        M, h = chain.equations(q, v)
        h[0] += chain.damping * v[0]
        return np.concatenate([v, np.linalg.solve(M, -h)])

    end = scipy.integrate.solve_ivp(slope, (0.0, 0.3), start, rtol=1e-11, atol=1e-13).y[:, -1]
    mujoco.mj_step(model, data, 600)
    # Runge-Kutta errs by (rate * step)^4 a radian: no link turns faster than 13 rad/s, so
    # (13 * 0.0005)^4 = 2e-9 in angles, and 13 times that in rates.
    reached = np.concatenate([data.qpos, data.qvel])
    assert np.abs(reached - end)[: model.nq].max() < 1e-8
    assert np.abs(reached - end)[model.nq :].max() < 1e-7


@pytest.mark.parametrize("words", ["two", "three", "five"])
def test_a_hanging_chain_has_the_textbooks_frequencies(words: str) -> None:
    name = f"cart_{words}_links"
    model, chain = model_of(name), CHAINS[name]
    zero, step = np.zeros(model.nv), 1e-6
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ours = np.zeros((model.nv, model.nv))
    theirs = np.zeros((model.nv, model.nv))
    for i, unit in enumerate(np.eye(model.nv)):
        theirs[:, i] = chain.equations(step * unit, zero)[1] / step
        data.qpos[:], data.qvel[:] = step * unit, 0.0
        mujoco.mj_forward(model, data)
        ours[:, i] = data.qfrc_bias / step
    data.qpos[:] = 0.0
    mujoco.mj_forward(model, data)
    squares = scipy.linalg.eigvalsh(theirs, chain.equations(zero, zero)[0])
    found = scipy.linalg.eigvalsh((ours + ours.T) / 2, inertia_of(model, data))
    # The sine leaves out step^2 / 6 of it, 2e-13; rounding of the quotient adds 1e-16 / 1e-6.
    assert np.allclose(found, squares, rtol=1e-8, atol=1e-7)
    # A cart that slides freely has one mode without a frequency; the rest swing.
    assert abs(squares[0]) < 1e-7
    assert squares[1] > 1.0


@pytest.mark.parametrize("words", ["two", "three", "five"])
def test_the_servos_hold_the_chain_upright(words: str) -> None:
    model = model_of(f"cart_{words}_links_servo")
    data = mujoco.MjData(model)
    upright = np.zeros(model.nq)
    upright[1] = np.pi
    data.qpos[:] = upright
    data.qpos[1:] += 0.02
    data.ctrl[:] = upright
    mujoco.mj_step(model, data, 5000)
    # Ten seconds are more than ten of the slowest servo's times, kv / kp = 0.26 s.
    assert np.abs(data.qpos - upright).max() < 1e-3
    assert np.abs(data.qvel).max() < 1e-3


@pytest.mark.parametrize("words", ["two", "three", "five"])
def test_a_hinges_motor_lifts_all_that_hangs_from_it(words: str) -> None:
    model, chain = model_of(f"cart_{words}_links"), CHAINS[f"cart_{words}_links"]
    for i in range(1, model.nv):
        level = np.zeros(model.nv)
        level[i] = np.pi / 2
        held = chain.equations(level, np.zeros(model.nv))[1][i]
        limit = model.actuator_ctrlrange[i, 1]
        # Twice what it takes, up to a whole N m.
        assert 2.0 * held <= limit < 2.0 * held + 1.0


@pytest.mark.parametrize("name", RIDERS)
def test_a_rider_with_stiff_joints_is_the_rigid_rider(name: str) -> None:
    rigid, model = model_of("rider_rigid_passive"), model_of(f"rider_{name}_passive")
    one, many = mujoco.MjData(rigid), mujoco.MjData(model)
    for lean in (0.0, 0.4):
        one.qpos[1] = many.qpos[1] = lean
        mujoco.mj_forward(rigid, one)
        mujoco.mj_forward(model, many)
        # Only board and ankle move: the inertia of those two coordinates is the rigid one's.
        kept = inertia_of(model, many)[:2, :2]
        assert np.abs(kept - inertia_of(rigid, one)).max() < 1e-12
        assert np.abs(many.qfrc_bias[:2] - one.qfrc_bias).max() < 1e-12


@pytest.mark.parametrize("name", RIDERS)
@pytest.mark.parametrize("board", ["driven", "passive"])
def test_a_rider_is_as_tall_and_as_heavy_as_its_card_says(name: str, board: str) -> None:
    model = model_of(f"rider_{name}_{board}")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    head = model.geom("head").id
    crown = data.geom_xpos[head, 2] + model.geom_size[head, 2]
    # The deck's top is at 0.091 m; drawings are rounded to 0.1 mm.
    assert crown == pytest.approx(0.091 + H, abs=2e-4)
    assert model.body_mass.sum() - model.body("board").mass[0] == pytest.approx(3.0, abs=1e-12)
    wheel = model.geom("front_left_wheel")
    assert data.geom_xpos[wheel.id, 2] == pytest.approx(wheel.size[0], abs=1e-12)


@pytest.mark.parametrize("name", RIDERS)
def test_a_rider_on_a_free_board_cannot_move_their_common_centre(name: str) -> None:
    model = model_of(f"rider_{name}_passive", timestep=0.0005)
    assert "board" not in {actuator.name for actuator in load(f"rider_{name}_passive").actuators}
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    for step in range(1000):
        data.ctrl[:] = 0.3 * model.actuator_ctrlrange[:, 1] * np.sin(0.05 * step)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    # The board's momentum, (M v)_0, only changes by forces from outside, and there are none.
    # It is a few kg m/s in parts; Runge-Kutta loses 1e-6 of it where a knee meets its stop.
    assert abs(data.qvel[0]) > 0.01
    assert abs((inertia_of(model, data) @ data.qvel)[0]) < 1e-5
