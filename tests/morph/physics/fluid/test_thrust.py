"""Thrust against slender-wing theory, the wake's energy, and a paddle that beats."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.special import j1

from morph.arrays import Array
from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.physics.body_motion import body_motions
from morph.physics.fluid.kernel import install
from morph.physics.fluid.numbers import ADDED, POINT, SHED, SIGNATURE, numbers_of, write_numbers
from morph.physics.fluid.thrust import Thrust, shed_mass, tail_force
from morph.physics.motion import Motion
from morph.sim.simulator import Simulator

LENGTH, SPAN = 0.16, 0.05

BENCH = f"""
<mujoco>
  <option gravity="0 0 0" integrator="RK4" timestep="0.001"/>
  <worldbody>
    <body name="cart">
      <joint name="rail" type="slide" axis="1 0 0"/>
      <geom type="box" size="0.1 0.1 0.1" mass="1000"/>
      <body name="paddle">
        <joint name="hinge" type="hinge" axis="0 1 0" armature="1e4"/>
        <geom type="box" size="{LENGTH / 2} {SPAN / 2} 0.0015" pos="{-LENGTH / 2} 0 0" mass="0.01"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
"""A cart of a ton, so that it hardly moves, and a paddle that nothing can keep from its stroke."""


def wet(model: str, effects: tuple[Thrust, ...], added: float = 0.0) -> Any:
    """Return a model whose paddle moves `added` kg of water across, spread along it evenly."""
    install()
    spec = mujoco.MjSpec.from_string(model)
    tensor = np.zeros((6, 6))
    # About its middle: a plate moves water across it, and by turning about its width.
    tensor[2, 2], tensor[4, 4] = added, added * LENGTH**2 / 12.0
    numbers = numbers_of(spec, "paddle")
    numbers[ADDED] = tensor[np.triu_indices(6)].tolist()
    numbers[POINT] = [-LENGTH / 2.0, 0.0, 0.0]
    write_numbers(spec, "paddle", numbers)
    for effect in effects:
        effect.edit(spec)
    return spec.compile()


def drift(model: Any, *, amplitude: float, frequency: float, strokes: int) -> float:
    """Return the cart's speed after some symmetric strokes about straight back, m/s."""
    data = mujoco.MjData(model)
    omega = 2.0 * math.pi * frequency
    # A spring swings the armature by A sin(omega t); what the water does is lost in its 1e4 kg m2.
    model.jnt_stiffness[1] = 1e4 * omega**2
    data.qvel[1] = amplitude * omega
    for _ in range(round(strokes / frequency / model.opt.timestep)):
        mujoco.mj_step(model, data)
    # At whole strokes the paddle is where it began, so the water around it has its first momentum.
    return float(data.qvel[0])


def test_a_wing_has_the_lift_and_the_induced_drag_of_slender_wing_theory() -> None:
    # Jones 1946, NACA report 835, eq. 6 and 12: lift pi/4 rho U^2 s^2 alpha, and half of it
    # times alpha as drag. Small angles: 0.01 rad leaves 1e-4 of either.
    speed, angle, span = 2.0, 0.01, 0.3
    forward, down = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])
    chord = np.array([math.cos(angle), 0.0, math.sin(angle)])
    normal = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    force = tail_force(speed * forward, chord, normal, shed_mass(span, 1000.0))
    lift = math.pi / 4.0 * 1000.0 * speed**2 * span**2 * angle
    assert -force @ down == pytest.approx(lift, rel=1e-3)
    assert -force @ forward == pytest.approx(0.5 * lift * angle, rel=1e-3)


def test_it_takes_from_the_body_what_the_wake_holds_and_never_gives_any() -> None:
    rng = np.random.default_rng(0)
    velocity = rng.normal(size=(1000, 3))
    chord, normal = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    power = np.sum(tail_force(velocity, chord, normal, 2.0) * velocity, axis=1)
    assert power.max() <= 0.0
    ahead = velocity[:, 0] > 0.0
    # Every second u metres of wake are laid down, each with m w^2 / 2 of energy.
    wake = 0.5 * 2.0 * velocity[:, 2] ** 2 * velocity[:, 0]
    assert 400 < ahead.sum() < 600
    assert power[ahead] == pytest.approx(-wake[ahead], abs=1e-12)


