"""Standing: soles on a floor, statics by moments, and springs that hold the posture there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.standing import StandingPosture, standing
from morph.sim.start import started
from tests.morph.body.disguise import disguised

ASSETS = Path(gymnasium.__file__).parent / "envs/mujoco/assets"
SHELF = ("humanoid", "quadruped_printed", "quadruped_four_bar", "biped", "hopper")
REAL = ("solo/resources/solo12.urdf", "urma_hexapod/hexapod.xml")


def found_of(robot: Robot) -> StandingPosture:
    found = standing(robot)
    assert found is not None
    return found


def placed(robot: Robot, found: StandingPosture, *, margin: float = 0.0) -> tuple[Any, Any]:
    """Return a robot in its posture above a floor at height 0, whose contacts begin at a margin."""
    spec = spec_of(robot)
    for geom in spec.worldbody.geoms:
        spec.delete(geom)
    floor = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[9.0, 9.0, 0.1])
    floor.contype = floor.conaffinity = 1
    floor.margin = margin
    model: Any = spec.compile()
    data = mujoco.MjData(model)
    data.qpos, _ = started(robot, model, found.position)
    mujoco.mj_forward(model, data)
    return model, data


def check_placed(robot: Robot, found: StandingPosture) -> None:
    """Check that the lowest contact is within 5 mm of the floor and no joint beyond its limits."""
    model, data = placed(robot, found, margin=0.05)
    gaps = [each.dist for each in data.contact[: data.ncon] if 0 in model.geom_bodyid[each.geom]]
    assert gaps
    # MuJoCo pushes from the margins on: an ant's is 0.01 m, and that of its own floor as much.
    own = float(spec_of(robot).compile().geom_margin.max(initial=0.0))
    assert abs(min(gaps) - 2.0 * own) < 0.005
    for at in np.flatnonzero(model.jnt_limited):
        low, high = model.jnt_range[at]
        assert low - 1e-6 <= data.qpos[model.jnt_qposadr[at]] <= high + 1e-6


def sunk(robot: Robot, found: StandingPosture, seconds: float) -> float:
    """Return how far a robot sinks that springs hold in its posture, in its height."""
    model, data = placed(robot, found)
    driven = [model.joint(name) for name in robot.driven]
    dofs = [int(joint.dofadr[0]) for joint in driven]
    places = [int(joint.qposadr[0]) for joint in driven]
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    model.opt.timestep = 0.0005
    rest, before = data.qpos[places].copy(), float(data.subtree_com[0, 2])
    # At 20 Hz and nearly critical, about the body's own inertia.
    k = float(np.sum(model.body_mass)) * before**2 * (2.0 * np.pi * 4.0) ** 2
    while data.time < seconds:
        spring = k * (rest - data.qpos[places]) - 0.02 * k * data.qvel[dofs]
        data.qfrc_applied[dofs] = spring
        mujoco.mj_step(model, data)
    return (before - float(data.subtree_com[0, 2])) / before


@pytest.mark.parametrize("body", [*SHELF, ASSETS / "ant.xml", ASSETS / "walker2d.xml"])
def test_a_robot_on_its_feet_touches_the_floor_within_its_limits(body: str | Path) -> None:
    robot = load(body)
    found = found_of(robot)
    check_placed(robot, found)
    assert found.balanced
    assert not found.lacking


@pytest.mark.parametrize("path", REAL)
def test_real_robots_stand_on_their_feet(path: str, real_robots: Path) -> None:
    base = "floating" if path.endswith(".urdf") else None
    robot = load(real_robots / path, base=base)
    found = found_of(robot)
    check_placed(robot, found)
    assert found.balanced
    assert not found.lacking


def test_efforts_are_the_moments_of_what_stands_above_each_joint() -> None:
    robot = load("hopper")
    found = found_of(robot)
    model, data = placed(robot, found)
    above = {"hip": ["torso"], "knee": ["torso", "thigh"], "ankle": ["torso", "thigh", "leg"]}
    for joint, links in above.items():
        at = model.joint(joint).id
        moment = sum(
            9.81
            * float(model.body_mass[model.body(link).id])
            * (data.xipos[model.body(link).id, 0] - data.xanchor[at, 0])
            for link in links
        )
        # One foot: the force acts below the centre of mass, and nothing is left to choose.
        assert abs(found.effort[joint]) == pytest.approx(abs(moment), abs=1e-6)


def test_motors_that_are_too_weak_are_named_with_what_they_lack() -> None:
    robot = load("hopper")
    needed = found_of(robot).effort
    weak = replace(robot, actuators=tuple(replace(each, limit=1.0) for each in robot.actuators))
    lacking = found_of(weak).lacking
    assert {name for name, each in needed.items() if abs(each) > 1.0} == set(lacking)


def test_two_points_hold_nothing_up() -> None:
    assert not found_of(load(ASSETS / "humanoid.xml")).balanced


TABLE = """<mujoco model="table"><worldbody><body pos="0 0 0.5"><freejoint name="base"/>
<geom type="box" size="0.3 0.2 0.05" mass="5"/><geom type="sphere" size="0.02" pos="{lead} 0 0"
mass="5"/>{legs}</body></worldbody><actuator>{servos}</actuator></mujoco>"""
LEG = """<body pos="{x} {y} 0"><joint name="hip{n}" axis="0 1 0" range="-90 90"/>
<geom type="capsule" fromto="0 0 -0.05 0 0 -0.25" size="0.02" mass="0.2"/><body pos="0 0 -0.25">
<joint name="knee{n}" axis="0 1 0" range="-90 90"/>
<geom type="capsule" fromto="0 0 -0.02 0 0 -0.25" size="0.02" mass="0.1"/></body></body>"""


@pytest.mark.parametrize(("lead", "computed"), [(0.0, False), (0.2, False), (0.5, True)])
def test_servos_carry_a_mass_near_the_edge_on_moved_legs(
    lead: float, computed: bool, tmp_path: Path
) -> None:
    corners = [(x, y) for x in (0.25, -0.25) for y in (0.15, -0.15)]
    legs = "".join(LEG.format(x=x, y=y, n=n) for n, (x, y) in enumerate(corners))
    servos = "".join(
        f'<position joint="{joint}{n}" kp="200" kv="5"/>' for joint in ("hip", "knee")
        for n in range(4)
    )  # fmt: skip
    (tmp_path / "table.xml").write_text(TABLE.format(lead=lead, legs=legs, servos=servos))
    found = found_of(load(tmp_path / "table.xml"))
    # Half of the 11.2 kg, but for the legs, is at `lead`: 0.45 of it, to 0.25 m at the edge, is
    # 0.36 of the way there for 0.2 m and 0.9 for 0.5 m; from 0.6 on the legs move.
    assert found.balanced
    assert found.computed is computed


def test_what_is_bolted_down_or_lies_on_its_belly_has_no_feet() -> None:
    for body in ("so101", "cartpole", "sea_snake", "hexapod_swimmer"):
        assert standing(load(body)) is None


@pytest.mark.parametrize("body", ["quadruped_printed", ASSETS / "ant.xml"])
def test_springs_about_the_posture_hold_it(body: str | Path) -> None:
    robot = load(body)
    assert sunk(robot, found_of(robot), 1.0) < 0.05


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("body", ["biped", ASSETS / "ant.xml"])
def test_names_and_axes_change_no_posture(body: str | Path, seed: int, tmp_path: Path) -> None:
    before = load(body)
    after, names = disguised(before, tmp_path, seed)
    one, other = found_of(before).position, found_of(after).position
    # Rounded to 1e-3 rad each; axes may have turned.
    told = {names.get(name.partition(".")[0], name): abs(value) for name, value in other.items()}
    for name, value in one.items():
        assert told[name.partition(".")[0]] == pytest.approx(abs(value), abs=0.0021)


WHEELED = """<mujoco model="cart"><worldbody><body name="cart" pos="0 0 0.3"><freejoint/>
<geom type="box" size="0.3 0.2 0.05" mass="5"/>WHEELS</body></worldbody>
<actuator>MOTORS</actuator></mujoco>"""


def test_wheels_stay_as_they_are_described(tmp_path: Path) -> None:
    places = [(x, y) for x in (0.2, -0.2) for y in (0.25, -0.25)]
    wheels = "".join(
        f'<body name="w{at}" pos="{x} {y} -0.05"><joint name="j{at}" axis="0 1 0"/>'
        '<geom type="cylinder" size="0.1 0.02" zaxis="0 1 0" mass="0.3"/></body>'
        for at, (x, y) in enumerate(places)
    )
    motors = "".join(f'<motor joint="j{at}" ctrlrange="-1 1"/>' for at in range(4))
    text = WHEELED.replace("WHEELS", wheels).replace("MOTORS", motors)
    (tmp_path / "cart.xml").write_text(text)
    found = found_of(load(tmp_path / "cart.xml"))
    # Its wheels end 0.15 m below its middle.
    assert found.position == {"cart.position.z": pytest.approx(0.15)}
    assert not found.computed
