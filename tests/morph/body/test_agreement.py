from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body import shelf
from morph.body.agreement import (
    TOLERANCE,
    difference,
    disagreement,
    read_by_mujoco,
    read_by_pinocchio,
)
from morph.body.finding import DescriptionFinding, Where
from morph.body.load import load
from morph.body.robot import Robot

BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())

TWO_BARS = """<robot name="two bars">
<link name="world"/>
<link name="upper"><inertial><origin xyz="0 0 -0.3"/><mass value="2"/>
<inertia ixx="0.06" iyy="0.06" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="world"/><child link="upper"/>
<axis xyz="0 1 0"/></joint>
<joint name="elbow" type="{kind}"><origin xyz="0 0 -0.6"/><parent link="upper"/>
<child link="lower"/><axis xyz="0 1 0"/>{more}</joint>
</robot>"""


def two_bars(folder: Path, kind: str = "continuous", more: str = "") -> Robot:
    """Return a double pendulum whose inertia is known in closed form."""
    (folder / "robot.urdf").write_text(TWO_BARS.format(kind=kind, more=more))
    return load(folder / "robot.urdf")


def tampered(robot: Robot, pattern: str, factor: float) -> Robot:
    """Return a robot that MuJoCo is given with the numbers of one attribute scaled."""

    def scaled(found: re.Match[str]) -> str:
        return found[1] + " ".join(repr(float(word) * factor) for word in found[2].split())

    text, count = re.subn(rf"({pattern})([-+\d.e ]+)", scaled, robot.mjcf, count=1)
    assert count == 1
    return replace(robot, mjcf=text)


@pytest.mark.parametrize("name", BODIES)
def test_the_two_agree_about_every_body_of_the_shelf(name: str) -> None:
    robot = load(name)
    assert difference(read_by_mujoco(robot), read_by_pinocchio(robot)) < TOLERANCE
    assert disagreement(robot) == []


def test_both_read_what_the_textbook_says(tmp_path: Path) -> None:
    robot = two_bars(tmp_path)
    # Straight down: M22 = I2 + m2 c2^2 = 0.02 + 0.04; M12 = M22 + m2 l1 c2 = 0.06 + 0.12;
    # M11 = I1 + m1 c1^2 + I2 + m2 (l1 + c2)^2 = 0.06 + 0.18 + 0.02 + 0.64.
    known = np.linalg.eigvalsh([[0.90, 0.18], [0.18, 0.06]])
    for reading in (read_by_mujoco(robot), read_by_pinocchio(robot)):
        assert reading.mass == pytest.approx(3.0, abs=1e-12)
        # (2 * -0.3 + 1 * -0.8) / 3
        assert reading.com == pytest.approx([0, 0, -1.4 / 3], abs=1e-12)
        assert reading.eigenvalues == pytest.approx(known, abs=1e-12)


@pytest.mark.parametrize("pattern", [r'mass="', r'diaginertia="', r'<inertial pos="'])
@pytest.mark.parametrize("factor", [1 + 1e-6, 1 - 1e-6])
def test_a_millionth_of_one_number_is_a_finding(
    pattern: str, factor: float, tmp_path: Path
) -> None:
    (finding,) = disagreement(tampered(two_bars(tmp_path), pattern, factor))
    assert (finding.code, finding.severity) == ("agreement", "info")
    assert finding.where == Where(
        kind="robot", name="two bars", file=str(tmp_path / "robot.urdf"), line=0
    )
    # The changed part of the mass, the centre or the inertia is at least a tenth of the whole.
    assert float(re.search(r"differ by (\S+) of", finding.what)[1]) > 1e-8  # type: ignore[index]


def test_rounding_is_no_finding(tmp_path: Path) -> None:
    # A tenth of the tolerance, times a part of the whole that is at most one.
    assert disagreement(tampered(two_bars(tmp_path), r'mass="', 1 + 1e-10)) == []


