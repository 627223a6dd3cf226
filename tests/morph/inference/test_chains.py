"""A crank and rocker joined by a rod, moved by their own equation, without MuJoCo or morph."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import RecordingError
from morph.inference.diagnose import diagnose
from morph.model.chain_closure import with_chains
from morph.physics.dynamics import accelerations, closed, jacobians
from morph.record.recording import Channel, Recording

GROUND, CRANK, ROD, ROCKER = 0.30, 0.10, 0.28, 0.20
"""Lengths, m; by Grashof's rule the crank turns all the way round."""
MASSES, GRAVITY = (0.4, 0.3, 0.5), 9.81
"""Of thin rods, kg, each with its centre in the middle: inertia m l^2 / 12 about it."""
HOME = -1.2
"""Angle of the crank at which the description has it, rad."""
DAMPING = 0.02
"""Of the crank, N m s/rad."""
STEP, FINE = 0.004, 20
NUDGE = 1e-5


def angles(crank: Array) -> Array:
    """Return the angles of crank, rod and rocker from the ground, rad, (3, ...): two circles."""
    crank = np.asarray(crank, dtype=float)
    x, z = CRANK * np.cos(crank) - GROUND, CRANK * np.sin(crank)
    away = np.hypot(x, z)
    rocker = np.arctan2(z, x) - np.arccos((away**2 + ROCKER**2 - ROD**2) / (2.0 * away * ROCKER))
    rod = np.arctan2(ROCKER * np.sin(rocker) - z, ROCKER * np.cos(rocker) - x)
    return np.stack([crank, np.unwrap(rod, axis=-1) if rod.ndim else rod, rocker])


def centres(crank: Array) -> Array:
    """Return where the three rods' centres are, m, (3, 2, ...)."""
    first, second, third = (np.stack([np.cos(a), np.sin(a)]) for a in angles(crank))
    base = np.zeros_like(first)
    base[0] = GROUND
    return np.stack(
        [0.5 * CRANK * first, CRANK * first + 0.5 * ROD * second, base + 0.5 * ROCKER * third]
    )


def inertia(crank: Array) -> Array:
    """Return the inertia that the crank feels, kg m2: twice the energy at 1 rad/s."""
    apart = 2.0 * NUDGE
    turning = angles(crank + NUDGE) - angles(crank - NUDGE)
    turning = (turning + np.pi) % (2.0 * np.pi) - np.pi
    moving = (centres(crank + NUDGE) - centres(crank - NUDGE)) / apart
    whole = np.zeros_like(np.asarray(crank, dtype=float))
    for m, length, move, turn in zip(
        MASSES, (CRANK, ROD, ROCKER), moving, turning / apart, strict=True
    ):
        whole = whole + m * (move**2).sum(axis=0) + m * length**2 / 12.0 * turn**2
    return whole


def height(crank: Array) -> Array:
    """Return the potential energy, J."""
    return np.asarray(
        sum(GRAVITY * m * at[1] for m, at in zip(MASSES, centres(crank), strict=True))
    )


# The crank's equation of motion is I qacc + I' qvel^2 / 2 = effort - V', tabulated over a turn.
GRID = np.linspace(-np.pi, np.pi, 2001)
TABLE = np.stack(
    [
        inertia(GRID),
        (inertia(GRID + 1e-3) - inertia(GRID - 1e-3)) / 2e-3,
        (height(GRID + NUDGE) - height(GRID - NUDGE)) / (2.0 * NUDGE),
    ]
)


def slope(crank: Array, rate: Array, effort: Array) -> Array:
    """Return the crank's acceleration without friction, rad/s2."""
    turned = (np.asarray(crank) + np.pi) % (2.0 * np.pi) - np.pi
    felt, grows, weighs = (np.interp(turned, GRID, row) for row in TABLE)
    return np.asarray((effort - DAMPING * rate - weighs - 0.5 * grows * rate**2) / felt)


def described() -> str:
    """Return the mechanism as MJCF, its zeros at `HOME`."""
    first, second, third = angles(np.array(HOME))

    def rod(length: float, mass: float) -> str:
        about = mass * length**2 / 12.0
        return (
            f'<inertial pos="{length / 2} 0 0" mass="{mass}" diaginertia="1e-6 {about} {about}"/>'
        )

    return f"""
    <mujoco model="crank_rocker"><compiler angle="radian"/><worldbody>
     <body name="crank" euler="0 {-first} 0"><joint name="crank" axis="0 -1 0" damping="{DAMPING}"/>
      {rod(CRANK, MASSES[0])}
      <body name="rod" pos="{CRANK} 0 0" euler="0 {first - second} 0">
       <joint name="rod" axis="0 -1 0"/>{rod(ROD, MASSES[1])}</body></body>
     <body name="rocker" pos="{GROUND} 0 0" euler="0 {-third} 0">
      <joint name="rocker" axis="0 -1 0"/>{rod(ROCKER, MASSES[2])}</body></worldbody>
     <equality><connect body1="rod" body2="rocker" anchor="{ROD} 0 0"/></equality>
     <actuator><motor name="motor" joint="crank" ctrlrange="-4 4"/></actuator></mujoco>"""


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    path: Path = tmp_path_factory.mktemp("rocker") / "rocker.xml"
    path.write_text(described())
    return load(path)


def joints(crank: Array) -> dict[str, Array]:
    """Return what the joints' sensors read, rad."""
    first, second, third = angles(crank)
    home = angles(np.array(HOME))
    between = second - first - (home[1] - home[0])
    between = np.unwrap(between) if between.ndim else between
    between = between - 2.0 * np.pi * np.round(between.flat[0] / (2.0 * np.pi))
    return {"crank": first - home[0], "rod": between, "rocker": third - home[2]}


