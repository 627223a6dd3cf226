"""Limbs and mirror images, against names that say left and right, and against other names."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body.limbs import limbs_of
from morph.body.load import load
from tests.morph.body.disguise import disguised

SIDES = (("left", "right"), ("l_", "r_"))


def other(name: str) -> str:
    """Return the name of a part's twin; its own if it names no side."""
    for left, right in SIDES:
        for one, two in ((left, right), (right, left)):
            if name.startswith(one) or f"_{one}" in name:
                return name.replace(one, two, 1)
    return name


@pytest.mark.parametrize(
    ("body", "feet"),
    [("quadruped_printed", 4), ("humanoid", 2), ("hexapod_swimmer", 0), ("biped", 2)],
)
def test_twins_are_those_whose_names_say_so(body: str, feet: int) -> None:
    robot = load(body)
    found = limbs_of(robot)
    scalar = [each.name for each in robot.joints if each.kind in ("hinge", "slide")]
    assert found.twins == {name: other(name) for name in scalar}
    assert found.normal == pytest.approx([0.0, 1.0, 0.0], abs=1e-3)
    assert len(found.feet) == feet
    # Left before right: a limb follows its twin.
    ends = [limb.end for limb in found.limbs if other(limb.end) != limb.end]
    assert [other(each) for each in ends[::2]] == ends[1::2] or body == "humanoid"


@pytest.mark.parametrize("body", ["quadruped_printed", "humanoid", "hexapod_swimmer"])
@pytest.mark.parametrize("seed", [0, 1])
def test_names_and_the_sense_of_axes_play_no_part(body: str, seed: int, tmp_path: Path) -> None:
    robot = load(body)
    before = limbs_of(robot)
    after, names = disguised(robot, tmp_path, seed)
    found = limbs_of(after)
    assert [names[limb.end] for limb in found.limbs] == [limb.end for limb in before.limbs]
    assert {names[a]: names[b] for a, b in found.twins.items()} == before.twins
    assert [limb.foot for limb in found.limbs] == [limb.foot for limb in before.limbs]


def test_an_arm_has_no_sides() -> None:
    found = limbs_of(load("so101"))
    assert (found.normal, found.twins, found.feet) == (None, {}, ())
    (arm,) = found.limbs
    assert arm.joints == tuple(joint.name for joint in load("so101").joints)
