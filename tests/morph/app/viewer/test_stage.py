"""The stage on a scene that only notes what it is asked for."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.app.viewer.content import Actor, Colour, Content, Tie
from morph.app.viewer.figure import Figure, figure
from morph.app.viewer.framing import FIELD
from morph.app.viewer.motion import RATE, MotionFrames, posed
from morph.app.viewer.player import CHOSEN, COLD, HOT, LEVELS, colour_of
from morph.app.viewer.stage import Stage
from morph.body.load import load

CART = """<mujoco model="two &lt;b&gt;">
  <worldbody>
    <geom name="rail" type="capsule" fromto="-1 0 1 1 0 1" size="0.01"/>
    <body name="cart/../x" pos="0 0 1">
      <joint name="slide" type="slide" axis="1 0 0"/>
      <geom type="box" size="0.1 0.05 0.05" rgba="0.2 0.4 0.6 1"/>
      <geom type="box" size="0.02 0.02 0.2" rgba="0.2 0.4 0.6 1"/>
      <geom type="sphere" size="0.06" rgba="1 0 0 1"/>
      <body name="pole">
        <joint name="hinge" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
      </body>
    </body>
  </worldbody>
</mujoco>"""


class Node:
    """What stands on the noted scene; it notes what is set."""

    def __init__(self, name: str, log: list[tuple[str, str, Any]], given: dict[str, Any]) -> None:
        self.__dict__.update({"visible": True, "position": np.zeros(3), **given})
        self.__dict__["name"], self.__dict__["log"] = name, log

    def __setattr__(self, key: str, value: Any) -> None:
        self.__dict__[key] = value
        self.log.append((self.name, key, value))


class Scene:
    """Has viser's way of adding things, and none of its private parts."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}
        self.log: list[tuple[str, str, Any]] = []

    def __getattr__(self, kind: str) -> Any:
        if not kind.startswith("add_"):
            raise AttributeError(kind)

        def add(name: str, *given: Any, **named: Any) -> Node:
            node = Node(name, self.log, {**named, "given": given, "kind": kind})
            self.nodes[name] = node
            return node

        return add

    def remove_by_name(self, name: str) -> None:
        self.nodes = {each: node for each, node in self.nodes.items() if not each.startswith(name)}

    def of(self, kind: str, under: str = "") -> list[Node]:
        return [n for n in self.nodes.values() if n.kind == kind and n.name.startswith(under)]


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> Figure:
    path: Path = tmp_path_factory.mktemp("cart") / "cart.xml"
    path.write_text(CART, encoding="utf-8")
    return figure(load(path))


def still(drawn: Figure, **more: Any) -> Actor:
    return Actor(figure=drawn, motion=posed(drawn.model, np.zeros((1, 2))), **more)


def moving(drawn: Figure, metres: float = 2.0, **more: Any) -> MotionFrames:
    """One second in which the cart goes along its rail, and the pole hangs."""
    poses = np.zeros((61, 2))
    poses[:, 0] = np.linspace(0.0, metres, 61)
    return dataclasses.replace(posed(drawn.model, poses), **more)


def test_shapes_of_one_link_and_colour_are_one_mesh(cart: Figure) -> None:
    # The rail; the cart's two boxes as one, and its ball; the pole: four, not five.
    assert [shape.body for shape in cart.shapes] == [0, 1, 1, 2]


def test_no_name_of_a_file_becomes_a_path_of_the_scene(cart: Figure) -> None:
    scene = Scene()
    Stage(scene).show(Content(actors=(still(cart),)))
    assert not any("cart" in name or "<" in name or ".." in name for name in scene.nodes)