def test_the_force_changes_smoothly_where_the_edge_turns_from_trailing_to_leading() -> None:
    chord, normal = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    near = np.array([[-1e-9, 0.0, 0.7], [1e-9, 0.0, 0.7]])
    before, after = tail_force(near, chord, normal, 3.0)
    # m u w = 3 * 2e-9 * 0.7 apart at most.
    assert np.abs(after - before).max() < 5e-9


@pytest.mark.parametrize(("amplitude", "frequency"), [(0.5, 2.0), (1.0, 1.0)])
def test_a_paddle_that_beats_pushes_with_the_mean_of_its_edge(
    amplitude: float, frequency: float
) -> None:
    # Hinged to what stands still its edge moves across itself alone, w = L dq/dt, and pulls
    # m w^2 / 2 along the chord; forward, cos q of that. With q = A sin(p) the mean of
    # cos(p)^2 cos(A sin p) is J1(A) / A, so that the mean force is m/2 L^2 omega^2 A J1(A).
    omega = 2.0 * math.pi * frequency
    mean = 0.5 * shed_mass(SPAN, 1000.0) * LENGTH**2 * omega**2 * amplitude * j1(amplitude)
    model = wet(BENCH, (Thrust(body="paddle", C=1.0),))
    seconds = 5.0 / frequency
    speed = drift(model, amplitude=amplitude, frequency=frequency, strokes=5)
    # The cart gains 2e-3 m/s, 2e-3 of the edge's speed. To first order that comes and goes with
    # sin q; the square of it is left, 4e-6.
    assert speed == pytest.approx(mean * seconds / 1000.01, rel=1e-5)
    assert speed > 5e-4


def test_a_symmetric_stroke_without_thrust_leaves_no_speed() -> None:
    # A perfect fluid gives back what it took: the added mass of a 5 cm strip of 16 cm, 0.314 kg,
    # swings the cart by 0.314 kg * 0.08 m * 6.3 rad/s / 1000 kg = 1.6e-4 m/s and leaves nothing.
    # That water turns with 0.0027 kg m2 beside the armature's 1e4 and slows the stroke by 1.3e-7:
    # after five, 31 rad, it is 4e-6 rad of phase late, 2e-6 rad of angle, and 1.6e-4 m/s of that
    # are 4e-10 m/s.
    added = shed_mass(SPAN, 1000.0) * LENGTH
    model = wet(BENCH, (), added)
    assert abs(drift(model, amplitude=0.5, frequency=2.0, strokes=5)) < 1e-9
    with_thrust = wet(BENCH, (Thrust(body="paddle", C=1.0),), added)
    assert drift(with_thrust, amplitude=0.5, frequency=2.0, strokes=5) > 1e-3


def test_the_force_is_proportional_to_the_coefficient() -> None:
    speeds: Mapping[float, float] = {
        c: drift(wet(BENCH, (Thrust(body="paddle", C=c),)), amplitude=0.5, frequency=2.0, strokes=2)
        for c in (0.5, 1.0, 2.0)
    }
    # To the square of the share that the cart's own speed, 1e-3 m/s, has of the edge's.
    assert speeds[2.0] == pytest.approx(2.0 * speeds[1.0], rel=1e-5)
    assert speeds[1.0] == pytest.approx(2.0 * speeds[0.5], rel=1e-5)


def test_one_paddle_has_one_thrust() -> None:
    with pytest.raises(EffectError, match="paddle has a thrust already"):
        wet(BENCH, (Thrust(body="paddle", C=0.5), Thrust(body="paddle", C=0.5)))


