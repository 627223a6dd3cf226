"""Every law of the benchmark against its closed form, on a mass that slides on a level rail."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from experiments.concealed.fields import STATE_ROW
from experiments.concealed.law import Law
from experiments.concealed.outside import OUTSIDE_LAWS
from experiments.concealed.plant import Array, Plant, plant_of
from experiments.concealed.readings import ideal_readings
from experiments.concealed.simulate import GRID, Motion, Run, moving_state, simulate
from experiments.concealed.suites import LAWS
from tests.house.test_effects_are_listed import VOCABULARY

BY_NAME = {law.name: law for law in LAWS}
MASS = 2.0
G = 9.80665


def cart(*, drive: float = 1.0) -> Plant:
    """Return 2 kg on a rail along x."""
    plant = plant_of(
        parent=np.array([-1]), slide=np.array([1]), rotation=np.eye(3)[None],
        origin=np.zeros((1, 3)), axis=np.array([[1.0, 0, 0]]), mass=np.array([MASS]),
        com=np.array([[0.1, 0.0, 0.0]]), inertia=0.01 * np.eye(3)[None],
        gravity=np.array([0, 0, -G]),
    )  # fmt: skip
    return plant.with_joint(0, drive=drive)


def put(plant: Plant, name: str, **figures: float) -> Plant:
    return BY_NAME[name].apply(plant, 0, figures)


def go(
    plant: Plant, force: Callable[[Array], Array] | float = 0.0, *, v: float = 0.0, q: float = 0.0,
    seconds: float = 0.5, finer: int = 2, rotor: float = np.nan,
) -> Motion:  # fmt: skip
    """Return the motion under a command that changes every millisecond.

    A rotor is wound by what it carries unless its position is given.
    """
    grids = round(seconds / GRID)
    ticks = np.arange(0, grids, 4)
    feed = force(ticks * GRID) if callable(force) else np.full(len(ticks), force)
    none = np.zeros((len(ticks), 1))
    run = Run(ticks=ticks, feed=feed[:, None], reference=np.full_like(none, np.nan), noise=none,
              start=np.array([q]), grids=grids)  # fmt: skip
    state = moving_state(plant, np.array([q]), np.array([v]))
    state[STATE_ROW["rotor_q"]] = rotor
    return simulate(plant, run, state=state, finer=finer)


def pull(motion: Motion, at: float) -> float:
    """Return the force at a time, from the change of velocity over two steps."""
    i = round(at / motion.step)
    return float(MASS * (motion.v[i + 1, 0] - motion.v[i - 1, 0]) / (2 * motion.step))


def test_every_law_of_the_vocabulary_that_can_act_is_there() -> None:
    elsewhere = {"contact_friction", "contact_softness", "restitution", "ground_slope", "ground"}
    assert {law.name for law in LAWS} - {"speed_torque_limit"} == (
        VOCABULARY - elsewhere - {"speed_torque_limit"}
    )
    assert len(LAWS) == 37


def test_half_of_the_physics_outside_the_library_is_kept_for_the_judge() -> None:
    names = [law.name for law in OUTSIDE_LAWS]
    assert len(names) >= 8
    assert not set(names) & VOCABULARY
    assert sum(law.judge for law in OUTSIDE_LAWS) >= len(names) // 2


def test_viscous_friction_decays_exponentially() -> None:
    motion = go(put(cart(), "viscous_friction", b=3.0), v=1.0)
    assert motion.v[-1, 0] == pytest.approx(np.exp(-3.0 / MASS * 0.5), rel=1e-5)


def test_quadratic_damping_decays_as_a_hyperbola() -> None:
    motion = go(put(cart(), "quadratic_damping", b2=3.0), v=-1.0)
    assert motion.v[-1, 0] == pytest.approx(-1 / (1 + 3.0 / MASS * 0.5), rel=1e-5)


def test_coulomb_friction_stops_in_a_straight_line_and_holds_exactly() -> None:
    motion = go(put(cart(), "coulomb_friction", c=4.0), v=0.6)
    # Stops after m v / c = 0.3 s, at v^2 m / 2 c = 0.09 m; one step is 1.25e-4 s.
    assert motion.q[-1, 0] == pytest.approx(0.09, abs=1e-4)
    assert (motion.v[round(0.31 / motion.step) :] == 0.0).all()


@pytest.mark.parametrize(("force", "moves"), [(5.9, False), (6.1, True)])
def test_stiction_holds_up_to_its_level(force: float, moves: bool) -> None:
    motion = go(put(cart(), "stribeck_friction", c=4.0, s=6.0, vs=0.1), force)
    assert bool(motion.q[-1, 0] != 0.0) == moves


def test_stiction_fades_with_the_square_of_the_speed() -> None:
    motion = go(put(cart(), "stribeck_friction", c=4.0, s=6.0, vs=1.0), v=1.0, seconds=0.01)
    assert pull(motion, 2 * motion.step) == pytest.approx(-(4 + 2 * np.exp(-1)), rel=2e-3)


@pytest.mark.parametrize("force", [10.0, 20.0])
def test_load_dependent_friction_grows_with_the_force(force: float) -> None:
    plant = put(cart(), "load_dependent_friction", c0=1.0, k=0.2)
    assert pull(go(plant, force), 0.2) == pytest.approx(force - 1.0 - 0.2 * force, rel=1e-6)


def test_position_dependent_friction_follows_its_wave() -> None:
    plant = put(cart(), "position_dependent_friction", c=2.0, a=1.0, n=30.0, phase=0.4)
    motion = go(plant, 8.0)
    q = motion.q[round(0.3 / motion.step), 0]
    expected = 8.0 - (2.0 + np.sin(30 * q + 0.4))
    assert pull(motion, 0.3) == pytest.approx(expected, rel=1e-3)


def test_cogging_is_the_same_in_both_directions() -> None:
    plant = put(cart(), "cogging", a=1.5, n=20.0, phase=0.3)
    for v in (1.0, -1.0):
        motion = go(plant, v=v)
        q = motion.q[round(0.2 / motion.step), 0]
        assert pull(motion, 0.2) == pytest.approx(1.5 * np.sin(20 * q + 0.3), rel=1e-3)


def test_joint_stiffness_swings_about_its_rest() -> None:
    motion = go(put(cart(), "joint_stiffness", k=50.0, q0=0.1), q=0.3)
    assert motion.q[-1, 0] == pytest.approx(0.1 + 0.2 * np.cos(5.0 * 0.5), abs=1e-6)


def test_hysteresis_closes_as_dahl_s_model_does() -> None:
    # From z = 0 in one direction: force F (1 - exp(-x / d)).
    motion = go(put(cart(), "hysteresis", F=3.0, d=0.05), v=1.0)
    x = motion.q[round(0.1 / motion.step), 0]
    assert pull(motion, 0.1) == pytest.approx(-3.0 * (1 - np.exp(-x / 0.05)), rel=1e-2)


def split(name: str, **figures: float) -> Plant:
    return put(cart().with_joint(0, rotor=1.0), name, **figures)


def test_backlash_lets_the_motor_turn_before_the_link_moves() -> None:
    motion = go(split("backlash", gap=0.02, tooth_k=1e5, tooth_d=100.0), 2.0, rotor=0.0)
    # The motor crosses half the gap, 0.01 m, at 2 m/s2: after 0.1 s.
    assert (motion.q[: round(0.099 / motion.step)] == 0.0).all()
    assert motion.q[round(0.12 / motion.step), 0] > 0.0


@pytest.mark.parametrize(
    "law", [("backlash", {"gap": 0.02, "tooth_k": 1e5, "tooth_d": 0.0}),
            ("series_elasticity", {"k": 600.0, "d": 0.0})],
)  # fmt: skip
def test_a_rotor_starts_wound_by_its_load(law: tuple[str, dict[str, float]]) -> None:
    for force in (3.0, -3.0):
        motion = go(split(law[0], **law[1]), force)
        # Motor and link turn as one from the start, 1 kg and 2 kg, and nothing swings.
        t = np.arange(len(motion.q)) * motion.step
        np.testing.assert_allclose(motion.q[:, 0], force / 3.0 * t**2 / 2, atol=2e-6)


def test_teeth_never_pull() -> None:
    plant = split("backlash", gap=0.02, tooth_k=1e4, tooth_d=200.0)
    state = moving_state(plant, np.array([0.0]), np.array([0.0]))
    # The motor is 0.1 mm into the tooth, 1 N, and leaves it at 1 m/s: the damper would pull.
    state[STATE_ROW["rotor_q"]] = 0.0101
    state[STATE_ROW["rotor_v"]] = state[STATE_ROW["rotor_before"]] = -1.0
    none = np.zeros((1, 1))
    run = Run(ticks=np.array([0]), feed=none, reference=none * np.nan, noise=none,
              start=np.zeros(1), grids=20)  # fmt: skip
    assert (simulate(plant, run, state=state).q == 0.0).all()


def test_a_flexible_drive_swings_at_the_rate_of_its_two_masses() -> None:
    motion = go(split("series_elasticity", k=600.0, d=0.0), 3.0, rotor=0.0)
    # 1 kg and 2 kg on 600 N/m: rate 30 rad/s; link = F/M (t^2/2 - (1 - cos wt)/w^2), M = 3 kg.
    t = np.arange(len(motion.q)) * motion.step
    expected = t**2 / 2 - (1 - np.cos(30 * t)) / 900
    np.testing.assert_allclose(motion.q[:, 0], expected, atol=2e-6)


def test_an_end_stop_pushes_one_way_alone() -> None:
    plant = put(cart(), "end_stop", q_stop=0.1, side=1.0, stop_k=1e4, stop_d=200.0)
    motion = go(plant, 10.0, seconds=1.5)
    assert motion.q[-1, 0] == pytest.approx(0.1 + 10.0 / 1e4, abs=1e-5)
    assert go(plant, -10.0).q[-1, 0] == pytest.approx(-10 / MASS / 2 * 0.25, rel=1e-3)


def test_an_end_stop_never_pulls() -> None:
    plant = put(cart(), "end_stop", q_stop=0.1, side=1.0, stop_k=1e4, stop_d=200.0)
    # At 0.1 mm depth it would push by 1 N; leaving at 1 m/s, its damper would pull by 200 N.
    assert (go(plant, q=0.1001, v=-1.0, seconds=0.1).v[:, 0] == -1.0).all()


def test_a_rotor_adds_to_the_inertia() -> None:
    motion = go(put(cart(), "armature", J=3.0), 10.0)
    assert pull(motion, 0.2) * 5.0 / MASS == pytest.approx(10.0)


def test_a_delay_shifts_the_command() -> None:
    motion = go(put(cart(), "actuator_delay", T=0.1005), lambda t: 1.0 * (t >= 0.1))
    assert motion.v[-1, 0] == pytest.approx((0.4 - 0.1005) / MASS, rel=1e-6)


def test_a_lag_is_of_first_order() -> None:
    motion = go(put(cart(), "actuator_lag", T=0.05), lambda t: 1.0 * (t >= 0.1))
    assert pull(motion, 0.15) == pytest.approx(1 - np.exp(-1.0), rel=5e-3)


DRIVES = [
    ("torque_scale", {"gain": 0.6}, 10.0, 0.0, 6.0),
    ("torque_saturation", {"limit": 7.0}, 10.0, 0.0, 7.0),
    ("dead_zone", {"threshold": 3.0}, -10.0, 0.0, -7.0),
    ("speed_torque_limit", {"tau0": 8.0, "v0": 4.0}, 10.0, 2.0, 4.0),
    ("speed_torque_limit", {"tau0": 8.0, "v0": 4.0}, 10.0, -2.0, 10.0),
    ("back_emf", {"k": 2.0}, 10.0, 2.0, 6.0),
    ("back_emf", {"k": 2.0}, 0.0, 2.0, 0.0),
    ("voltage_sag", {"k": 0.1}, 10.0, 0.0, 5.0),
]


@pytest.mark.parametrize(("law", "figures", "force", "v", "expected"), DRIVES)
def test_a_drive_gives_what_its_law_leaves(
    law: str, figures: dict[str, float], force: float, v: float, expected: float
) -> None:
    motion = go(put(cart(), law, **figures), force, v=v, seconds=0.01)
    # At two steps of 1.25e-4 s the velocity has changed by at most 1.3e-3 m/s.
    assert pull(motion, 2 * motion.step) == pytest.approx(expected, abs=5e-3)


def test_a_drive_derates_towards_its_floor() -> None:
    plant = put(cart(), "thermal_derating", rate=4.0, floor=0.5, level=10.0)
    motion = go(plant, 10.0, seconds=1.0)

    # x' = r g^2 (1 - x), g = 1 - x / 2, integrated here by RK4.
    def slope(x: float) -> float:
        return 4.0 * (1 - 0.5 * x) ** 2 * (1 - x)

    x, h = 0.0, 0.01
    for _ in range(90):
        a = slope(x)
        b = slope(x + h / 2 * a)
        c = slope(x + h / 2 * b)
        x += h / 6 * (a + 2 * b + 2 * c + slope(x + h * c))
    assert pull(motion, 0.9) == pytest.approx(10 * (1 - 0.5 * x), rel=1e-3)


def test_sensors_show_what_their_laws_say() -> None:
    motion = go(cart(), v=1.0)
    ticks = np.array([800, 1600])
    plant = put(put(cart(), "sensor_bias", bias=0.02), "sensor_scale", scale=1.1)
    shown = ideal_readings(plant, motion.q, ticks, motion.step, 1)
    np.testing.assert_allclose(shown[:, 0], 1.1 * ticks * GRID + 0.02, rtol=1e-12)
    late = ideal_readings(put(cart(), "timestamp_offset", T=0.05), motion.q, ticks, motion.step, 1)
    np.testing.assert_allclose(late[:, 0], ticks * GRID - 0.05, rtol=1e-9)


def test_a_push_gives_its_impulse() -> None:
    plant = put(cart(), "external_push", start=0.1, end=0.2, x=3.0, y=1.0, z=0.0)
    assert go(plant).v[-1, 0] == pytest.approx(3.0 / MASS, rel=1e-2)


def test_every_law_has_figures_in_its_own_symbols() -> None:
    assert all(isinstance(law, Law) and law.name for law in (*LAWS, *OUTSIDE_LAWS))
    assert len({law.name for law in (*LAWS, *OUTSIDE_LAWS)}) == len(LAWS) + len(OUTSIDE_LAWS)