def test_what_did_not_move_is_not_sent(cart: Figure) -> None:
    scene, motion = Scene(), moving(cart)
    stage = Stage(scene)
    stage.following = False
    stage.show(Content(actors=(Actor(figure=cart, motion=motion),)))
    stage.pose(0.0)
    scene.log.clear()
    stage.pose(0.0)
    assert [entry for entry in scene.log if entry[0].startswith("/world_1/0")] == []
    stage.pose(1.0 / RATE)
    # The cart and the pole go and do not turn; the rail stays.
    assert sorted((name, key) for name, key, _ in scene.log if name.count("/") == 3) == [
        ("/world_1/0/1", "position"),
        ("/world_1/0/2", "position"),
        ("/world_1/0/label", "position"),
    ]


def test_links_stand_where_their_motion_says(cart: Figure) -> None:
    scene, motion = Scene(), moving(cart)
    stage = Stage(scene)
    stage.show(Content(actors=(Actor(figure=cart, motion=motion),)))
    stage.pose(0.5)
    # Half of 2 m after half of 1 s; the cart hangs 1 m up.
    assert np.allclose(scene.nodes["/world_1/0/1"].position, (1.0, 0.0, 1.0))


def test_following_keeps_the_mean_of_the_bodies_in_place(cart: Figure) -> None:
    scene, stage = Scene(), None
    stage = Stage(scene)
    actors = (
        Actor(figure=cart, motion=moving(cart, 2.0)),
        Actor(figure=cart, motion=moving(cart, -0.5)),
    )
    stage.show(Content(actors=actors))
    stage.pose(1.0)
    # They went 2 m and -0.5 m, 0.75 m on the whole: the world goes back by as much.
    assert np.allclose(scene.nodes["/world_1"].position, (-0.75, 0.0, 0.0))
    stage.following = False
    stage.pose(1.0)
    assert np.allclose(scene.nodes["/world_1"].position, 0.0)


