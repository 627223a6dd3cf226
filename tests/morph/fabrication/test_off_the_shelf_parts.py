"""What is bought, what it weighs and where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.fabrication.drawing import drawing
from morph.fabrication.off_the_shelf_parts import items, parts
from morph.fabrication.printed import designed
from morph.print.weight import together


def without_shapes(robot: Robot) -> Robot:
    assert robot.card is not None
    assert robot.card.print is not None
    bare = tuple(replace(entry, shape="") for entry in robot.card.print.bought)
    return replace(robot, card=replace(robot.card, print=replace(robot.card.print, bought=bare)))


def test_a_board_that_is_bought_whole_weighs_what_the_description_says() -> None:
    robot = load("rider_rigid_driven")
    body = drawing(robot)
    found, notes = items(body)
    (board,) = parts(body, found)
    wanted = designed(robot)["board"]
    assert notes == ()
    assert board.weight is not None
    assert board.weight.mass == wanted.mass == 1.9
    assert board.weight.com == pytest.approx(wanted.com)
    assert board.weight.inertia == pytest.approx(wanted.inertia)


@pytest.mark.parametrize("name", ["humanoid", "quadruped_four_bar", "quadruped_printed"])
def test_what_is_bought_weighs_no_more_than_the_link_that_carries_it(name: str) -> None:
    robot = load(name)
    body = drawing(robot)
    carried: dict[str, float] = {}
    for part in parts(body, items(body)[0]):
        assert part.weight is not None
        for place in part.placements:
            carried[place.link] = carried.get(place.link, 0.0) + part.weight.mass
    for link, mass in carried.items():
        assert mass <= robot.link(link).mass + 1e-9, link


def test_the_waist_of_the_humanoid_is_its_servo_with_its_centre_and_mass() -> None:
    robot = load("humanoid")
    body = drawing(robot)
    inside = [
        part.weight.moved(place.pose)
        for part in parts(body, items(body)[0])
        for place in part.placements
        if place.link == "waist" and part.weight is not None
    ]
    found, wanted = together(inside), designed(robot)["waist"]
    assert found.mass == pytest.approx(wanted.mass)
    assert found.com == pytest.approx(wanted.com, abs=1e-9)
    # The description has the box of the e-manual, as the catalogue has.
    assert found.inertia == pytest.approx(wanted.inertia, rel=1e-6, abs=1e-12)


def test_what_is_drawn_nowhere_sits_at_the_links_centre_and_is_told() -> None:
    robot = without_shapes(load("quadruped_printed"))
    body = drawing(robot)
    found, notes = items(body)
    cells = next(part for part in parts(body, found) if "AAA" in part.name)
    assert cells.mesh is None
    assert cells.placements[0].pose[:3, 3] == pytest.approx(1e3 * np.array(robot.link("body").com))
    assert any("four AAA cells" in note and "centre of mass" in note for note in notes)
