"""What every operation must honour on every body of the built-in shelf."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import mujoco
import numpy as np
import pytest

from morph.body import shelf
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary import (
    OPERATIONS,
    Add,
    Drop,
    Heavier,
    Lock,
    Operation,
    Scale,
    Stiffen,
    from_vector,
    interpolate,
    tunable,
    vary,
)

BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())


@cache
def body(name: str) -> Robot:
    return load(name)


def ends(robot: Robot) -> list[str]:
    """Return a robot's first and last link."""
    return [robot.links[0].name, robot.links[-1].name]


def joints(robot: Robot) -> list[str]:
    """Return a robot's first and last hinge or slide."""
    found = [joint.name for joint in robot.joints if joint.kind in ("hinge", "slide")]
    return [found[0], found[-1]]


EVERY: dict[type[Operation], Callable[[Robot], list[Operation]]] = {
    Scale: lambda robot: [
        Scale(link="*", factor=1.3),
        *(Scale(link=link, factor=0.8) for link in ends(robot)),
        *(Scale(link=link, factor=1.2, along=(0.0, 0.6, 0.8)) for link in ends(robot)),
    ],
    Add: lambda robot: [
        Add(link="new", parent=link, mass=0.05, joint="new", axis=(0.0, 1.0, 0.0), motor=0.1)
        for link in ends(robot)
    ],
    Drop: lambda robot: [Drop(link=robot.links[-1].name)] if len(robot.links) > 1 else [],
    Lock: lambda robot: [Lock(joint=joint) for joint in joints(robot)],
    Stiffen: lambda robot: [
        Stiffen(joint=joint, stiffness=0.1, damping=0.01, rest=0.1) for joint in joints(robot)
    ],
    Heavier: lambda robot: [Heavier(link=link, factor=1.5) for link in ("*", *ends(robot))],
}
"""Each operation, at both ends of a body."""


def check(robot: Robot) -> None:
    """Raise AssertionError unless a body can exist and moves."""
    for link in robot.links:
        xx, yy, zz, xy, xz, yz = link.inertia
        moments = np.linalg.eigvalsh(np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))))
        assert link.mass >= 0
        # A flat body's inertias across add up to that about its normal, but for rounding.
        assert moments[0] >= 0
        assert moments[2] <= (moments[0] + moments[1]) * (1 + 1e-9)
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 100)
    assert np.isfinite(data.qpos).all()
    assert np.isfinite(data.qvel).all()
    # MuJoCo starts afresh after numbers that are not finite, and counts them.
    assert data.time == pytest.approx(0.2)
    # Nothing on the shelf is faster after 0.2 s than a fall of 2 m/s and a few turns.
    assert np.abs(data.qvel).max(initial=0.0) < 100


def test_every_operation_is_tried() -> None:
    assert tuple(EVERY) == OPERATIONS


@pytest.mark.parametrize("kind", OPERATIONS, ids=lambda kind: kind.name)
@pytest.mark.parametrize("name", BODIES)
def test_a_varied_body_can_exist_and_moves(name: str, kind: type[Operation]) -> None:
    for operation in EVERY[kind](body(name)):
        varied = vary(body(name), operation)
        assert varied.sha256 != body(name).sha256
        check(varied)


@pytest.mark.parametrize("name", BODIES)
def test_a_cards_parameters_can_be_set_from_low_to_high(name: str) -> None:
    card = body(name).card
    assert card is not None
    for share in (0.0, 0.5, 1.0):
        check(from_vector(body(name), [share] * len(tunable(body(name)))))
    for lock in {parameter.name for parameter in card.parameter} - set(tunable(body(name))):
        check(from_vector(body(name), [0.5], names=(lock,)))


@pytest.mark.parametrize("name", BODIES)
def test_a_body_on_the_way_to_twice_itself_can_exist_and_moves(name: str) -> None:
    larger = vary(body(name), Scale(link="*", factor=2.0))
    check(interpolate(body(name), larger, 0.3))


@pytest.mark.parametrize("name", BODIES)
def test_bodies_on_the_way_to_another_topology_can_exist_and_move(name: str) -> None:
    for fraction in (0.0, 0.4, 0.6, 1.0):
        between = interpolate(body(name), body("pendulum"), fraction)
        assert len(between.joints) >= len(body(name).joints)
        check(between)
