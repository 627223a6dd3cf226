"""Every element of URDF is taken over as it stands, or named."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from morph.body.numbers import rotation
from morph.body.spec import spec_of

LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


@given(*[st.floats(-10, 10)] * 3)
def test_roll_pitch_and_yaw_turn_about_the_fixed_axes(r: float, p: float, y: float) -> None:
    # scipy's small letters: extrinsic, about the fixed axes x, y, z in turn.
    expected = Rotation.from_euler("xyz", (r, p, y)).as_matrix()
    assert rotation(r, p, y) == pytest.approx(expected, abs=1e-14)


def test_an_inertia_is_turned_with_its_frame(bench: Any) -> None:
    link = bench.link("a", mass=2.0, moments=(0.3, 0.2, 0.15, 0.01, 0.02, 0.03)).replace(
        'origin xyz="0 0 0"', 'origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"'
    )
    found = bench.read(link).robot.link("a")
    turn = Rotation.from_euler("xyz", (0.4, -0.5, 0.6)).as_matrix()
    given_ = np.array([[0.3, 0.01, 0.02], [0.01, 0.2, 0.03], [0.02, 0.03, 0.15]])
    expected = turn @ given_ @ turn.T
    order = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
    assert found.inertia == pytest.approx(tuple(expected[order]), abs=1e-14)
    assert found.com == (0.1, 0.2, 0.3)


def test_limits_dynamics_and_speed_are_taken_over(bench: Any) -> None:
    reading = bench.read(
        bench.link("a"),
        bench.link("b"),
        bench.joint(
            *("j", "a", "b", "revolute"),
            '<limit lower="-1.25" upper="0.5" effort="7" velocity="3"/>',
            '<dynamics damping="0.2" friction="0.1"/>',
        ),
    )
    joint = reading.robot.joint("j")
    assert (joint.limits, joint.effort, joint.velocity) == ((-1.25, 0.5), 7.0, 3.0)
    model = spec_of(reading.robot).compile()
    assert model.jnt_range[0] == pytest.approx([-1.25, 0.5], abs=0)
    assert model.jnt_limited[0] == 1
    assert model.jnt_actfrcrange[0] == pytest.approx([-7, 7], abs=0)
    assert model.dof_damping.ravel()[0] == 0.2
    assert model.dof_frictionloss[0] == 0.1


def test_a_continuous_joint_has_no_range_even_if_one_is_written(bench: Any) -> None:
    reading = bench.read(
        bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", "continuous", LIMIT)
    )
    assert reading.robot.joint("j").limits is None


def test_colours_come_from_the_shape_or_from_a_material_by_its_name(bench: Any) -> None:
    sphere = '<geometry><sphere radius="0.1"/></geometry>'
    reading = bench.read(
        '<material name="red"><color rgba="1 0 0 1"/></material>',
        '<link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
        f'<visual>{sphere}<material name="red"/></visual>'
        f'<visual>{sphere}<material name="own"><color rgba="0 0.5 1 0.25"/></material></visual>'
        f'<visual>{sphere}<material name="nowhere"/></visual></link>',
    )
    model = spec_of(reading.robot).compile()
    assert model.geom_rgba[0] == pytest.approx([1, 0, 0, 1])
    assert model.geom_rgba[1] == pytest.approx([0, 0.5, 1, 0.25])
    assert model.geom_rgba[2, 3] == 1


def test_shapes_keep_their_sizes_and_places(bench: Any) -> None:
    shapes = {
        "box": ('size="0.2 0.4 0.6"', (0.1, 0.2, 0.3)),
        "sphere": ('radius="0.1"', (0.1,)),
        "cylinder": ('radius="0.1" length="0.4"', (0.1, 0.2)),
        "capsule": ('radius="0.1" length="0.4"', (0.1, 0.2)),
    }
    held = "".join(
        f'<visual><origin xyz="0.1 {at} 0.3" rpy="0.1 0.2 0.3"/>'
        f"<geometry><{kind} {size}/></geometry></visual>"
        for at, (kind, (size, _)) in enumerate(shapes.items())
    )
    reading = bench.read(bench.link("a", held))
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    turn = Rotation.from_euler("xyz", (0.1, 0.2, 0.3)).as_matrix()
    for at, (_, half) in enumerate(shapes.values()):
        # MuJoCo states half edges and half lengths.
        assert model.geom_size[at][: len(half)] == pytest.approx(half)
        assert data.geom_xpos[at] == pytest.approx([0.1, at, 0.3])
        assert data.geom_xmat[at].reshape(3, 3) == pytest.approx(turn)


def test_an_axis_that_is_no_unit_vector_is_told_and_brought_to_one(bench: Any) -> None:
    reading = bench.read(bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", axis="0 3 4"))
    assert reading.stands("joint-axis", "repaired", "joint", "j")
    assert reading.robot.joint("j").axis == pytest.approx((0.0, 0.6, 0.8))


def test_an_axis_without_a_direction_is_refused(bench: Any) -> None:
    reading = bench.read(bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", axis="0 0 0"))
    assert reading.robot is None
    assert reading.stands("joint-axis", "refused", "joint", "j")


def test_a_weld_needs_no_axis(bench: Any) -> None:
    weld = bench.joint("j", "a", "b", "fixed", axis="0 0 0")
    assert bench.read(bench.link("a"), bench.link("b"), weld).findings == ()


@pytest.mark.parametrize("kind", ["", "hinge", "revolut", "Revolute", "ball", "screw"])
def test_a_kind_of_joint_that_nobody_knows_is_refused_with_the_nearest(
    bench: Any, kind: str
) -> None:
    reading = bench.read(bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", kind))
    assert reading.robot is None
    assert reading.stands("joint-kind", "refused", "joint", "j")
    if kind == "revolut":
        assert "write revolute" in reading.the("joint-kind").fix


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ('mass value="1.0"', 'mass value="one"'),
        ('mass value="1.0"', 'mass value="1,5"'),
        ('mass value="1.0"', 'mass value="nan"'),
        ('mass value="1.0"', 'mass value="inf"'),
        ('mass value="1.0"', 'mass value="1_0"'),
        ('mass value="1.0"', 'mass value="0x10"'),
        ('mass value="1.0"', 'mass value="1 2"'),
        ('mass value="1.0"', 'mass value="\u0661"'),
        ('ixx="0.01"', 'ixx="${m}"'),
        ('origin xyz="0 0 0"', 'origin xyz="0 0"'),
        ('origin xyz="0 0 0"', 'origin xyz="0 0 0 0_1"'),
        ('origin xyz="0 0 0"', 'origin xyz="0,0,0"'),
        ('origin xyz="0 0 0"', 'origin xyz="0 0 1e99"'),
        ('origin xyz="0 0 0"', 'origin rpy="0 0 nan"'),
    ],
)
def test_what_is_no_number_is_refused_at_its_link(bench: Any, right: str, wrong: str) -> None:
    bad = bench.link("bad", com="0 0 0").replace(right, wrong)
    assert wrong in bad
    reading = bench.read(bench.link("good"), bad, bench.joint("j", "good", "bad"))
    assert reading.robot is None
    assert reading.stands("ill-typed", "refused", "link", "bad")


def test_every_attribute_that_is_no_number_is_named_at_once(bench: Any) -> None:
    wrong = bench.link("a").replace('"1.0"', '"heavy"')
    reading = bench.read(
        wrong, bench.link("b"), bench.joint("j", "a", "b", xyz="here"), bench.link("c")
    )
    assert [f.where.name for f in reading.of("ill-typed")] == ["a", "j"]


@pytest.mark.parametrize("blank", ["", " ", "\n"])
def test_a_blank_attribute_has_its_default(bench: Any, blank: str) -> None:
    joint = bench.joint("j", "a", "b", xyz=blank)
    reading = bench.read(bench.link("a"), bench.link("b"), joint)
    assert reading.findings == ()


def test_a_misspelt_element_is_told_once_at_its_line(bench: Any) -> None:
    spelt = bench.link("b").replace("inertial>", "inertail>")
    reading = bench.read(bench.link("a"), spelt, bench.joint("j", "a", "b", "fixed"), "<jiont/>")
    assert [(f.where.name, f.where.line) for f in reading.of("unknown-element")] == [
        ("robot", reading.line("<jiont/>")),
        ("b", reading.line('<link name="b"')),
    ]
    assert all(f.severity == "info" for f in reading.of("unknown-element"))


def test_a_second_inertial_is_told_and_the_first_taken(bench: Any) -> None:
    second = '<inertial><mass value="50"/></inertial>'
    doubled = bench.link("b").replace("</inertial>", f"</inertial>\n{second}")
    reading = bench.read(bench.link("a"), doubled, bench.joint("j", "a", "b", "fixed"))
    assert reading.stands("unknown-element", "repaired", "link", "b", second)
    alone = bench.read(bench.link("a"), bench.link("b"), bench.joint("j", "a", "b", "fixed"))
    assert alone.findings == ()
    assert [link.mass for link in reading.robot.links] == [link.mass for link in alone.robot.links]


@pytest.mark.parametrize("held", ["<geometry><cone/></geometry>", "<geometry/>", "<origin/>"])
def test_a_shape_that_is_none_is_told_and_left_out(bench: Any, held: str) -> None:
    shape = f"<collision>{held}</collision>"
    link = bench.link("b").replace("</link>", f"\n{shape}\n</link>")
    reading = bench.read(bench.link("a"), link, bench.joint("j", "a", "b", "fixed"))
    assert reading.stands("unknown-element", "repaired", "link", "b", shape)


@pytest.mark.parametrize(
    ("lower", "upper", "done"),
    [("", " ", "it was taken as free to move"), ("-1", "", "upper was taken as 0")],
)
def test_a_blank_limit_is_told(bench: Any, lower: str, upper: str, done: str) -> None:
    limit = f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/>'
    joint = (
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>\n'
        f'<axis xyz="0 0 1"/>\n{limit}\n</joint>'
    )
    reading = bench.read(bench.link("a"), bench.link("b"), joint)
    assert reading.stands("limit-range", "info", "joint", "j", limit)
    assert reading.the("limit-range").done == done
    (moving,) = reading.robot.joints
    assert moving.limits == (None if done.endswith("move") else (-1.0, 0.0))


def test_elements_of_other_programs_are_left_alone(bench: Any) -> None:
    reading = bench.read(
        bench.link("a"),
        '<gazebo reference="a"><material>Gazebo/Red</material></gazebo>',
        '<transmission name="t"><joint name="j"><hardwareInterface>x</hardwareInterface></joint>'
        "</transmission>",
        "<drake:declare_convex/>",
        "<ros2_control><link/></ros2_control>",
    )
    assert reading.findings == ()


@pytest.mark.parametrize("element", ["<link/>", '<link name=""/>', '<link name=" "/>', "<joint/>"])
def test_a_part_without_a_name_is_refused(bench: Any, element: str) -> None:
    reading = bench.read(bench.link("a"), element)
    assert reading.robot is None
    assert reading.the("file-refused").where.line == reading.line(element)
    assert "has no name" in reading.the("file-refused").what


@pytest.mark.parametrize(
    "name", ["a b", "a/b", "ünïcødé", "a'b", "a&amp;b", "&lt;a&gt;", "x" * 190]
)
def test_names_may_hold_any_letter(bench: Any, name: str) -> None:
    reading = bench.read(
        bench.link("base"), bench.link(name), bench.joint(f"to {name}", "base", name)
    )
    assert reading.findings == ()
    shown = name.replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">")
    model = spec_of(reading.robot).compile()
    assert model.body(shown).id == 2