def test_heat_is_red_where_it_is_worst_and_gray_where_nothing_is_wrong(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    heat = np.tile((0.0, 0.0, 1.0), (61, 1))
    stage.show(Content(actors=(Actor(figure=cart, motion=moving(cart, heat=heat)),)))
    stage.pose(0.0)
    assert scene.nodes["/world_1/0/1/1"].color == tuple(COLD.astype(int))
    assert scene.nodes["/world_1/0/2"].color == tuple(HOT.astype(int))
    assert colour_of(LEVELS) == tuple(HOT.astype(int))


def test_heat_is_sent_only_when_its_step_changes(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    # From 0 to 1 in 61 pictures there are 13 steps: rounded(12 x) takes each value of 0 to 12.
    heat = np.linspace(0.0, 1.0, 61)[:, None] * np.array([0.0, 0.0, 1.0])
    stage.show(Content(actors=(Actor(figure=cart, motion=moving(cart, heat=heat)),)))
    for picture in range(61):
        stage.pose(picture / RATE)
    assert sum(name == "/world_1/0/2" and key == "color" for name, key, _ in scene.log) == 13


def test_a_chosen_link_stays_so_under_heat_and_gets_its_colour_back(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    heat = np.tile((0.0, 0.0, 1.0), (61, 1))
    stage.show(Content(actors=(Actor(figure=cart, motion=moving(cart, heat=heat)),)))
    stage.choose(0, "pole")
    stage.pose(0.0)
    stage.pose(0.5)
    assert scene.nodes["/world_1/0/2"].color == CHOSEN
    stage.choose(0, None)
    stage.pose(0.5)
    assert scene.nodes["/world_1/0/2"].color == tuple(HOT.astype(int))


def test_without_heat_a_chosen_link_gets_back_its_own_colour(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    red: Colour = (250, 1, 2)
    stage.show(Content(actors=(still(cart, tints={"pole": red}),)))
    stage.choose(0, "pole")
    stage.pose(0.0)
    stage.choose(0, None)
    stage.pose(0.0)
    assert scene.nodes["/world_1/0/2"].color == red


def test_arrows_that_are_not_there_are_not_drawn(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    arrows = np.full((61, 2, 2, 3), np.nan)
    arrows[30, 1] = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    motion = moving(cart, arrows={"contact": arrows})
    stage.show(Content(actors=(Actor(figure=cart, motion=motion),)))
    stage.pose(0.0)
    (node,) = scene.of("add_arrows")
    assert not node.visible
    stage.pose(0.5)
    assert node.visible
    assert node.points.shape == (1, 2, 3)
    stage.shown_arrows.clear()
    stage.pose(0.5)
    assert not node.visible


def test_a_tie_joins_points_on_two_links_and_goes_with_them(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    tie = Tie(source=(0, "pole"), target=(1, "pole"), source_at=(0.0, 0.0, -0.5))
    turned = np.zeros((1, 2))
    turned[0, 1] = 0.5 * math.pi
    first = Actor(figure=cart, motion=posed(cart.model, turned))
    stage.show(Content(actors=(first, still(cart)), ties=(tie,)))
    stage.pose(0.0)
    (lines,) = [n for n in scene.of("add_line_segments") if "ties" in n.name]
    # A quarter turn about y takes the pole's end from (0, 0, -0.5) to (-0.5, 0, 0).
    places = stage.layout.places
    assert np.allclose(lines.points[0, 0], places[0] + (-0.5, 0.0, 1.0), atol=1e-6)
    assert np.allclose(lines.points[0, 1], places[1] + (0.0, 0.0, 1.0), atol=1e-6)


def test_showing_anew_leaves_nothing_of_before(cart: Figure) -> None:
    scene = Scene()
    stage = Stage(scene)
    stage.show(Content(actors=(still(cart), still(cart))))
    stage.show(Content(actors=(still(cart),)))
    stage.pose(0.0)
    assert "/world_2/0" in scene.nodes
    assert "/world_2/1" not in scene.nodes
    # A page that is sent both at once would keep poses of nodes whose names come again.
    assert not any(name.startswith("/world_1") for name in scene.nodes)


def test_only_what_is_wet_stands_in_water(cart: Figure) -> None:
    scene = Scene()
    wet = dataclasses.replace(cart, wet=True)
    Stage(scene).show(Content(actors=(still(cart), still(wet))))
    assert len([node for node in scene.nodes if node.startswith("/world_1/water")]) == 1


def test_a_camera_follows_the_shape_of_its_picture_until_a_person_moves_it(cart: Figure) -> None:
    stage = Stage(Scene())
    stage.show(Content(actors=(still(cart),)))
    camera = SimpleNamespace(aspect=2.0)
    stage.aim(camera)
    wide = camera.position
    camera.aspect = 0.5
    stage.refit(camera)
    narrow = camera.position
    # Half a picture's width takes more than twice the distance.
    at = camera.look_at
    assert np.linalg.norm(narrow - at) > 1.5 * np.linalg.norm(wide - at)
    camera.position = narrow + 1.0
    camera.aspect = 2.0
    stage.refit(camera)
    assert np.array_equal(camera.position, narrow + 1.0)
    assert camera.fov == FIELD


def test_what_becomes_ready_turns_no_camera_that_a_person_has_moved(cart: Figure) -> None:
    stage = Stage(Scene())
    stage.show(Content(actors=(still(cart),)))
    camera = SimpleNamespace(aspect=1.5)
    stage.aim(camera)
    stage.show(Content(actors=(still(cart), still(cart))))
    before = camera.position
    stage.reaim()
    stage.refit(camera)
    assert not np.allclose(camera.position, before)
    camera.look_at = camera.look_at + 0.5
    seen_from = camera.position
    stage.show(Content(actors=(still(cart),)))
    stage.reaim()
    stage.refit(camera)
    assert camera.position is seen_from


def test_an_empty_stage_has_a_place_to_look_from() -> None:
    stage = Stage(Scene())
    stage.show(Content(actors=()))
    stage.pose(0.0)
    camera = SimpleNamespace()
    stage.aim(camera)
    assert np.isfinite(camera.position).all()
