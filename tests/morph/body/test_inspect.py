from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import morph.app.cli.convert
import morph.body.inspect
from morph.body import shelf
from morph.body.finding import CODES, DescriptionFinding, Where
from morph.body.inspect import Inspection, inspect_robot

FOLDER = Path(morph.body.inspect.__file__).parent
SCHEMAS = {
    "morph.inspection/1": FOLDER / "inspection.schema.json",
    "morph.findings/1": FOLDER / "findings.schema.json",
    "morph.conversion/1": Path(morph.app.cli.convert.__file__).parent / "conversion.schema.json",
}
BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())


def schema(name: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(SCHEMAS[name].read_text())
    return content


VALIDATOR = jsonschema.Draft202012Validator(schema("morph.inspection/1"))


def as_json(found: Inspection) -> dict[str, Any]:
    """Return what `morph inspect --json` writes, through JSON that knows no NaN."""
    text = json.dumps(found.as_json(), allow_nan=False)
    content: dict[str, Any] = json.loads(text)
    VALIDATOR.validate(content)
    return content


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_one_and_says_its_name(name: str) -> None:
    content = schema(name)
    jsonschema.Draft202012Validator.check_schema(content)
    assert content["title"] == content["properties"]["schema"]["const"] == name
    assert content["$id"] == "urn:" + name.replace(".", ":").replace("/", ":")


def test_a_finding_is_the_same_in_both_schemas() -> None:
    one, other = (schema(f"morph.{which}/1")["$defs"] for which in ("inspection", "findings"))
    assert one["finding"] == other["finding"]
    assert set(one["finding"]["properties"]) == {field.name for field in fields(DescriptionFinding)}
    assert set(one["finding"]["properties"]["where"]["properties"]) == {
        field.name for field in fields(Where)
    }


@pytest.mark.parametrize("name", BODIES)
def test_a_body_of_the_shelf_is_as_its_card_says(name: str) -> None:
    found = inspect_robot(name)
    content = as_json(found)
    assert found.robot is not None
    assert found.robot.card is not None
    assert content["verdict"] == "ok"
    assert content["mass_kg"] == pytest.approx(found.robot.card.checks.mass_kg, abs=1e-9)
    assert content["dof"] == found.robot.card.checks.dof
    assert sum(link["mass_kg"] for link in content["links"]) == pytest.approx(content["mass_kg"])
    for key in ("links", "joints", "actuators", "sensors"):
        assert len(content[key]) == len(getattr(found.robot, key))
    assert len(content["closures"]) == len(found.robot.loops)


def test_a_body_is_what_was_drawn(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(
        '<robot name="crane"><link name="base"><inertial><mass value="3"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<visual><origin xyz="0.5 0 0"/><geometry><box size="1 0.2 0"/></geometry></visual>'
        '<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.2 0.2"/></geometry></collision>'
        '</link><joint name="slew" type="revolute"><origin xyz="0 0 2"/><parent link="base"/>'
        '<child link="arm"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="7" '
        'velocity="3"/></joint></robot>'
    )
    found = inspect_robot(tmp_path / "robot.urdf", base="fixed")
    content = as_json(found)
    assert (content["mass_kg"], content["dof"]) == (4.0, 1)
    # (3 * 0 + 1 * 0.5) / 4 along, and 1 * 2 / 4 up.
    assert content["com_m"] == pytest.approx([0.125, 0.0, 0.5], abs=1e-12)
    # The far upper corner of the arm: 1 along, 0.1 across, 2.1 up.
    assert content["reach_m"] == pytest.approx(math.sqrt(1 + 0.01 + 2.1**2), abs=1e-9)
    assert content["joints"] == [
        {
            "name": "slew",
            "kind": "hinge",
            "link": "arm",
            "axis": [0.0, 0.0, 1.0],
            "limits": [-1.0, 2.0],
            "effort": 7.0,
            "velocity": 3.0,
            "damping": 0.0,
            "friction": 0.0,
            "unit": "rad",
            "mimic": None,
        }
    ]
    assert content["links"][1]["shapes"] == ["collision box"]
    assert content["verdict"] == "repaired"
    assert [each["code"] for each in content["findings"]] == ["shape-size"]


def test_ground_is_no_part_of_a_reach(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><geom type='plane' size='50 50 1'/><geom type='box' size='9 9 9'/>"
        "<body name='ball' pos='0 0 5'><freejoint/><geom size='0.3'/></body></worldbody></mujoco>"
    )
    found = inspect_robot(tmp_path / "robot.xml")
    # The corner of the box around a ball of 0.3 m.
    assert found.reach == pytest.approx(0.3 * math.sqrt(3), abs=1e-9)


def test_closed_chains_are_shown() -> None:
    closures = as_json(inspect_robot("quadruped_four_bar"))["closures"]
    assert len(closures) == 8
    assert closures[0] == {
        "name": "front_left_hip_pin",
        "kind": "connect",
        "links": ["front_left_hip_rod", "front_left_thigh"],
    }


REFUSED: dict[str, Callable[[Path], Path]] = {
    "not there": lambda folder: folder / "gone.urdf",
    "a folder without a card": lambda folder: folder,
    "nothing in it": lambda folder: written(folder / "robot.urdf", b""),
    "binary": lambda folder: written(folder / "robot.urdf", bytes(range(256)) * 9),
    "cut off": lambda folder: written(folder / "robot.urdf", b"<robot><link"),
    "no robot": lambda folder: written(folder / "robot.urdf", b"<html/>"),
    "no link": lambda folder: written(folder / "robot.urdf", b"<robot name='r'/>"),
    "no mass": lambda folder: written(
        folder / "robot.xml",
        b"<mujoco><worldbody><body><joint/></body></worldbody></mujoco>",
    ),
    "another ending": lambda folder: written(folder / "robot.sdf", b"<sdf/>"),
}


def written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("why", REFUSED)
def test_what_is_no_robot_is_refused_by_the_schema(why: str, tmp_path: Path) -> None:
    content = as_json(inspect_robot(REFUSED[why](tmp_path)))
    assert content["verdict"] == "refused"
    assert (content["mass_kg"], content["com_m"], content["dof"]) == (None, None, 0)
    refused = [each for each in content["findings"] if each["severity"] == "refused"]
    assert refused
    assert all(each["what"] and each["fix"] and each["where"]["file"] for each in refused)


CORPUS = (
    "drake__atlas__urdf__robotiq_tendons",
    "matlab__movo_description__urdf__kinovaMovo",
    "oems__spot_boston_dynamics__spot_base_urdf__model",
    "random__robot-assets__fetch__robots__fetch",
    "random__spot_ros__spot_description__urdf__spot_arm",
    "robotics-toolbox__xacro_generated__pr2_description__robots__pr2",
)


@pytest.mark.parametrize("name", CORPUS)
def test_what_others_published_is_told_by_the_schema(name: str, real_robots: Path) -> None:
    content = as_json(inspect_robot(real_robots / "urdf_corpus" / f"{name}.urdf"))
    assert {each["code"] for each in content["findings"]} <= set(CODES)
    assert (content["verdict"] == "refused") == (name.endswith("spot_arm"))


@pytest.mark.parametrize("word", ["nan", "inf", "-inf", "1e999", "1e308", "-1e308", "1e-320"])
@pytest.mark.parametrize(
    "text",
    [
        "<mujoco><worldbody><body name='a' pos='0 0 {}'><joint name='j'/><geom size='1'/></body>"
        "</worldbody></mujoco>",
        "<mujoco><worldbody><body name='a'><joint name='j' range='0 {}'/><geom size='1'/></body>"
        "</worldbody><actuator><motor joint='j' ctrlrange='0 {}'/></actuator></mujoco>",
        "<mujoco><worldbody><body name='a'><joint name='j'/><geom size='1' mass='{}'/></body>"
        "</worldbody></mujoco>",
    ],
    ids=["position", "range", "mass"],
)
def test_no_number_that_json_lacks_comes_through(
    word: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # Where MuJoCo would write its log.
    path = written(tmp_path / "robot.xml", text.format(word, word).encode())
    content = as_json(inspect_robot(path))  # Raises if NaN or infinity is in it.
    assert content["verdict"] == "ok" or content["findings"]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["robot.xml"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"verdict": "refused"}, "is not of type 'null'|is too long|does not contain"),
        ({"mass_kg": None}, "None is not of type 'number'"),
        ({"extra": 1}, "Additional properties"),
        ({"com_m": [0.0, 1.0]}, "is not valid under any"),
        ({"verdict": "repaired"}, "does not contain items"),
    ],
    ids=["verdict", "mass", "extra", "com", "repaired"],
)
def test_the_schema_refuses_what_is_not_so(change: dict[str, Any], message: str) -> None:
    content = as_json(inspect_robot("pendulum"))
    with pytest.raises(jsonschema.ValidationError, match=message):
        VALIDATOR.validate({**content, **change})


def test_a_refused_folder_is_called_by_its_own_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "arm" / "urdf").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "arm" / "urdf")
    assert inspect_robot(".").name == "urdf"
    assert inspect_robot("..").name == "arm"
    assert inspect_robot("/").name == "/"
