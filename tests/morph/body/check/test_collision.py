"""Parts that overlap at home are named and their contacts left out; those that do not, are not."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh

from morph.body.collide import with_pieces
from morph.body.spec import spec_of


def gripper(bench: Any, shape: str, apart: float, files: dict[str, bytes] | None = None) -> Any:
    """Return the reading of two fingers on two knuckles, at a distance from each other."""
    return bench.read(
        bench.link("palm"),
        bench.link("knuckle_a"),
        bench.link("knuckle_b"),
        bench.link("finger_a", shape),
        bench.link("finger_b", shape),
        bench.joint("ja", "palm", "knuckle_a", xyz=f"{-apart / 2} 0 0"),
        bench.joint("jb", "palm", "knuckle_b", xyz=f"{apart / 2} 0 0"),
        bench.joint("fa", "knuckle_a", "finger_a"),
        bench.joint("fb", "knuckle_b", "finger_b"),
        files=files,
    )


def primitive(kind: str, size: str) -> str:
    return f"<collision><geometry><{kind} {size}/></geometry></collision>"


SHAPES = {
    "box": primitive("box", 'size="0.2 0.2 0.2"'),
    "sphere": primitive("sphere", 'radius="0.1"'),
    "cylinder": primitive("cylinder", 'radius="0.1" length="0.2"'),
    "capsule": primitive("capsule", 'radius="0.1" length="0.2"'),
}
"""Each 0.2 m wide along x."""


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_that_overlap_by_half_are_named_at_the_first(bench: Any, kind: str) -> None:
    reading = gripper(bench, SHAPES[kind], 0.1)
    assert reading.stands("self-collision", "repaired", "link", "finger_a")
    assert "'finger_b'" in reading.the("self-collision").what


@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("apart", [0.2, 0.21, 1.0])
def test_shapes_that_touch_or_are_apart_are_left_alone(bench: Any, kind: str, apart: float) -> None:
    assert gripper(bench, SHAPES[kind], apart).findings == ()


def test_meshes_that_overlap_are_named_and_those_apart_are_not(bench: Any) -> None:
    ball = bytes(trimesh.creation.icosphere(subdivisions=3, radius=0.1).export(file_type="stl"))
    shape = bench.mesh("ball.stl", role="collision")
    for apart, told in ((0.1, 1), (0.21, 0)):
        reading = gripper(bench, shape, apart, files={"ball.stl": ball})
        assert len(reading.of("self-collision")) == told


def test_a_ring_around_a_rod_overlaps_as_a_hull_and_not_in_pieces(bench: Any) -> None:
    ring = trimesh.creation.annulus(r_min=0.2, r_max=0.3, height=0.1)
    reading = bench.read(
        *(bench.link(name) for name in ("palm", "a", "b")),
        bench.link("ring", bench.mesh("ring.stl", role="collision")),
        bench.link("rod", SHAPES["cylinder"]),
        bench.joint("ja", "palm", "a"),
        bench.joint("jb", "palm", "b"),
        bench.joint("jr", "a", "ring"),
        bench.joint("jd", "b", "rod"),
        files={"ring.stl": bytes(ring.export(file_type="stl"))},
    )
    assert "convex hulls" in reading.the("self-collision").what
    assert len(spec_of(reading.robot).excludes) == 1
    cut, _ = with_pieces(reading.robot)
    assert len(spec_of(cut).excludes) == 0


def test_a_table_that_is_the_world_is_left_as_any_link_is(bench: Any) -> None:
    table = primitive("box", 'size="1 1 0.1"')
    reading = bench.read(
        bench.link("world", table, mass=None),
        bench.link("a", SHAPES["box"]),
        bench.link("b", SHAPES["box"]),
        bench.joint("j", "world", "a"),
        bench.joint("k", "a", "b", xyz="0.3 0 0"),
    )
    # The first link hangs on the table; the second lies in it.
    assert "'b'" in reading.the("self-collision").what
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_no_link_collides_with_the_one_that_it_hangs_on(bench: Any, base: str) -> None:
    reading = bench.read(
        bench.link("a", SHAPES["box"]),
        bench.link("plate", SHAPES["box"]),
        bench.link("b", SHAPES["box"]),
        bench.joint("weld", "a", "plate", "fixed"),
        bench.joint("j", "plate", "b"),
        base=base,
    )
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    for angle in np.linspace(-3.0, 3.0, 50):
        data.qpos[-1] = angle
        mujoco.mj_forward(model, data)
        assert data.ncon == 0


def test_shapes_to_look_at_do_not_collide(bench: Any) -> None:
    assert gripper(bench, SHAPES["box"].replace("collision", "visual"), 0.1).findings == ()


def test_links_that_a_joint_joins_may_overlap(bench: Any) -> None:
    reading = bench.read(
        bench.link("a", SHAPES["box"]), bench.link("b", SHAPES["box"]), bench.joint("j", "a", "b")
    )
    assert reading.findings == ()


def test_what_is_welded_to_a_link_may_overlap_what_that_link_turns_on(bench: Any) -> None:
    reading = bench.read(
        bench.link("a", SHAPES["box"]),
        bench.link("b"),
        bench.link("shell", SHAPES["box"]),
        bench.joint("j", "a", "b"),
        bench.joint("weld", "b", "shell", "fixed"),
    )
    assert reading.findings == ()


def test_mujoco_finds_no_contact_at_home_once_a_collision_is_repaired(bench: Any) -> None:
    model = spec_of(gripper(bench, SHAPES["box"], 0.1).robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    # The contact was there: without the exclusion MuJoCo finds it.
    spec = spec_of(gripper(bench, SHAPES["box"], 0.1).robot)
    for exclude in list(spec.excludes):
        spec.delete(exclude)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon > 0


def test_a_mesh_scaled_to_nothing_touches_nothing(bench: Any) -> None:
    ball = bytes(trimesh.creation.icosphere(subdivisions=1, radius=0.1).export(file_type="stl"))
    for scale in ("1 1 0", "0 0 0", "1e-20 1e-20 1e-20"):
        shape = bench.mesh("ball.stl", role="collision", scale=scale)
        reading = gripper(bench, shape, 0.1, files={"ball.stl": ball})
        assert reading.robot is not None
        assert reading.of("self-collision") == []
