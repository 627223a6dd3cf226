"""Every body of the built-in shelf, against its card and against Pinocchio."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

from morph.arrays import Array
from morph.body import shelf
from morph.body.load import load
from morph.body.robot import FREEDOMS
from morph.body.spec import spec_of
from morph.body.twin import twin_of
from morph.body.vary import OPERATIONS

BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())

BAD = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL)
BAD += (mujoco.mjtWarning.mjWARN_BADQACC, mujoco.mjtWarning.mjWARN_BADCTRL)

WORDS = {kind.name for kind in OPERATIONS if kind.amount}
"""The operations that a card's parameter may name: those with an amount to set."""

# A source must let a reader look the number up, or say that there is nothing to look up. So it
# holds what a reader can follow, or one of the words that own up to the author or to arithmetic.
TRACES = (
    r"(?<![\w.])(?:18|19|20)\d\d(?![\w.]*\d)",  # The year of a publication.
    r"\bat [0-9a-f]{7,40}\b",  # A commit.
    r"\b[a-z-]+\.(?:com|fr|org)/",  # An address.
    r"\b\w+\.(?:json|md|m|py|toml|urdf|xacro|xml|yml)\b|\brobots/\w+",  # A file.
    r"(?i)\b(?:chosen|assumed|drawn|derived|uniform)\b",
)


def poses(model: Any) -> list[Array]:
    """Return the pose at rest and three random ones; quaternions have length one."""
    data, rng = mujoco.MjData(model), np.random.default_rng(3)
    found = [model.qpos0.copy()]
    for _ in range(3):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 1.0)
        found.append(data.qpos.copy())
    return found


def as_pinocchio(model: Any, pose: Array) -> Array:
    """Return a pose with its quaternions as x, y, z, w: MuJoCo's begin with w."""
    turned = pose.copy()
    for kind, start in zip(model.jnt_type, model.jnt_qposadr, strict=True):
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            turned[start + 3 : start + 7] = np.roll(pose[start + 3 : start + 7], -1)
        elif kind == mujoco.mjtJoint.mjJNT_BALL:
            turned[start : start + 4] = np.roll(pose[start : start + 4], -1)
    return turned


@pytest.mark.parametrize("name", BODIES)
def test_a_body_weighs_and_moves_as_its_card_says(name: str) -> None:
    robot = load(name)
    assert robot.card is not None
    checks = robot.card.checks
    assert checks.mass_kg is not None
    assert checks.dof is not None
    assert abs(robot.mass - checks.mass_kg) < 1e-9
    assert sum(FREEDOMS[joint.kind] for joint in robot.joints) == checks.dof


@pytest.mark.parametrize("name", BODIES)
def test_a_card_names_its_sources_and_only_parts_that_there_are(name: str) -> None:
    robot = load(name)
    assert robot.card is not None
    assert robot.card.source
    assert all(source.what and source.from_ for source in robot.card.source)
    parts = {link.name for link in robot.links} | {joint.name for joint in robot.joints} | {"*"}
    for parameter in robot.card.parameter:
        assert parameter.link in parts, parameter.name
        assert parameter.operation in WORDS, parameter.name
        assert parameter.low < parameter.high, parameter.name
    if robot.card.water is not None:
        assert robot.card.water.mass_kg == pytest.approx(robot.mass, abs=1e-9)


@pytest.mark.parametrize("name", BODIES)
def test_a_source_can_be_looked_up_or_says_that_a_number_is_chosen(name: str) -> None:
    card = load(name).card
    assert card is not None
    vague = [one for one in card.source if not any(re.search(trace, one.from_) for trace in TRACES)]
    assert vague == []


@pytest.mark.parametrize(
    ("words", "followed"),
    [
        ("9 g and 1.8 kgf cm at 4.8 V, as its sellers state", False),
        ("Handbook values; a length of 0.2014 m, at 1040 kg/m3", False),
        ("The maker's e-manual, page mx-28", False),
        ("Winter 2009, table 4.1", True),
        ("owner/robot at f21ff7e, joint origins", True),
        ("emanual.robotis.com/docs/en/dxl/mx/mx-28", True),
        ("Assumed", True),
    ],
)
def test_what_sellers_or_a_handbook_say_is_no_source(words: str, followed: bool) -> None:
    assert any(re.search(trace, words) for trace in TRACES) == followed