def recorded(number: int, coulomb: float) -> Recording:
    """Return 8 s of the crank's encoder and its motor, with Coulomb friction at its joint, N m."""
    rng, time = np.random.default_rng(number), STEP * np.arange(2000)
    effort = sum(
        rng.uniform(0.04, 0.1) * np.sin(2.0 * np.pi * hertz * time + rng.uniform(0.0, 6.0))
        for hertz in rng.uniform(0.2, 2.0, 4)
    )
    crank, rate = HOME, 0.0
    read, step = [], STEP / FINE
    for now in effort:
        read.append(crank)
        for _ in range(FINE):
            rate += step * float(slope(crank, rate, now))
            felt = np.interp((crank + np.pi) % (2.0 * np.pi) - np.pi, GRID, TABLE[0])
            rate = np.sign(rate) * max(abs(rate) - step * coulomb / felt, 0.0)
            crank += step * rate
    value = np.array(read) - HOME + 2e-4 * rng.normal(size=len(time))
    channels = {
        "crank.position": Channel(time=time, value=value),
        "motor.command": Channel(time=time, value=effort, hold=True),
    }
    return Recording(name=f"run_{number}", channels=channels)


def test_a_closed_chain_moves_as_lagrange_says(robot: Robot) -> None:
    model, rng = spec_of(robot).compile(), np.random.default_rng(0)
    dofs = {name: int(model.joint(name).dofadr[0]) for name in ("crank", "rod", "rocker")}
    crank, rate, effort = rng.uniform(-3.0, 3.0, (3, 9))
    position, velocity = np.zeros((2, 9, 3))
    ahead, behind = joints(crank + NUDGE), joints(crank - NUDGE)
    for name, dof in dofs.items():
        position[:, dof] = joints(crank)[name]
        change = (ahead[name] - behind[name] + np.pi) % (2.0 * np.pi) - np.pi
        velocity[:, dof] = change / (2.0 * NUDGE) * rate
    found = accelerations(model, position, velocity, effort[:, None])
    # The table interpolates over steps of 3 mrad: (0.003)^2 / 8 of second derivatives near 10.
    exact = slope(crank, rate, effort)
    assert np.allclose(found[:, dofs["crank"]], exact, rtol=1e-4, atol=1e-3)
    mobility = jacobians(model, position, velocity, effort[:, None])[:, :, 6:]
    assert np.allclose(mobility[:, dofs["crank"], dofs["crank"]], 1.0 / inertia(crank), rtol=1e-6)
    # Positions that are off are moved to where the chain closes, and stay near.
    off = position + 1e-2 * rng.normal(size=position.shape)
    near = closed(model, off)
    again = joints(near[:, dofs["crank"]] + HOME)
    for name in ("rod", "rocker"):
        apart = again[name] - near[:, dofs[name]]
        assert np.abs((apart + np.pi) % (2.0 * np.pi) - np.pi).max() < 1e-6
    assert np.abs(near - off).max() < 0.1


def test_joints_that_no_sensor_read_are_where_the_chain_closes(robot: Robot) -> None:
    recording = recorded(0, 0.0)
    whole = with_chains(recording, robot)
    read = joints(recording["crank.position"] + HOME)
    for name in ("rod", "rocker"):
        assert whole.channels[f"{name}.position"].guess == 0.0
        # Gauss-Newton ends below 1e-9 m on rods of 0.1 m and more.
        apart = whole[f"{name}.position"] - read[name]
        assert np.abs((apart + np.pi) % (2.0 * np.pi) - np.pi).max() < 1e-7
    assert "follow from where closed chains close" in whole.notes[-1].what


def test_positions_at_which_no_chain_closes_are_refused(robot: Robot) -> None:
    recording = recorded(0, 0.0)
    rocker = replace(recording.channels["crank.position"], value=np.full(2000, 1.2))
    wrong = {**recording.channels, "rocker.position": rocker}
    with pytest.raises(RecordingError, match="mm open"):
        with_chains(replace(recording, channels=wrong), robot)


@pytest.mark.parametrize("coulomb", [0.0, 0.01])
def test_friction_in_a_closed_chain_is_named(robot: Robot, coulomb: float) -> None:
    found = diagnose(robot, [recorded(number, coulomb) for number in range(4)])
    named = [finding.effect.label for finding in found.findings]
    if not coulomb:
        assert (named, found.verdict) == ([], "consistent")
        return
    assert named == ["coulomb_friction@crank"]
    level = found.findings[0].parameters["c"]
    assert level.low90 < coulomb < level.high90


def test_a_gap_of_a_chain_that_turns_moves_it_little(tmp_path: Path) -> None:
    # Three rows of a pin hold a planar chain in two directions; where it is tilted all three seem
    # to count, and what contradicts them, in a frame that turns, must not be magnified.
    path = tmp_path / "turning.xml"
    frame = """<worldbody><body name="frame"><joint name="spin" axis="1 0 0"/>
     <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>"""
    turning = described().replace("<worldbody>", frame)
    path.write_text(turning.replace("</worldbody>", "</body></worldbody>"))
    model = spec_of(load(path)).compile()
    rng = np.random.default_rng(0)
    position = closed(model, rng.normal(size=(50, 4)) * [1e-3, 0.1, 0.1, 0.1])
    velocity, effort = 2.0 * rng.normal(size=(50, 4)), np.zeros((50, 1))
    at = accelerations(model, position, velocity, effort)
    beside = accelerations(model, position + 1e-5 * rng.normal(size=(50, 4)), velocity, effort)
    # Accelerations near 1e3 per s2 change by 1e-5 of that for each rad, a few times over.
    assert np.abs(beside - at).max() < 1e-3 * np.abs(at).max()
