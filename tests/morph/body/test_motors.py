"""Motors of cards and servos in the place of motors, beside closed forms and MuJoCo's own model."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco
import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.body.motors import with_servos
from morph.body.servo import SERVOS
from morph.body.spec import spec_of
from morph.errors import RobotError

GEARED = """<mujoco model="arm"><worldbody><body><joint name="one" axis="0 1 0" range="-90 90"/>
<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="0.5"/>
<body pos="0.4 0 0"><joint name="two" axis="0 1 0" range="-90 90"/>
<geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02" mass="0.1"/></body></body></worldbody>
<actuator><motor name="first" joint="one" gear="20" ctrlrange="-0.1 0.1"/>
<motor name="second" joint="two" gear="5" ctrlrange="-1 1"/></actuator></mujoco>"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    (tmp_path / "arm.xml").write_text(GEARED)
    return tmp_path / "arm.xml"


def settled(robot: Any) -> Any:
    """The state to which a robot comes whose commands are zero."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=10_000)
    return data


def test_a_servo_sags_by_the_load_over_its_gain(arm: Path) -> None:
    served = with_servos(load(arm), ["kp=500,kv=20", "two:kp=40,kv=2"])
    assert [each.kind for each in served.actuators] == ["position", "position"]
    assert [each.name for each in served.actuators] == ["first", "second"]
    data = settled(served)
    # The second link, 0.1 kg, hangs 0.1 m out: kp a = m g l cos(a + b), a and b both small.
    a, b = data.qpos
    outer = 0.1 * 9.81 * 0.1 * math.cos(a + b)
    whole = outer + (0.5 * 0.2 + 0.1 * 0.4) * 9.81 * math.cos(a)
    assert b == pytest.approx(outer / 40.0, rel=1e-4)
    assert a == pytest.approx(whole / 500.0, rel=1e-4)


def test_what_stands_later_goes_before_and_figures_replace_those_of_a_name(arm: Path) -> None:
    model = spec_of(with_servos(load(arm), ["MX-28", "one:MX-64,limit=2,friction=0.3"])).compile()
    known = {each.name: each for each in SERVOS}
    first, second = model.actuator("first"), model.actuator("second")
    assert (first.gainprm[0], second.gainprm[0]) == (known["MX-64"].kp, known["MX-28"].kp)
    assert first.forcerange.tolist() == [-2.0, 2.0]
    assert second.forcerange.tolist() == [-known["MX-28"].limit, known["MX-28"].limit]
    assert model.joint("one").frictionloss[0] == 0.3
    assert model.joint("one").armature[0] == known["MX-64"].armature
    assert (first.gear[0], bool(first.ctrllimited[0])) == (1.0, False)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("elbow:MX-28", "nothing drives a joint 'elbow'"),
        ("MX-29", "no motor model is called 'MX-29'"),
        ("kp=often", "says no servo"),
        ("kp=1,gain=2", "says no servo"),
        ("MX-28,MX-64", "says no servo"),
        ("kv=1", "has no kp"),
        ("kp=1,limit=0", "the limit of the motor of one is 0"),
        ("kp=-3", "kp of the motor of one is -3"),
        ("kp=nan", "kp of the motor of one is nan"),
        ("ideal,kp=3", "is ideal and has gains"),
    ],
)
def test_words_that_are_no_servo_are_refused(arm: Path, words: str, says: str) -> None:
    with pytest.raises(RobotError, match=says):
        with_servos(load(arm), [words])


def test_a_joint_with_two_actuators_gets_no_servo(tmp_path: Path) -> None:
    twice = GEARED.replace("</actuator>", '<velocity name="brake" joint="two" kv="1"/></actuator>')
    (tmp_path / "twice.xml").write_text(twice)
    robot = load(tmp_path / "twice.xml")
    with pytest.raises(RobotError, match="2 actuators drive the joint two"):
        with_servos(robot, ["kp=5"])
    assert with_servos(robot, ["one:kp=5"]).actuators[0].kind == "position"


def test_a_card_gives_a_servo_by_its_figures(tmp_path: Path, bench: Any) -> None:
    folder = tmp_path / "arm"
    folder.mkdir()
    path = bench.write(
        bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", axis="0 1 0")
    ).replace(folder / "arm.urdf")
    (folder / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "arm"\ntitle = "Arm"\nlicence = "MIT"\nbase = "fixed"\n'
        'description = "arm.urdf"\n[[source]]\nwhat = "all"\nfrom = "here"\nlicence = "MIT"\n'
        '[[motor]]\nactuator = "j"\nmodel = "servo"\nkp = 12.5\nkv = 0.5\nlimit = 3.0\n'
        "armature = 0.02\nfriction = 0.1\n"
    )
    model = spec_of(load(path)).compile()
    assert model.actuator("j").gainprm[0] == 12.5
    assert model.actuator("j").biasprm[1:3].tolist() == [-12.5, -0.5]
    assert model.joint("j").armature[0] == 0.02
    assert model.joint("j").frictionloss[0] == 0.1


def test_a_description_converted_with_servos_holds_them(arm: Path, tmp_path: Path) -> None:
    out = tmp_path / "served"
    assert main(["convert", str(arm), "--to", "mjcf", "--servo", "SG90", "--out", str(out)]) == 0
    model = mujoco.MjModel.from_xml_path(str(out / "robot.xml"))
    kp = next(each.kp for each in SERVOS if each.name == "SG90")
    assert model.actuator_gainprm[:, 0].tolist() == [kp, kp]


def test_every_servo_of_the_table_stops_turning_at_a_speed_that_servos_have() -> None:
    assert len({each.name for each in SERVOS}) == len(SERVOS)
    for each in SERVOS:
        # At no load the torque of kv is that at stall: 30 rev/min of a large one to 230.
        assert 2.0 < each.limit / each.kv < 25.0, each.name
