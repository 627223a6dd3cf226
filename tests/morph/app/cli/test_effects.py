from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from morph.app.cli.effects import asked_effects, parsed, shown
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics import EFFECTS
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.store import effects_text


@pytest.fixture(scope="module")
def swimmer() -> Robot:
    return load("hexapod_swimmer")


@pytest.fixture(scope="module")
def pendulum() -> Robot:
    return load("pendulum")


def test_an_effect_is_read_with_its_place_and_its_parameters(pendulum: Robot) -> None:
    found = parsed("stribeck_friction@hinge:c=0.1,s=0.2,vs=5e-2", pendulum)
    assert found == StribeckFriction(joint="hinge", c=0.1, s=0.2, vs=0.05)
    assert parsed("viscous_friction@hinge", pendulum) == ViscousFriction(joint="hinge")
    assert shown(found) == "stribeck_friction@hinge (c = 0.1 N m, s = 0.2 N m, vs = 0.05 rad/s)"


def test_of_many_parameters_only_those_that_say_something_are_told(swimmer: Robot) -> None:
    found = parsed("linear_drag@hull:x=2.5,rz=0.25", swimmer)
    assert shown(found) == "linear_drag@hull (x = 2.5 N s/m, rz = 0.25 N m s/rad)"


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
@pytest.mark.parametrize("name", ["hexapod_swimmer", "pendulum"])
def test_every_effect_can_be_asked_for_at_every_place(kind: type, name: str) -> None:
    robot = load(name)
    for place in kind.places(robot)[:3]:  # type: ignore[attr-defined]
        effect = kind.at(place)  # type: ignore[attr-defined]
        values = ",".join(f"{p.name}={getattr(effect, p.name)!r}" for p in effect.parameters())
        assert parsed(f"{kind.name}@{place}" + f":{values}" * bool(values), robot) == effect  # type: ignore[attr-defined]


def test_the_world_need_not_be_named(swimmer: Robot) -> None:
    worldly = [kind for kind in EFFECTS if kind.kind == "world"]
    assert worldly
    for kind in worldly:
        assert parsed(kind.name, swimmer) == kind.at("world")
        if kind.parameters():
            one = kind.parameters()[0]
            assert parsed(f"{kind.name}:{one.name}={one.high!r}", swimmer) == replace(
                kind.at("world"),
                **{one.name: one.high},  # type: ignore[type-var]
            )


def test_a_place_may_hold_a_colon(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><body name='a'><joint name='left:hip'/><geom size='0.1'/></body>"
        "</worldbody></mujoco>"
    )
    robot = load(tmp_path / "robot.xml")
    found = parsed("viscous_friction@left:hip:b=0.5", robot)
    assert found == ViscousFriction(joint="left:hip", b=0.5)
    assert parsed("viscous_friction@left:hip", robot) == ViscousFriction(joint="left:hip")


@pytest.mark.parametrize(
    ("text", "what", "fix"),
    [
        ("viscus_friction@hinge", "there is no effect 'viscus_friction'", "'viscous_friction'"),
        ("", "there is no effect ''", "morph list effects"),
        ("viscous_friction", "acts on a joint, and none is named", "viscous_friction@hinge:"),
        ("torque_scale@", "acts on an actuator, and none is named", "torque_scale@hinge:"),
        ("viscous_friction@hunge:b=1", "pendulum has no joint 'hunge'", "'hinge'"),
        ("viscous_friction@hinge:c=1", "has no parameter 'c'; it has b N m s/rad", "b=VALUE"),
        ("viscous_friction@hinge:b=much", "b = 'much' is no finite number", "give b from 0"),
        ("viscous_friction@hinge:b=nan", "b = 'nan' is no finite number", "give b from 0"),
        ("viscous_friction@hinge:b=inf", "b = 'inf' is no finite number", "give b from 0"),
        ("viscous_friction@hinge:b=", "b = '' is no finite number", "give b from 0"),
        ("viscous_friction@hinge:b=1,b=2", "b is given twice", "give b once"),
        ("viscous_friction@hinge:b=-1", "b = -1 N m s/rad is outside 0 to", "within these bounds"),
        ("viscous_friction@hinge:=1", "has no parameter ''", "b=VALUE"),
        ("ground@moon:height=1", "acts on the world, not on 'moon'", "say ground@world"),
    ],
)
def test_what_cannot_be_is_refused_in_three_parts(
    pendulum: Robot, text: str, what: str, fix: str
) -> None:
    with pytest.raises(EffectError) as caught:
        parsed(text, pendulum)
    assert what in caught.value.what
    assert fix in caught.value.fix
    assert caught.value.where.startswith(("--effect", "effect "))


def test_an_effect_at_the_same_place_changes_that_of_the_file(
    pendulum: Robot, tmp_path: Path
) -> None:
    path = tmp_path / "corrected.toml"
    other = StribeckFriction(joint="hinge", c=0.1, s=0.2)
    path.write_text(effects_text((ViscousFriction(joint="hinge", b=0.3), other)))
    assert asked_effects(pendulum, (), file=path) == (ViscousFriction(joint="hinge", b=0.3), other)
    mixed = asked_effects(pendulum, ("stribeck_friction@hinge:c=0.05",), file=path)
    # What is not told, s, stays the file's.
    changed = StribeckFriction(joint="hinge", c=0.05, s=0.2)
    assert mixed == (ViscousFriction(joint="hinge", b=0.3), changed)


def test_one_effect_asked_for_twice_is_refused(pendulum: Robot) -> None:
    with pytest.raises(EffectError, match="viscous_friction@hinge is asked for twice"):
        asked_effects(pendulum, ("viscous_friction@hinge:b=1", "viscous_friction@hinge:b=2"))


def test_one_effect_twice_in_a_file_is_refused(pendulum: Robot, tmp_path: Path) -> None:
    path = tmp_path / "corrected.toml"
    path.write_text(effects_text(tuple(ViscousFriction(joint="hinge", b=b) for b in (0.1, 0.2))))
    with pytest.raises(EffectError, match="viscous_friction@hinge is asked for twice"):
        asked_effects(pendulum, (), file=path)


def test_one_contact_from_both_its_sides_is_refused() -> None:
    texts = ("contact_friction@foot+torso:mu=0.1", "contact_friction@torso+foot:mu=0.9")
    with pytest.raises(EffectError, match="is asked for twice"):
        asked_effects(load("hopper"), texts)


def test_a_file_for_another_robot_is_refused(pendulum: Robot, tmp_path: Path) -> None:
    path = tmp_path / "corrected.toml"
    path.write_text(effects_text((ViscousFriction(joint="knee", b=0.3),)))
    with pytest.raises(EffectError, match="pendulum has no joint 'knee'") as caught:
        asked_effects(pendulum, (), file=path)
    assert caught.value.where == f"{path}, viscous_friction@knee"
