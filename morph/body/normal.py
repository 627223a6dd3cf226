"""From an MjSpec, however it was read, to a Robot with explicit inertias."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.body.card import Card
from morph.body.fulltext import fulltext
from morph.body.robot import Actuator, Joint, Link, Robot
from morph.errors import RobotError
from morph.files import sha256

UNNAMED = "MuJoCo Model"
"""What MuJoCo calls a model whose description names none."""


def compiled(spec: Any, source: Path) -> Any:
    """Return the compiled `mujoco.MjModel` of a spec.

    Raises:
        RobotError: It does not compile; MuJoCo's own words are given.
    """
    try:
        return spec.compile()
    except ValueError as error:
        raise refused(error, source) from error


def refused(error: Exception, source: Path) -> RobotError:
    """Return MuJoCo's refusal of a description as an error of ours."""
    words = " ".join(str(error).split())
    return RobotError(
        f"MuJoCo cannot use it: {words}",
        where=str(source),
        fix="correct the element that MuJoCo names",
    )


def robot_of(spec: Any, source: Path, card: Card | None) -> Robot:
    """Return the Robot that a `mujoco.MjSpec` describes; the spec is used up.

    Raises:
        RobotError: The spec does not compile, a mesh cannot be read, or an
            actuator drives no joint.
    """
    _name_the_unnamed(spec)
    assets = _embed(spec, source)
    model = compiled(spec, source)
    _settle_inertias(spec, model)
    name = spec.modelname if spec.modelname not in ("", UNNAMED) else source.stem
    card_text = (source.parent / "card.toml").read_bytes() if card else b""
    return Robot(
        name=card.name if card else name,
        links=tuple(_link(model, index) for index in range(1, model.nbody)),
        joints=tuple(_joint(model, index) for index in range(model.njnt)),
        actuators=tuple(_actuator(model, index, source) for index in range(model.nu)),
        mjcf=fulltext(spec),
        assets=assets,
        source=source,
        sha256=sha256(source, card_text, *(assets[key] for key in sorted(assets))),
        card=card,
    )


def _settle_inertias(spec: Any, model: Any) -> None:
    # Inertias are written as MuJoCo compiled them, so that no later reader
    # derives them from geoms again, nor scales or mends them again.
    for body in spec.bodies[1:]:
        if model.body_mass[body.id] > 0:
            body.mass = float(model.body_mass[body.id])
            body.ipos = model.body_ipos[body.id]
            body.iquat = model.body_iquat[body.id]
            body.inertia = model.body_inertia[body.id]
            body.fullinertia = np.full(6, np.nan)
            body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
            body.explicitinertial = True
    compiler = spec.compiler
    compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    compiler.balanceinertia = False
    compiler.boundmass = compiler.boundinertia = 0.0
    compiler.settotalmass = -1.0


def _name_the_unnamed(spec: Any) -> None:
    for index, body in enumerate(spec.bodies[1:], start=1):
        body.name = body.name or f"link_{index}"
    for index, joint in enumerate(spec.joints):
        joint.name = joint.name or f"joint_{index}"
    for index, actuator in enumerate(spec.actuators):
        actuator.name = actuator.name or actuator.target or f"actuator_{index}"


def _embed(spec: Any, source: Path) -> dict[str, bytes]:
    assets: dict[str, bytes] = {}
    folders = (
        (spec.meshes, spec.compiler.meshdir),
        (spec.hfields, spec.compiler.meshdir),
        (spec.textures, spec.compiler.texturedir),
    )
    for elements, folder in folders:
        for element in elements:
            if element.file:
                path = source.parent / folder / element.file
                element.file = f"{len(assets)}_{path.name}"
                assets[element.file] = _bytes(path, source)
    spec.compiler.meshdir = spec.compiler.texturedir = ""
    spec.assets = assets
    return assets


def _bytes(path: Path, source: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise RobotError(
            f"names {path}, which cannot be read: {error.strerror or error}",
            where=str(source),
            fix="put the file there, or correct its name in the description",
        ) from error


def _link(model: Any, index: int) -> Link:
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[index])
    axes = turn.reshape(3, 3)
    inertia = axes @ np.diag(model.body_inertia[index]) @ axes.T
    x, y, z = model.body_ipos[index].tolist()
    return Link(
        name=model.body(index).name,
        mass=float(model.body_mass[index]),
        com=(x, y, z),
        inertia=tuple(
            float(inertia[row, column])
            for row, column in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        ),
    )


def _joint(model: Any, index: int) -> Joint:
    kinds = {
        mujoco.mjtJoint.mjJNT_FREE: "free",
        mujoco.mjtJoint.mjJNT_BALL: "ball",
        mujoco.mjtJoint.mjJNT_SLIDE: "slide",
        mujoco.mjtJoint.mjJNT_HINGE: "hinge",
    }
    low, high = model.jnt_range[index].tolist()
    return Joint(
        name=model.joint(index).name,
        kind=kinds[mujoco.mjtJoint(model.jnt_type[index])],
        link=model.body(model.jnt_bodyid[index]).name,
        limits=(low, high) if model.jnt_limited[index] else None,
    )


def _actuator(model: Any, index: int, source: Path) -> Actuator:
    name = model.actuator(index).name
    if model.actuator_trntype[index] != mujoco.mjtTrn.mjTRN_JOINT:
        raise RobotError(
            f"the actuator {name!r} drives no joint",
            where=str(source),
            fix="give the actuator a joint",
        )
    return Actuator(
        name=name,
        joint=model.joint(model.actuator_trnid[index, 0]).name,
        kind="position" if _is_servo(model, index) else "motor",
    )


def _is_servo(model: Any, index: int) -> bool:
    # The inputs that an actuator takes are bits; none set means it does not say.
    says = int(model.actuator_ctrlspec[index])
    if says:
        return bool(says & int(mujoco.mjtCtrlInput.mjINPUT_POS))
    # One that pulls back in proportion to the joint's position is a servo.
    affine = model.actuator_biastype[index] == mujoco.mjtBias.mjBIAS_AFFINE
    return bool(affine and model.actuator_biasprm[index, 1] != 0)