def test_an_edge_in_numbers_is_the_one_that_the_shapes_have() -> None:
    swimmer = load("hexapod_swimmer")
    told = Thrust.of(swimmer, "left_rear_paddle", 0.7, density=1025.0)
    shapes = Thrust(body="left_rear_paddle", C=0.7, density=1025.0)
    written = []
    for effect in (told, shapes):
        spec = spec_of(swimmer)
        effect.edit(spec)
        written.append(numbers_of(spec, "left_rear_paddle"))
    assert written[0] == pytest.approx(written[1], abs=1e-15)
    # rho pi / 4 s^2 = 1025 * 0.7854 * 0.0025 = 2.0126 kg/m, and 0.7 of it.
    assert written[0][SHED] == pytest.approx([0.7 * 2.0125828], rel=1e-7)


def test_the_regressor_asks_for_an_edge_in_numbers() -> None:
    with pytest.raises(EffectError, match="no shapes here") as caught:
        Thrust(body="fin", C=1.0).edge()
    assert "Thrust.of" in caught.value.fix


def test_the_regressor_is_the_force_that_the_simulation_feels() -> None:
    swimmer = load("hexapod_swimmer")
    effect = Thrust.of(swimmer, "left_rear_paddle", 1.3)
    bare, driven = (Simulator(swimmer, effects).model for effects in ((), (effect,)))
    data = mujoco.MjData(driven)
    rng = np.random.default_rng(0)
    samples, dofs = 50, driven.nv
    position = np.tile(driven.qpos0, (samples, 1))
    position[:, 3:7] = rng.normal(size=(samples, 4))
    position[:, 3:7] /= np.linalg.norm(position[:, 3:7], axis=1, keepdims=True)
    position[:, 7:] = rng.uniform(-1.0, 1.0, (samples, dofs - 6))
    velocity = rng.normal(size=(samples, dofs))
    bodies = body_motions(bare, ["left_rear_paddle"], position, velocity, np.zeros_like(velocity))
    motion = Motion(
        velocity=velocity,
        position=np.zeros_like(velocity),
        acceleration=np.zeros_like(velocity),
        drive=np.zeros((samples, 0, dofs)),
        drive_rate=np.zeros((samples, 0, dofs)),
        stiffness=np.zeros((samples, dofs, dofs)),
        joints={},
        actuators={},
        bodies=bodies,
    )
    told = 1.3 * effect.regressor(motion)[:, :, 0]
    for k in range(samples):
        data.qpos[:], data.qvel[:] = position[k], velocity[k]
        mujoco.mj_forward(driven, data)
        # Nothing else of this robot is passive; forces are of some newtons.
        assert data.qfrc_passive == pytest.approx(told[k], abs=1e-12)
    assert np.abs(told).max() > 1.0


def test_a_fin_that_is_thrown_loses_energy_and_only_energy() -> None:
    free = BENCH.replace('<joint name="rail" type="slide" axis="1 0 0"/>', "<freejoint/>")
    free = free.replace('mass="1000"', 'mass="1"').replace('armature="1e4"', "")
    added = shed_mass(SPAN, 1000.0) * LENGTH

    def energies(effects: tuple[Thrust, ...]) -> Array:
        model = wet(free, effects, added)
        data = mujoco.MjData(model)
        data.qvel[:] = np.random.default_rng(0).normal(size=model.nv)
        found = []
        for _ in range(2000):
            mujoco.mj_step1(model, data)
            product = np.empty(model.nv)
            mujoco.mj_mulM(model, data, product, data.qvel)
            found.append(0.5 * float(data.qvel @ product))
            mujoco.mj_step(model, data)
        return np.array(found)

    kept, lost = energies(()), energies((Thrust(body="paddle", C=1.0),))
    # RK4 at 1 ms and a few rad/s: (3e-3)^5 a step, times 2000 steps.
    ripple = 1e-9 * kept[0]
    assert np.ptp(kept) < ripple
    assert np.diff(lost).max() < ripple
    assert lost[-1] < 0.95 * lost[0]


def test_without_a_coefficient_the_paddle_sheds_nothing() -> None:
    spec = mujoco.MjSpec.from_string(BENCH)
    # Its edge is not told, and need not be.
    Thrust(body="paddle").edit(spec)
    numbers = spec.compile().body("paddle").user
    assert numbers[0] == SIGNATURE
    assert not numbers[2:].any()
