"""Left and right limbs that do not mirror each other are named; those that do are left alone."""

from __future__ import annotations

from typing import Any

PARTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle")
AXES = {"hip_yaw": "z", "hip_roll": "x", "hip_pitch": "y", "knee": "y", "ankle": "y"}
UNIT = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
OFFSETS = {
    "hip_yaw": (0, 0.1, 0),
    "hip_roll": (0, 0.02, -0.05),
    "hip_pitch": (0, 0.03, -0.05),
    "knee": (0, 0, -0.3),
    "ankle": (0, 0, -0.3),
}
"""To the left; y points there (ROS, REP 103)."""


def text(values: Any) -> str:
    return " ".join(str(value) for value in values)


def biped(bench: Any, **odd: dict[str, Any]) -> Any:
    """Return the reading of two legs; `odd` gives a joint another `axis`, `xyz` or `mass`."""
    elements = [bench.link("trunk", mass=5.0)]
    for side, sign in (("left", 1), ("right", -1)):
        parent = "trunk"
        for part in PARTS:
            name = f"{side}_{part}"
            other = odd.get(name, {})
            # Axes of rotation are axial: those across the plane stay, the others turn over.
            axis = [(1 if AXES[part] == "y" else sign) * value for value in UNIT[AXES[part]]]
            x, y, z = OFFSETS[part]
            axis, offset = other.get("axis", axis), other.get("xyz", (x, sign * y, z))
            mass = other.get("mass", 1.0)
            moments = tuple(mass * value for value in (0.003, 0.004, 0.005))
            elements.append(bench.link(name, mass=mass, moments=moments))
            elements.append(
                bench.joint(f"{name}_joint", parent, name, xyz=text(offset), axis=text(axis))
            )
            parent = name
    return bench.read(*elements)


def test_legs_that_mirror_each_other_are_left_alone(bench: Any) -> None:
    assert biped(bench).findings == ()


def test_legs_whose_axes_all_point_the_same_way_are_left_alone(bench: Any) -> None:
    # The other convention: the axes of both sides are parallel, as on most humanoids.
    same = {f"right_{part}": {"axis": UNIT[AXES[part]]} for part in PARTS}
    assert biped(bench, **same).findings == ()


def test_an_axis_that_is_turned_over_is_named_at_its_joint(bench: Any) -> None:
    for name in ("right_knee", "left_knee"):
        reading = biped(bench, **{name: {"axis": (0, -1, 0)}})
        finding = reading.the("axis-flipped")
        assert (finding.severity, finding.where.kind) == ("info", "joint")
        # Of two twins that disagree either may be the wrong one: both are named.
        said = f"{finding.where.name} {finding.what}"
        assert "left_knee_joint" in said
        assert "right_knee_joint" in said
        assert finding.where.line == reading.line(f'<joint name="{finding.where.name}"')


def test_a_limb_on_the_side_of_its_twin_is_named_at_its_first_joint(bench: Any) -> None:
    for name, other in (("right", "left"), ("left", "right")):
        sign = 1 if name == "right" else -1
        reading = biped(bench, **{f"{name}_hip_yaw": {"xyz": (0, sign * 0.1, 0)}})
        finding = reading.the("limb-mirrored")
        assert (finding.severity, finding.where.kind) == ("info", "joint")
        assert finding.where.name in (f"{name}_hip_yaw_joint", f"{other}_hip_yaw_joint")
        assert finding.where.line == reading.line(f'<joint name="{finding.where.name}"')


def test_a_leg_that_bends_to_the_wrong_side_half_way_is_named(bench: Any) -> None:
    reading = biped(bench, right_hip_pitch={"xyz": (0, 0.03, -0.05)})
    assert reading.the("limb-mirrored").where.name == "right_hip_pitch_joint"


def test_a_part_that_weighs_twice_its_twin_is_named(bench: Any) -> None:
    reading = biped(bench, left_knee={"mass": 2.0})
    finding = reading.the("mass-asymmetric")
    assert finding.severity == "info"
    assert finding.where.kind == "link"
    assert finding.where.name in ("left_knee", "right_knee")
    assert "left_knee" in f"{finding.where.name} {finding.what}"


def test_twins_that_differ_by_a_screw_are_left_alone(bench: Any) -> None:
    assert biped(bench, left_knee={"mass": 1.05}).findings == ()


def test_a_body_without_sides_has_no_symmetry_to_break(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(f"segment_{at}", mass=1.0 + at) for at in range(4)),
        *(
            bench.joint(f"turn_{at}", f"segment_{at}", f"segment_{at + 1}", axis=axis, xyz="1 0 0")
            for at, axis in enumerate(("0 0 1", "0 0 -1", "0 1 0"))
        ),
    )
    assert reading.findings == ()


def test_a_negative_mass_is_compared_with_no_twin(bench: Any) -> None:
    reading = biped(bench, left_knee={"mass": -1.0})
    assert reading.robot is None
    assert {finding.code for finding in reading.findings} == {"inertia-broken"}
