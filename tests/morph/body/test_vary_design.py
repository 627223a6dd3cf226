"""Operations as data: names, hashes, tables, and a card's parameters."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest

from morph.body.card import Card, CardParameter, Checks
from morph.body.load import load
from morph.body.robot import Mimic, Robot
from morph.body.vary import (
    OPERATIONS,
    Add,
    Lock,
    Scale,
    from_vector,
    operation_of,
    sweep,
    tunable,
    vary,
    with_parameters,
)
from morph.errors import RobotError

LENGTH = CardParameter(name="pole_length", operation="scale", link="pole", low=0.5, high=2.0)
MASS = CardParameter(name="cart_mass", operation="heavier", link="cart", low=0.5, high=4.0)


@pytest.fixture
def robot() -> Robot:
    found = load("cartpole")
    assert found.card is not None
    return replace(found, card=replace(found.card, parameter=(LENGTH, MASS)))


def card_of(robot: Robot) -> Card:
    assert robot.card is not None
    return robot.card


def test_a_varied_robot_is_named_and_hashed_by_its_origin_and_operations(robot: Robot) -> None:
    longer = vary(robot, Scale(link="pole", factor=1.3))
    assert longer.name == "cartpole+scale(pole,1.3)"
    assert longer.source == robot.source
    assert longer.sha256 == vary(robot, Scale(link="pole", factor=1.3)).sha256
    others = [
        robot,
        vary(robot, Scale(link="pole", factor=1.3 + 1e-12)),
        vary(robot, Scale(link="cart", factor=1.3)),
        vary(replace(robot, sha256="another"), Scale(link="pole", factor=1.3)),
    ]
    assert len({longer.sha256, *(other.sha256 for other in others)}) == 5


def test_the_robot_given_is_not_changed(robot: Robot) -> None:
    before = robot.mjcf
    vary(robot, Scale(link="*", factor=2.0), Lock(joint="slide"))
    assert robot.mjcf == before == load("cartpole").mjcf


def test_what_mjcf_cannot_hold_comes_along(robot: Robot) -> None:
    measured = replace(robot.link("pole"), inertia_from="measured")
    fast = replace(
        robot.joint("hinge"), velocity=7.0, mimic=Mimic(joint="slide", ratio=2, offset=0)
    )
    known = replace(
        robot, links=(robot.link("cart"), measured), joints=(robot.joint("slide"), fast)
    )
    longer = vary(known, Scale(link="pole", factor=2.0))
    assert longer.link("pole").inertia_from == "measured"
    assert longer.joint("hinge").velocity == 7.0
    assert longer.joint("hinge").mimic == fast.mimic
    assert vary(known, Lock(joint="slide")).joint("hinge").mimic is None


def test_a_card_forgets_what_no_longer_holds(robot: Robot) -> None:
    locked = vary(robot, Lock(joint="slide"))
    assert card_of(robot).motor
    assert card_of(locked).motor == ()
    assert card_of(locked).checks == Checks()
    assert card_of(locked).parameter == (LENGTH, MASS)


TABLE = """
[[step]]
operation = "scale"
link = "pole"
factor = 1.3
along = [0, 0, 1]

[[step]]
operation = "add"
link = "tip"
parent = "pole"
mass = 0.1
position = [0.0, 0.0, -0.65]