def test_a_joint_that_is_lost_is_a_finding(tmp_path: Path) -> None:
    robot = two_bars(tmp_path)
    text = re.sub(r'<joint name="elbow"[^>]*/>', "", robot.mjcf)
    text = re.sub(r"<actuator>.*</actuator>", "", text, flags=re.DOTALL)
    assert text != robot.mjcf
    (finding,) = disagreement(replace(robot, mjcf=text))
    assert "different numbers of degrees of freedom" in finding.what


def test_a_repair_explains_a_difference(tmp_path: Path) -> None:
    robot = tampered(two_bars(tmp_path), r'mass="', 1.5)
    repair = DescriptionFinding(
        code="mass-missing",
        severity="repaired",
        where=Where(kind="link", name="lower", file=""),
        what="it had none",
        fix="weigh it",
    )
    assert disagreement(replace(robot, findings=(repair,))) == []
    for other in (replace(repair, severity="info"), replace(repair, code="mesh-missing")):
        assert len(disagreement(replace(robot, findings=(other,)))) == 1


def test_the_axis_that_was_repaired_is_the_same_to_both(tmp_path: Path) -> None:
    robot = two_bars(tmp_path)
    text = (tmp_path / "robot.urdf").read_text().replace('xyz="0 1 0"', 'xyz="0 3 0"')
    (tmp_path / "robot.urdf").write_text(text)
    longer = load(tmp_path / "robot.urdf")
    assert {finding.code for finding in longer.findings} >= {"joint-axis"}
    assert disagreement(longer) == []
    assert read_by_mujoco(longer).eigenvalues == pytest.approx(read_by_mujoco(robot).eigenvalues)


def test_what_pinocchio_cannot_read_is_told_and_read_as_morph_repaired_it(
    tmp_path: Path,
) -> None:
    # Pinocchio refuses a negative effort limit; MuJoCo simulates the joint without one.
    robot = two_bars(tmp_path, "revolute", '<limit lower="-1" upper="1" effort="-3" velocity="1"/>')
    (finding,) = disagreement(robot)
    assert "Pinocchio cannot read the file" in finding.what
    assert "min_effort" in finding.what
    assert "agrees with MuJoCo" in finding.done


def test_where_a_free_base_stands_makes_no_difference(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><body name='a' pos='1 2 3' euler='10 20 30'><freejoint/>"
        "<geom type='box' size='0.1 0.2 0.3' pos='0.1 0 0'/></body></worldbody></mujoco>"
    )
    robot = load(tmp_path / "robot.xml")
    assert disagreement(robot) == []
    for reading in (read_by_mujoco(robot), read_by_pinocchio(robot)):
        assert reading.com == pytest.approx([0.1, 0, 0], abs=1e-12)


def test_rotors_are_of_both_or_of_none() -> None:
    # Pinocchio's URDF knows no armature, MuJoCo's body does: neither counts here.
    robot = load("so101")
    assert 'armature="' in robot.mjcf
    assert disagreement(robot) == []


def test_what_names_shapes_keeps_them(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(
        """<mujoco model="touched"><asset>
        <mesh name="wedge" vertex="0 0 0 0.1 0 0 0 0.1 0 0 0 0.1"/></asset><worldbody>
        <geom name="floor" type="plane" size="1 1 1"/>
        <body name="arm"><joint name="hinge" axis="0 1 0"/><geom name="tip" type="mesh" mesh="wedge"
        mass="1"/><geom name="round" size="0.01" mass="0.1"/></body></worldbody>
        <contact><pair geom1="floor" geom2="tip"/></contact>
        <sensor><framepos name="seen" objtype="geom" objname="tip"/></sensor></mujoco>"""
    )
    robot = load(tmp_path / "robot.xml")
    assert read_by_mujoco(robot).mass == pytest.approx(1.1, abs=1e-12)
    assert disagreement(robot) == []
