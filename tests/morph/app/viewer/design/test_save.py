"""A design as a new body on the user's shelf."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import morph.app.viewer.design.save as saving
from morph.app.viewer.design.design_state import BodyPlan
from morph.app.viewer.design.save import check_name, save
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.shelf import names
from morph.errors import MorphError, OutputError, ViewError


@pytest.fixture(autouse=True)
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "shelf"
    monkeypatch.setenv("MORPH_SHELF", str(place))
    return place


def some(plan: BodyPlan) -> dict[str, float]:
    """Return all parameters that are no locks, a third of the way up, and two general ones."""
    own = {
        each.name: each.low + (each.high - each.low) / 3.0
        for each in plan.own
        if each.operation != "lock"
    }
    return own | {plan.general[0].name: 1.1, plan.general[-1].name: 1.3}


@pytest.mark.parametrize("name", ["quadruped_printed", "so101", "quadruped_four_bar", "pendulum"])
def test_a_saved_body_is_the_one_designed(name: str, shelf: Path) -> None:
    plan = BodyPlan(load(name))
    built = plan.built(some(plan))
    assert abs(built.robot.mass - plan.robot.mass) > 1e-4
    folder = save(plan, built, "designed")
    assert folder == shelf / "designed"
    found = load("designed")
    assert found.name == "designed"
    assert found.mass == pytest.approx(built.robot.mass, abs=1e-9)
    assert [joint.name for joint in found.joints] == [j.name for j in built.robot.joints]
    assert [each.limit for each in found.actuators] == [e.limit for e in built.robot.actuators]
    assert [loop.links for loop in found.loops] == [loop.links for loop in built.robot.loops]
    for link in built.robot.links:
        assert found.link(link.name).inertia == pytest.approx(link.inertia, rel=1e-9, abs=1e-15)
    assert "designed" in names()
    assert [each.name for each in shelf.iterdir()] == ["designed"]


def test_a_saved_body_says_where_it_comes_from_and_can_be_designed_further() -> None:
    plan = BodyPlan(load("biped"))
    save(plan, plan.built({"torso_mass": 1.5, "left_ankle_stiffness": 100.0}), "heavy_biped")
    found = load("heavy_biped")
    assert found.card is not None
    assert plan.robot.card is not None
    sources = [(source.what, source.from_) for source in found.card.source]
    assert plan.robot.sha256[:16] in sources[0][1]
    assert "biped" in sources[0][1]
    assert ("torso_mass = 1.5", "chosen in morph view: heavier of torso") in sources
    ranges = {each.name: (each.low, each.high) for each in found.card.parameter}
    # The card's torso went from 0.3 to 2.0 times; of one that is 1.5 times as heavy, that is:
    assert ranges["torso_mass"] == pytest.approx((0.3 / 1.5, 2.0 / 1.5), rel=1e-12)
    assert ranges["left_ankle_stiffness"] == (0.0, 900.0)
    assert found.card.licence == plan.robot.card.licence
    again = BodyPlan(found)
    once = again.built({"torso_mass": 2.0 / 1.5}).robot.mass
    assert once == pytest.approx(plan.built({"torso_mass": 2.0}).robot.mass, abs=1e-9)


def test_a_locked_joint_is_gone_with_its_parameters() -> None:
    plan = BodyPlan(load("biped"))
    values = {"left_knee_locked_at": 0.5, "left_ankle_stiffness": 50.0}
    save(plan, plan.built(values), "stiff_leg")
    found = load("stiff_leg")
    assert len(found.joints) == len(plan.robot.joints) - 1
    assert found.card is not None
    assert "left_knee_locked_at" not in [each.name for each in found.card.parameter]
    assert all(motor.actuator != "left_knee" for motor in found.card.motor)


def test_a_body_without_a_card_is_saved_with_one(arm: Callable[..., Robot]) -> None:
    plan = BodyPlan(arm())
    save(plan, plan.built({"lower: mass": 1.5}), "long_arm")
    found = load("long_arm")
    assert found.card is not None
    assert (found.card.base, found.card.licence) == ("fixed", "NOASSERTION")
    assert found.mass == pytest.approx(3.5, abs=1e-9)


def test_a_floating_body_without_a_card_still_floats(gripper: Robot) -> None:
    plan = BodyPlan(gripper)
    save(plan, plan.original, "hand")
    found = load("hand")
    assert found.card is not None
    assert found.card.base == "floating"
    assert found.joint("right").mimic == gripper.joint("right").mimic


@pytest.mark.parametrize(
    "name",
    [
        "",
        "../evil",
        "a/b",
        "a\\b",
        ".hidden",
        "1st",
        "with space",
        "ümlaut",
        "x" * 61,
        "nul",
        "a\n",
    ],
)
def test_a_name_that_is_none_is_refused(name: str, shelf: Path) -> None:
    with pytest.raises(ViewError, match=r"cannot be called .*\n  fix: begin with a letter"):
        check_name(name)
    assert not shelf.exists()


@pytest.mark.parametrize("name", ["pendulum", "Pendulum", "mine", "MINE"])
def test_nothing_is_written_over(name: str, shelf: Path, arm: Callable[..., Robot]) -> None:
    plan = BodyPlan(arm())
    save(plan, plan.original, "mine")
    before = {file: file.read_bytes() for file in shelf.rglob("*") if file.is_file()}
    with pytest.raises(ViewError, match=r"there is a body called .* already"):
        save(plan, plan.original, name)
    assert {file: file.read_bytes() for file in shelf.rglob("*") if file.is_file()} == before


def test_what_fails_on_the_way_leaves_nothing(
    shelf: Path, arm: Callable[..., Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = BodyPlan(arm())

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "rename", full)
    with pytest.raises(OutputError, match=r"No space left on device"):
        save(plan, plan.original, "mine")
    assert list(shelf.iterdir()) == []


def test_what_was_not_written_right_is_not_saved(
    shelf: Path, arm: Callable[..., Robot], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = BodyPlan(arm())
    heavier = plan.built({"lower: mass": 1.5}).robot
    monkeypatch.setattr(saving, "load", lambda folder: heavier)
    with pytest.raises(MorphError, match=r"weighs 3\.5 kg, and the design 3 kg"):
        save(plan, plan.original, "mine")
    assert list(shelf.iterdir()) == []


def test_a_shelf_that_is_a_file_is_told(shelf: Path, arm: Callable[..., Robot]) -> None:
    shelf.write_text("not a folder")
    plan = BodyPlan(arm())
    with pytest.raises(OutputError, match=r"the design cannot be saved"):
        save(plan, plan.original, "mine")
    assert shelf.read_text() == "not a folder"