[[step]]
operation = "lock"
joint = "slide"
"""


def test_a_chain_file_can_name_the_operations(robot: Robot) -> None:
    steps = [operation_of(table) for table in tomllib.loads(TABLE)["step"]]
    assert steps == [
        Scale(link="pole", factor=1.3, along=(0.0, 0.0, 1.0)),
        Add(link="tip", parent="pole", mass=0.1, position=(0.0, 0.0, -0.65)),
        Lock(joint="slide"),
    ]
    assert [link.name for link in vary(robot, *steps).links] == ["cart", "pole", "tip"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"operation": "scal", "link": "pole"}, "no operation 'scal'; .* are 'scale'"),
        ({"link": "pole"}, "no operation ''"),
        ({"operation": "scale", "lnk": "pole"}, "'lnk' is unknown; the nearest .* is 'link'"),
        ({"operation": "scale", "link": "pole"}, "the key 'factor' is missing"),
        ({"operation": "scale", "link": "pole", "factor": "2"}, "'2', of type str, not float"),
        ({"operation": "scale", "link": "pole", "factor": -2}, "factor is -2.0, not between"),
    ],
)
def test_a_table_that_names_no_operation_is_refused(table: dict[str, Any], words: str) -> None:
    with pytest.raises(RobotError, match=words):
        operation_of(table)


def test_every_operation_has_a_name_of_its_own() -> None:
    names = [kind.name for kind in OPERATIONS]
    assert names == ["scale", "add", "drop", "lock", "stiffen", "heavier"]


def test_parameters_act_in_the_cards_order_however_they_are_given(robot: Robot) -> None:
    both = with_parameters(robot, {"cart_mass": 2.0, "pole_length": 1.3})
    assert both.name == "cartpole+scale(pole,1.3)+heavier(cart,2)"
    assert both.link("cart").mass == 1.0
    assert both.link("pole").com[2] == pytest.approx(-0.325, rel=1e-12)


def test_a_vector_covers_each_parameter_from_low_to_high(robot: Robot) -> None:
    # Pole: 0.25 m * (0.5 + 0.2 * 1.5); cart: 0.5 kg * 4 at the upper end.
    found = from_vector(robot, [0.2, 1.0])
    assert found.link("pole").com[2] == pytest.approx(-0.25 * 0.8, rel=1e-12)
    assert found.link("cart").mass == 2.0


def test_a_vector_leaves_locks_alone_unless_they_are_named(robot: Robot) -> None:
    lock = CardParameter(name="held", operation="lock", link="pole", low=-1.0, high=1.0)
    held = replace(robot, card=replace(card_of(robot), parameter=(LENGTH, lock)))
    assert tunable(held) == ("pole_length",)
    assert len(from_vector(held, [0.5]).joints) == 2
    assert len(from_vector(held, [0.5], names=("held",)).joints) == 1


def test_a_sweep_makes_one_robot_at_a_time_the_last_name_fastest(robot: Robot) -> None:
    bodies = sweep(robot, {"pole_length": (0.5, 1.0), "cart_mass": (1.0, 2.0, 4.0)})
    assert isinstance(bodies, Iterator)
    found = [(body.link("pole").com[2] / -0.25, body.link("cart").mass / 0.5) for body in bodies]
    assert found == [(0.5, 1), (0.5, 2), (0.5, 4), (1, 1), (1, 2), (1, 4)]


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda r: with_parameters(r, {"pole": 1.0}), "no parameter 'pole'; .* 'pole_length'"),
        (lambda r: with_parameters(r, {"pole_length": 2.1}), "is 2.1, outside 0.5 to 2.0"),
        (lambda r: with_parameters(r, {"pole_length": float("nan")}), "is nan, outside"),
        (lambda r: from_vector(r, [0.5]), r"has 2 parameters, and the vector's shape is \(1,\)"),
        (lambda r: from_vector(r, [0.5, 1.01]), "leaves 0 to 1"),
        (lambda r: sweep(r, {"pole_length": (1.0, 3.0)}), "is 3.0, outside"),
        (lambda r: with_parameters(replace(r, card=None), {"pole_length": 1.0}), "no parameter"),
    ],
)
def test_what_the_card_does_not_offer_is_refused(
    robot: Robot, act: Callable[[Robot], object], words: str
) -> None:
    with pytest.raises(RobotError, match=words):
        act(robot)


@pytest.mark.parametrize(
    ("operation", "words"), [("stretch", "no operation 'stretch'"), ("drop", "no amount to set")]
)
def test_a_parameter_whose_operation_has_no_amount_is_refused(
    robot: Robot, operation: str, words: str
) -> None:
    odd = replace(card_of(robot), parameter=(replace(LENGTH, operation=operation),))
    with pytest.raises(RobotError, match=words):
        with_parameters(replace(robot, card=odd), {"pole_length": 1.0})
