"""Links and joints that make no single tree are named, and one that does is left alone."""

from __future__ import annotations

from typing import Any


def test_a_tree_is_left_alone(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abcd"),
        *(bench.joint(f"to_{child}", parent, child) for parent, child in ("ab", "ac", "cd")),
    )
    assert reading.findings == ()
    assert {link.name: link.parent for link in reading.robot.links} == {
        "a": "world",
        "b": "a",
        "c": "a",
        "d": "c",
    }


def test_the_order_in_which_links_and_joints_are_written_is_free(bench: Any) -> None:
    reading = bench.read(
        bench.joint("knee", "thigh", "shin"),
        bench.link("shin", mass=3.0),
        bench.joint("hip", "trunk", "thigh"),
        bench.link("thigh", mass=2.0),
        bench.link("trunk", mass=1.0),
    )
    assert reading.findings == ()
    assert reading.robot.link("shin").parent == "thigh"
    assert [joint.name for joint in reading.robot.joints] == ["hip", "knee"]


def test_two_links_of_one_name_are_refused_at_the_second(bench: Any) -> None:
    reading = bench.read(
        bench.link("a"), bench.link("b"), bench.link("b", mass=2.0), bench.joint("j", "a", "b")
    )
    assert reading.robot is None
    finding = reading.the("duplicate-name")
    assert (finding.severity, finding.where.kind, finding.where.name) == ("refused", "link", "b")
    assert finding.where.line == 4
    assert {found.code for found in reading.findings} == {"duplicate-name"}


def test_two_joints_of_one_name_get_two_names_and_both_move(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("j", "a", "b"),
        bench.joint("j", "a", "c"),
    )
    finding = reading.the("duplicate-name")
    assert (finding.severity, finding.where.name, finding.where.line) == ("repaired", "j", 6)
    names = {joint.link: joint.name for joint in reading.robot.joints}
    assert names["b"] == "j"
    assert names["c"] != "j"
    assert names["c"] in finding.done


def test_a_name_given_to_a_second_joint_is_not_one_that_a_third_bears(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abcd"),
        bench.joint("j", "a", "b"),
        bench.joint("j", "a", "c"),
        bench.joint("j_2", "a", "d"),
    )
    assert len({joint.name for joint in reading.robot.joints}) == 3
    assert reading.robot.joint("j_2").link == "d"


def test_a_link_and_a_joint_may_bear_one_name(bench: Any) -> None:
    reading = bench.read(bench.link("a"), bench.link("arm"), bench.joint("arm", "a", "arm"))
    assert reading.findings == ()
    assert reading.robot.joint("arm").link == "arm"


def test_a_joint_to_a_link_that_is_not_there_is_refused(bench: Any) -> None:
    for end, joint in {
        "child": bench.joint("j", "a", "nothing"),
        "parent": bench.joint("j", "nothing", "b"),
    }.items():
        reading = bench.read(bench.link("a"), bench.link("b"), joint)
        assert reading.robot is None
        assert reading.stands("dangling-joint", "refused", "joint", "j")
        assert "'nothing'" in reading.the("dangling-joint").what
        assert end in reading.the("dangling-joint").what
        assert {finding.code for finding in reading.findings} == {"dangling-joint"}


def test_a_joint_that_names_no_link_at_all_is_refused(bench: Any) -> None:
    reading = bench.read(bench.link("a"), bench.link("b"), '<joint name="j" type="fixed"/>')
    assert reading.robot is None
    assert {finding.code for finding in reading.findings} == {"dangling-joint"}
    assert all(finding.where.name == "j" for finding in reading.findings)


def test_joints_may_hang_from_a_world_that_was_not_described(bench: Any) -> None:
    reading = bench.read(bench.link("a"), bench.joint("j", "world", "a"))
    assert reading.stands("dangling-joint", "repaired", "joint", "j")
    assert reading.robot.mass == 1.0
    assert reading.robot.joint("j").kind == "hinge"


def test_a_world_that_hangs_from_the_robot_gets_another_name(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in ("a", "world", "world_2", "b")),
        bench.joint("aw", "a", "world"),
        bench.joint("wb", "world", "b"),
        bench.joint("aw_2", "a", "world_2"),
    )
    assert reading.stands("duplicate-name", "repaired", "link", "world")
    assert reading.robot.mass == 4.0
    assert reading.robot.link("b").parent == reading.robot.joint("aw").link


def test_links_in_a_circle_are_refused_and_the_circle_is_shown(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in ("base", "x", "y", "z")),
        bench.joint("xy", "x", "y"),
        bench.joint("yz", "y", "z"),
        bench.joint("zx", "z", "x"),
    )
    assert reading.robot is None
    finding = reading.the("cyclic-tree")
    assert finding.severity == "refused"
    assert finding.where.name in ("xy", "yz", "zx")
    assert finding.where.line == reading.line(f'<joint name="{finding.where.name}"')
    assert all(name in finding.what for name in "xyz")


def test_a_link_that_hangs_from_itself_is_a_circle(bench: Any) -> None:
    reading = bench.read(bench.link("base"), bench.link("x"), bench.joint("self", "x", "x"))
    assert reading.robot is None
    assert reading.stands("cyclic-tree", "refused", "joint", "self")


def test_a_link_with_two_parents_is_refused_at_the_second_joint(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("ab", "a", "b"),
        bench.joint("ac", "a", "c"),
        bench.joint("bc", "b", "c"),
    )
    assert reading.robot is None
    assert reading.stands("cyclic-tree", "refused", "joint", "bc")
    assert "'ac'" in reading.the("cyclic-tree").what


def test_a_link_that_no_joint_ties_to_the_rest_is_refused(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in ("trunk", "leg", "lost")), bench.joint("hip", "trunk", "leg")
    )
    assert reading.robot is None
    assert reading.stands("lost-base", "refused", "link", "lost")
    assert "'trunk'" in reading.the("lost-base").what


def test_the_smaller_of_two_trees_is_the_lost_one_whichever_stands_first(bench: Any) -> None:
    small = (bench.link("s"), bench.link("t"), bench.joint("st", "s", "t"))
    large = (
        *(bench.link(name) for name in "abc"),
        bench.joint("ab", "a", "b"),
        bench.joint("bc", "b", "c"),
    )
    for elements in ((*small, *large), (*large, *small)):
        reading = bench.read(*elements)
        assert reading.robot is None
        assert reading.stands("lost-base", "refused", "link", "s")


def test_a_chain_of_links_as_long_as_a_snake_is_read(bench: Any) -> None:
    count = 100
    reading = bench.read(
        *(bench.link(f"l{at}") for at in range(count)),
        *(bench.joint(f"j{at}", f"l{at}", f"l{at + 1}") for at in range(count - 1)),
    )
    assert reading.findings == ()
    assert reading.robot.mass == count
    assert len(reading.robot.joints) == count - 1
