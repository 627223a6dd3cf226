"""The judges of the corpus, on descriptions whose masses and repairs are known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from experiments.corpus_masses import judge_masses, stated_masses
from experiments.corpus_repairs import judge_difference
from morph.body.inspect import inspect_robot
from morph.body.robot import Robot

INERTIA = '<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
BROKEN = '<inertia ixx="0.01" iyy="0.01" izz="0.5" ixy="0" ixz="0" iyz="0"/>'
"""No body has a moment greater than the other two together."""


def inertial(mass: float, inertia: str = INERTIA) -> str:
    return f'<inertial><origin xyz="0.1 0 0"/><mass value="{mass}"/>{inertia}</inertial>'


def arm(folder: Path, upper: str, lower: str, more: str = "") -> Path:
    """Return a URDF of two links on a base, each on a hinge."""
    path = folder / "arm.urdf"
    path.write_text(f"""<robot name="arm"><link name="base">{inertial(1.0)}</link>
      <link name="upper">{upper}</link><link name="lower">{lower}</link>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="0.3 0 0"/><axis xyz="0 1 0"/></joint>{more}</robot>""")
    return path


def lighter(robot: Robot, name: str, share: float) -> Robot:
    links = tuple(
        replace(link, mass=link.mass * share) if link.name == name else link for link in robot.links
    )
    return replace(robot, links=links)


def test_masses_of_a_good_description_are_all_there(tmp_path: Path) -> None:
    path = arm(tmp_path, inertial(0.5), inertial(0.25))
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    told = judge_masses(path, found.robot, found.findings)
    assert (told.stated, told.named, told.silent, told.uncounted) == (1.75, 0, (), "")
    assert told.simulated == pytest.approx(1.75)


def test_a_link_that_gets_a_mass_is_named_by_its_finding(tmp_path: Path) -> None:
    path = arm(tmp_path, inertial(0.5), "")
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    told = judge_masses(path, found.robot, found.findings)
    assert (told.named, told.silent) == (1, ())
    assert told.simulated == pytest.approx(1.5 + 1e-6)


def test_a_repair_at_one_link_excuses_no_loss_at_another(tmp_path: Path) -> None:
    # The same file is repaired at `lower`, and `upper` loses a tenth of its mass.
    path = arm(tmp_path, inertial(0.5), "")
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    told = judge_masses(path, lighter(found.robot, "upper", 0.9), found.findings)
    assert told.named == 1
    assert "upper: 0.5 kg, simulated 0.45" in told.silent
    # What its links say is no longer what MuJoCo steps, and that is told too.
    assert len(told.silent) == 2


def test_a_repair_that_states_another_mass_than_is_simulated_excuses_nothing(
    tmp_path: Path,
) -> None:
    path = arm(tmp_path, inertial(0.5), "")
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    told = judge_masses(path, lighter(found.robot, "lower", 2.0), found.findings)
    assert told.named == 0
    assert any(line.startswith("lower: 0 kg, simulated 2e-06") for line in told.silent)


def test_an_inertia_that_was_mended_excuses_no_mass(tmp_path: Path) -> None:
    path = arm(tmp_path, inertial(0.5, BROKEN), inertial(0.25))
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    assert any(finding.code == "inertia-broken" for finding in found.findings)
    assert judge_masses(path, found.robot, found.findings).silent == ()
    told = judge_masses(path, lighter(found.robot, "upper", 0.9), found.findings)
    assert any(line.startswith("upper: 0.5 kg, simulated 0.45") for line in told.silent)


def test_masses_of_macros_and_of_mjcf_are_counted_too(tmp_path: Path) -> None:
    macro = tmp_path / "arm.urdf.xacro"
    macro.write_text(
        '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:property name="m" value="0.5"/>'
        '<link name="base"><inertial><mass value="${2 * m}"/></inertial></link></robot>'
    )
    assert stated_masses(macro) == {"base": 1.0}
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<mujoco><worldbody><body name="ball"><joint/><geom size="0.1" mass="3"/></body>'
        "</worldbody></mujoco>"
    )
    assert stated_masses(scene) == {"ball": 3.0}


def test_masses_that_only_a_missing_mesh_knows_are_not_counted_as_none(tmp_path: Path) -> None:
    scene = tmp_path / "scene.xml"
    shape = '<asset><mesh name="m" file="gone.stl"/></asset>'
    weighed = '<body name="arm"><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>'
    weighed += '<geom type="mesh" mesh="m"/></body>'
    scene.write_text(f"<mujoco>{shape}<worldbody>{weighed}</worldbody></mujoco>")
    assert stated_masses(scene) == {"arm": 2.0}
    bare = '<body name="arm"><geom type="mesh" mesh="m"/></body>'
    scene.write_text(f"<mujoco>{shape}<worldbody>{bare}</worldbody></mujoco>")
    with pytest.raises(ValueError, match="the shapes of arm state its mass"):
        stated_masses(scene)


@pytest.mark.parametrize(
    ("upper", "lower", "codes"),
    [
        (inertial(0.5), "", "mass-missing"),
        (inertial(0.5, BROKEN), inertial(0.25), "inertia-broken"),
        (inertial(0.5, BROKEN), "", "inertia-broken, mass-missing"),
        (inertial(0.5, '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'),
         inertial(0.25), "inertia-missing"),
    ],
)  # fmt: skip
def test_a_difference_that_the_named_repairs_make_is_explained_by_them(
    tmp_path: Path, upper: str, lower: str, codes: str
) -> None:
    path = arm(tmp_path, upper, lower)
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    assert judge_difference(path, found.robot, found.findings) == (True, codes)


def test_a_repair_elsewhere_in_the_file_explains_no_difference(tmp_path: Path) -> None:
    path = arm(tmp_path, inertial(0.5), "")
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    # The file that Pinocchio reads states another mass of `upper`, of which no finding speaks.
    path.write_text(path.read_text().replace('value="0.5"', 'value="0.6"'))
    assert judge_difference(path, found.robot, found.findings) == (False, "")


def test_a_repair_that_changes_nothing_explains_nothing(tmp_path: Path) -> None:
    empty = """<joint name="wrist" type="revolute"><parent link="lower"/><child link="hand"/>
      <axis xyz="0 1 0"/><limit lower="1" upper="-1" effort="1" velocity="1"/></joint>"""
    hand = f'<link name="hand">{inertial(0.1)}</link>'
    path = arm(tmp_path, inertial(0.5), inertial(0.25), empty + hand)
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    codes = {finding.code for finding in found.findings if finding.severity == "repaired"}
    # Limits taken the other way round change no inertia.
    assert codes == {"limit-range"}
    assert judge_difference(path, found.robot, found.findings) == (False, "")


def test_a_joint_that_was_welded_explains_another_number_of_freedoms(tmp_path: Path) -> None:
    empty = """<joint name="wrist" type="revolute"><parent link="lower"/><child link="hand"/>
      <axis xyz="0 1 0"/><limit lower="0" upper="0" effort="1" velocity="1"/></joint>
      <joint name="grip" type="revolute"><parent link="lower"/><child link="claw"/>
      <axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>"""
    ends = "".join(f'<link name="{name}">{inertial(0.1)}</link>' for name in ("hand", "claw"))
    path = arm(tmp_path, inertial(0.5), inertial(0.25), empty + ends)
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    assert judge_difference(path, found.robot, found.findings) == (True, "limit-range")


def test_a_stated_mass_stays_where_its_inertia_is_next_to_none(tmp_path: Path) -> None:
    # As of some links of the iCub: 0.746 kg, and moments of 1e-20 kg m2.
    faint = '<inertia ixx="1e-20" iyy="2e-20" izz="2e-20" ixy="0" ixz="0" iyz="0"/>'
    path = arm(tmp_path, inertial(0.5), inertial(0.746, faint))
    found = inspect_robot(path, second_opinion=False)
    assert found.robot is not None
    told = judge_masses(path, found.robot, found.findings)
    assert (told.named, told.silent) == (0, ())
    assert told.simulated == pytest.approx(1.0 + 0.5 + 0.746)
