"""Laws of bodies, of the fluid and of the world against statics and inertia by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.concealed.body_laws import add_mass
from experiments.concealed.plant import Plant, plant_of
from experiments.concealed.suites import LAWS

BY_NAME = {law.name: law for law in LAWS}
MASS = 2.0
G = 9.80665


def put(plant: Plant, name: str, **figures: float) -> Plant:
    return BY_NAME[name].apply(plant, 0, figures)


def rod() -> Plant:
    """Return a hinge about y with 2 kg at 0.5 m along x: level at q = 0."""
    plant = plant_of(
        parent=np.array([-1]), slide=np.array([0]), rotation=np.eye(3)[None],
        origin=np.zeros((1, 3)), axis=np.array([[0, 1.0, 0]]), mass=np.array([MASS]),
        com=np.array([[0.5, 0.0, 0.0]]), inertia=0.01 * np.eye(3)[None],
        gravity=np.array([0, 0, -G]),
    )  # fmt: skip
    return plant.with_joint(0, drive=1.0)


def static(plant: Plant, q: float = 0.0) -> float:
    """Return the force that gravity and fluid need at rest."""
    return float(plant.mass_and_bias(np.array([[q]]), np.zeros((1, 1)))[1][0, 0])


def inertia(plant: Plant) -> float:
    return float(plant.mass_and_bias(np.zeros((1, 1)), np.zeros((1, 1)))[0][0, 0, 0])


def test_a_payload_adds_weight_and_inertia() -> None:
    plant = put(rod(), "payload", m=1.0, x=0.8, y=0.1, z=0.0)
    # The rod's q > 0 turns its end down: gravity's bias is -m g x.
    assert static(plant) - static(rod()) == pytest.approx(-G * 0.8)
    assert inertia(plant) - inertia(rod()) == pytest.approx(0.8**2)
    same = add_mass(plant, 0, -1.0, np.array([0.8, 0.1, 0.0]))
    np.testing.assert_allclose(same.inertia, rod().inertia, atol=1e-12)


def test_a_centre_and_a_link_change_as_stated() -> None:
    assert static(put(rod(), "com_offset", x=0.1, y=0, z=0)) == pytest.approx(-MASS * G * 0.6)
    heavy = put(rod(), "link_inertia", mass=1.5, inertia=3.0)
    assert inertia(heavy) == pytest.approx(1.5 * MASS * 0.25 + 0.03)


def test_figures_beside_a_description_that_errs_make_the_true_plant() -> None:
    described = rod().with_joint(0, gain=2.0)
    true = described.with_body(0, mass=1.2 * MASS).with_com(0, np.array([0.4, 0.0, 0.0]))
    true = true.with_inertia(0, 0.9 * described.inertia[0]).with_joint(0, gain=1.8)
    for name, figures in (
        ("link_inertia", {"mass": 1.5, "inertia": 2.0}),
        ("com_offset", {"x": 0.02, "y": 0.03, "z": -0.01}),
        ("torque_scale", {"gain": 0.7}),
    ):
        law = BY_NAME[name]
        left_out = put(true, name, **figures)
        found = put(described, name, **law.beside(figures, described, true, 0))
        if name == "link_inertia":
            assert found.of_body("mass") == pytest.approx(left_out.of_body("mass"))
            np.testing.assert_allclose(found.inertia, left_out.inertia)
        elif name == "com_offset":
            np.testing.assert_allclose(found.com, left_out.com)
        else:
            assert found.of_joint("gain") == pytest.approx(left_out.of_joint("gain"))


def test_a_tilted_base_turns_gravity() -> None:
    tilted = put(rod(), "base_tilt", roll=0.0, pitch=0.2)
    # Pitch turns the level rod's base by 0.2 rad about y: as q = 0.2.
    assert static(tilted) == pytest.approx(static(rod(), 0.2))


def test_fluid_lifts_drags_and_is_moved_along() -> None:
    at = {"cx": 0.4, "cy": 0.0, "cz": 0.0}
    lifted = put(rod(), "buoyancy", volume=1e-3, density=1000.0, **at)
    assert static(lifted) - static(rod()) == pytest.approx(G * 0.4)
    v = np.array([[2.0]])
    still = np.zeros((1, 1))
    bare = rod().mass_and_bias(still, v)[1][0, 0]
    slow = put(rod(), "linear_drag", x=1.0, y=2.0, z=3.0, **at)
    assert slow.mass_and_bias(still, v)[1][0, 0] - bare == pytest.approx(3.0 * 0.8 * 0.4)
    fast = put(rod(), "quadratic_drag", x=1.0, y=2.0, z=3.0, **at)
    assert fast.mass_and_bias(still, v)[1][0, 0] - bare == pytest.approx(3.0 * 0.64 * 0.4)
    carried = put(slow, "fluid_current", x=0.0, y=0.0, z=-0.8)
    # The end moves down at 0.8 m/s, with the fluid: no drag is left.
    assert carried.mass_and_bias(still, v)[1][0, 0] == pytest.approx(bare)
    full = put(rod(), "added_mass", x=1.0, y=2.0, z=3.0, **at)
    assert inertia(full) - inertia(rod()) == pytest.approx(3.0 * 0.16)
    assert static(full) == pytest.approx(static(rod()))


def test_thrust_is_lighthill_s_at_the_tail() -> None:
    paddle = {"C": 0.5, "density": 1000.0, "span": 0.1, "cx": -0.4, "cy": 0.0, "cz": 0.0}
    bare = plant_of(
        parent=np.array([-1, 0]), slide=np.array([1, 0]), rotation=np.stack([np.eye(3)] * 2),
        origin=np.zeros((2, 3)), axis=np.array([[1.0, 0, 0], [0, 1.0, 0]]),
        mass=np.array([1.0, 1.0]), com=np.zeros((2, 3)), inertia=np.stack([np.eye(3)] * 2),
        gravity=np.zeros(3),
    )  # fmt: skip
    plant = BY_NAME["thrust"].apply(bare, 1, paddle)
    moved = 0.5 * np.pi / 4 * 1000.0 * 0.1**2
    still = np.zeros((1, 2))
    # The chord is +x. A current of 2 m/s along z is w = 2: m w^2 / 2 forward, no moment.
    across = replace(plant, current=np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(across.mass_and_bias(still, still)[1][0], [-2.0 * moved, 0.0])
    # With u = 3 m/s forward as well, m w u = 6 m acts across, here along +z at x = -0.4, and
    # turns by z Fx - x Fz = 0.4 * 6 m.
    both = replace(plant, current=np.array([-3.0, 0.0, 2.0]))
    expected = [-2.0 * moved, -2.4 * moved]
    np.testing.assert_allclose(both.mass_and_bias(still, still)[1][0], expected)
    # Carried backwards, the edge sheds nothing across.
    back = replace(plant, current=np.array([3.0, 0.0, 2.0]))
    np.testing.assert_allclose(back.mass_and_bias(still, still)[1][0], [-2.0 * moved, 0.0])


def test_a_tether_pulls_once_it_is_taut() -> None:
    tied = {"k": 10.0, "length": 0.5, "ax": -0.1, "ay": 0, "az": 0, "cx": 0, "cy": 0, "cz": 0}
    rail = replace(rod(), slide=np.array([1]), axis=np.array([[1.0, 0, 0]]))
    plant = BY_NAME["tether"].apply(rail, 0, tied)
    q, v = np.array([[0.3], [0.7]]), np.zeros((2, 1))
    np.testing.assert_allclose(plant.mass_and_bias(q, v)[1][:, 0], [0.0, 10.0 * 0.3])