@pytest.mark.parametrize("name", BODIES)
def test_every_actuator_drives_a_joint_that_there_is(name: str) -> None:
    robot = load(name)
    assert robot.card is not None
    for actuator in robot.actuators:
        assert robot.joint(actuator.joint).kind in ("hinge", "slide")
    assert {motor.actuator for motor in robot.card.motor} == {a.name for a in robot.actuators}


@pytest.mark.parametrize("name", BODIES)
def test_every_file_that_a_description_names_is_in_its_folder(name: str) -> None:
    robot = load(name)
    assert robot.source is not None
    tree = ElementTree.parse(robot.source)
    compiler = tree.find(".//compiler")
    below = "" if compiler is None else compiler.get("meshdir", "")
    named = [element.get(key, "") for element in tree.iter() for key in ("file", "filename")]
    for file in filter(None, named):
        candidates = (robot.source.parent / file, robot.source.parent / below / file)
        assert any(path.is_file() for path in candidates), file


@pytest.mark.parametrize("name", BODIES)
def test_every_link_has_an_inertia_that_a_body_can_have(name: str) -> None:
    for link in load(name).links:
        if link.mass == 0.0:
            continue
        xx, yy, zz, xy, xz, yz = link.inertia
        least, middle, most = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert least > 0.0, link.name
        # A flat plate has least + middle = most, which rounding may miss by 1e-16 of it.
        assert least + middle >= most * (1 - 1e-9), link.name


@pytest.mark.parametrize("name", BODIES)
def test_pinocchio_finds_the_same_mass_centre_and_inertia(name: str) -> None:
    # Pinocchio knows no equality constraints: both give the inertia of the open tree.
    robot = load(name)
    model, twin = spec_of(robot).compile(), twin_of(robot)
    data, notes, full = mujoco.MjData(model), twin.createData(), np.zeros((model.nv, model.nv))
    # Links held to the world move with no joint, and Pinocchio leaves them out of its sums.
    mass = np.where(model.body_weldid > 0, model.body_mass, 0.0)
    assert sum(body.mass for body in twin.inertias) == pytest.approx(robot.mass, rel=1e-9)
    for pose in poses(model):
        data.qpos[:] = pose
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        turned = as_pinocchio(model, pose)
        centre = pinocchio.centerOfMass(twin, notes, turned)
        # Poses are a few metres wide: 1e-9 of a metre is a million times their rounding.
        assert np.abs(mass @ data.xipos / mass.sum() - centre).max() < 1e-9
        upper = np.triu(pinocchio.crba(twin, notes, turned))
        theirs = np.linalg.eigvalsh(upper + np.triu(upper, 1).T)
        ours = np.linalg.eigvalsh(full)
        # 1e-9 of each; and eigvalsh itself errs by 1e-16 of the greatest, here times 1000.
        assert (np.abs(ours - theirs) < 1e-9 * ours + 1e-13 * ours.max()).all()


@pytest.mark.parametrize("name", BODIES)
def test_a_second_at_rest_and_a_second_of_half_its_effort_stay_finite(name: str) -> None:
    model = spec_of(load(name)).compile()
    data = mujoco.MjData(model)
    top = np.where(model.actuator_ctrllimited > 0, model.actuator_ctrlrange[:, 1], 0.1)
    for command in (np.zeros(model.nu), 0.5 * top):
        mujoco.mj_resetData(model, data)
        data.ctrl[:] = command
        for _ in range(round(1.0 / model.opt.timestep)):
            mujoco.mj_step(model, data)
        # MuJoCo starts anew after a bad state, so the end alone would not show it.
        assert not any(data.warning[kind].number for kind in BAD)
        assert data.time == pytest.approx(1.0)
        assert np.isfinite(np.concatenate([data.qpos, data.qvel, data.qacc])).all()
