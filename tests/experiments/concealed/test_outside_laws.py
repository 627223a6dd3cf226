"""Physics outside the library: what each does, and that what should do no work does none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.concealed.mechanisms import draw_mechanism
from experiments.concealed.outside import OUTSIDE_LAWS
from experiments.concealed.plant import Array, Plant
from experiments.concealed.simulate import GRID, Motion, Run, moving_state, simulate
from experiments.concealed.suites import LAWS

BY_NAME = {law.name: law for law in (*LAWS, *OUTSIDE_LAWS)}


def leg() -> Plant:
    """Return a leg in free fall without rotors, damping and drives."""
    plant = draw_mechanism("leg", np.random.default_rng(3)).plant
    bare = plant.with_joint(slice(None), viscous=0.0, rotor=0.0, drive=0.0, track_p=0.0)
    return replace(bare, gravity=np.zeros(3))


def go(plant: Plant, v: Array, seconds: float, command: float = 0.0) -> Motion:
    """Return the motion from q = 0 at some velocities, under a constant command everywhere."""
    n = plant.count
    wide = np.full((1, n), command)
    run = Run(ticks=np.array([0]), feed=wide, reference=wide * np.nan, noise=0 * wide,
              start=np.zeros(n), grids=round(seconds / GRID))  # fmt: skip
    return simulate(plant, run, state=moving_state(plant, np.zeros(n), v), finer=2)


def kinetic(plant: Plant, motion: Motion) -> Array:
    """Return the kinetic energy every 50 ms, moved fluid included."""
    q, v = motion.q[::400], motion.v[::400]
    return 0.5 * np.einsum("ti,tij,tj->t", v, plant.mass_and_bias(q, v)[0], v)


FIGURES = {"x": 0.4, "y": 2.0, "z": 0.9, "cx": 0.1, "cy": -0.05, "cz": 0.07}


@pytest.mark.parametrize(
    ("name", "figures"), [("added_mass", FIGURES), ("spinning_rotor", {"h": 0.05})]
)
def test_moved_fluid_and_a_flywheel_do_no_work(name: str, figures: dict[str, float]) -> None:
    plant, v = leg(), np.array([2.0, -1.5, 3.0])
    changed = BY_NAME[name].apply(plant, 2, figures)
    motion = go(changed, v, 1.0)
    energy = kinetic(changed, motion)
    # Second order with rates up to 10 rad/s: (10 * 1.25e-4)^2 = 2e-6, many times over.
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)
    assert np.abs(motion.q[-1] - go(plant, v, 1.0).q[-1]).max() > 1e-2


def test_fluid_moved_alike_along_every_axis_is_a_point_mass_without_weight() -> None:
    at = {"x": 0.1, "y": -0.05, "z": 0.07}
    moved = {"x": 0.6, "y": 0.6, "z": 0.6, "cx": 0.1, "cy": -0.05, "cz": 0.07}
    v = np.array([2.0, -1.5, 3.0])
    wet = go(BY_NAME["added_mass"].apply(leg(), 2, moved), v, 0.5)
    heavy = go(BY_NAME["payload"].apply(leg(), 2, {"m": 0.6, **at}), v, 0.5)
    np.testing.assert_allclose(wet.q, heavy.q, atol=1e-9)


def test_three_joints_that_their_friction_holds_stay_exactly_put() -> None:
    plant = replace(leg(), gravity=np.array([0.0, 0.0, -9.80665])).with_joint(
        slice(None), coulomb=20.0
    )
    motion = go(plant, np.zeros(3), 0.1)
    assert (motion.v == 0.0).all()
    assert (motion.q == 0.0).all()


def hinge() -> Plant:
    """Return a driven hinge of inertia I in free fall."""
    plant = draw_mechanism("pendulum", np.random.default_rng(3)).plant
    bare = plant.with_joint(0, viscous=0.0, rotor=0.0, track_p=0.0, track_d=0.0)
    return replace(bare, gravity=np.zeros(3))


def torque(plant: Plant, motion: Motion, at: float) -> float:
    """Return the torque on a hinge at a time, by the change of its velocity over two steps."""
    i = round(at / motion.step)
    inertia = plant.mass_and_bias(motion.q[:1], motion.v[:1])[0][0, 0, 0]
    return float(inertia * (motion.v[i + 1, 0] - motion.v[i - 1, 0]) / (2 * motion.step))


def test_a_winding_drum_pulls_harder_with_every_turn() -> None:
    plant = BY_NAME["winding_drum"].apply(hinge(), 0, {"r": 0.3})
    motion = go(plant, np.array([1.0]), 0.3, command=0.5)
    q = motion.q[round(0.2 / motion.step), 0]
    assert torque(plant, motion, 0.2) == pytest.approx(0.5 * (1 + 0.3 * q), rel=1e-4)


def test_a_supply_ripples_at_its_own_frequency() -> None:
    plant = BY_NAME["supply_ripple"].apply(hinge(), 0, {"a": 0.4, "f": 1.2})
    motion = go(plant, np.array([0.0]), 0.3, command=0.5)
    expected = 0.5 * (1 + 0.4 * np.sin(2 * np.pi * 1.2 * 0.2))
    assert torque(plant, motion, 0.2) == pytest.approx(expected, rel=1e-4)


def test_a_gear_error_changes_torque_and_reading_so_that_power_is_kept() -> None:
    plant = BY_NAME["gear_transmission_error"].apply(hinge(), 0, {"e": 0.05, "n": 6.0})
    motion = go(plant, np.array([1.0]), 0.3, command=0.5)
    q = motion.q[round(0.2 / motion.step), 0]
    # The motor is at q + e sin n q: the link feels the torque times its slope.
    assert torque(plant, motion, 0.2) == pytest.approx(0.5 * (1 + 0.3 * np.cos(6 * q)), rel=1e-3)


def test_oil_that_warms_thins() -> None:
    plant = BY_NAME["warming_viscosity"].apply(hinge(), 0, {"b": 0.2, "rate": 0.5})
    motion = go(plant, np.array([3.0]), 0.5)
    # x' = rate v^2 (3 - x) along the motion; torque = -b exp(-x) v.
    v = motion.v[: round(0.4 / motion.step), 0]
    x = 3 * (1 - np.exp(-0.5 * motion.step * (v**2).sum()))
    found = torque(plant, motion, 0.4)
    assert found == pytest.approx(-0.2 * np.exp(-x) * v[-1], rel=2e-3)


def test_friction_with_memory_grows_while_the_direction_is_kept() -> None:
    plant = BY_NAME["friction_with_memory"].apply(hinge(), 0, {"c": 0.05, "m": 0.9, "T": 0.3})
    motion = go(plant, np.array([3.0]), 0.4)
    expected = -0.05 * (1 + 0.9 * (1 - np.exp(-0.3 / 0.3)))
    assert torque(plant, motion, 0.3) == pytest.approx(expected, rel=2e-3)


def test_a_detent_pulls_two_joints_with_equal_and_opposite_torques() -> None:
    plant = BY_NAME["coupled_detent"].apply(leg(), 1, {"a": 0.3, "n": 4.0})
    q0 = np.zeros(3)
    assert np.abs(go(plant, q0, 0.1).q).max() == 0.0
    v = np.array([0.0, 1.0, -1.0])
    pulled, free = go(plant, v, 0.05), go(leg(), v, 0.05)
    gap = pulled.q[-1, 1] - pulled.q[-1, 2]
    assert 0.0 < gap < free.q[-1, 1] - free.q[-1, 2]


@pytest.mark.parametrize(("name", "slide"), [("loose_mass", 1), ("second_resonance", 0)])
def test_a_part_that_swings_keeps_the_mass_and_the_moment(name: str, slide: int) -> None:
    figures = {"share": 0.3, "frequency": 4.0, "damping": 0.1}
    plant = leg()
    loose = BY_NAME[name].apply(plant, 2, figures)
    assert (loose.count, loose.slide[-1], loose.parent[-1]) == (4, slide, 2)
    assert loose.of_body("mass").sum() == pytest.approx(plant.of_body("mass").sum())
    still = np.zeros((1, 4))
    whole = plant.mass_and_bias(still[:, :3], still[:, :3])[0][0]
    # Locked at rest, the leaf is where the mass was taken: the same matrix but for its own size.
    np.testing.assert_allclose(loose.mass_and_bias(still, still)[0][0][:3, :3], whole, atol=1e-6)


def test_a_turned_axis_stays_a_unit_vector() -> None:
    figures = {"angle": 0.2, "x": 0.3, "y": -0.2, "z": 0.7}
    turned = BY_NAME["axis_misalignment"].apply(leg(), 1, figures)
    assert np.linalg.norm(turned.axis[1]) == pytest.approx(1.0)
    assert turned.axis[1] @ leg().axis[1] == pytest.approx(np.cos(0.2))
