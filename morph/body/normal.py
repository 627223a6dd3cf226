"""From an MjSpec, however it was read, to a Robot with explicit inertias."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.body.actuators import actuator_of
from morph.body.card import MOST_BYTES, Card
from morph.body.finding import DescriptionFinding, Where
from morph.body.follow import followers, from_zero
from morph.body.fulltext import fulltext
from morph.body.mesh import mesh_content
from morph.body.quiet import quiet
from morph.body.robot import ClosedChain, Joint, Link, Mimic, Robot, Sensor
from morph.body.weight import check_model
from morph.errors import MeshError, RobotError
from morph.files import sha256
from morph.regular_file import read_regular

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
    words = " ".join(str(error).split()) or type(error).__name__
    return RobotError(
        f"MuJoCo cannot use it: {words}",
        where=str(source),
        fix="correct the element that MuJoCo names",
    )


def robot_of(
    spec: Any, source: Path, card: Card | None, assets: dict[str, bytes] | None = None
) -> Robot:
    """Return the Robot that a `mujoco.MjSpec` describes; the spec is used up.

    Args:
        spec: The spec.
        source: The file that it was read from.
        card: What the shelf knows about it.
        assets: The content of the files that the spec names, by name; None: they
            lie beside the source.

    Raises:
        RobotError: The spec does not compile, a mesh cannot be read, or an
            actuator turns an orientation.
    """
    _name_the_unnamed(spec)
    if assets is None:
        assets = _embed(spec, source)
    spec.assets = assets
    with quiet() as warned:
        model = compiled(spec, source)
    check_model(model, source)
    sources = _sources(spec)
    _settle_inertias(spec, model)
    follows, _ = followers(model)
    name = spec.modelname if spec.modelname not in ("", UNNAMED) else source.stem
    card_text = read_regular(source.parent / "card.toml", MOST_BYTES) if card else b""
    return Robot(
        name=card.name if card else name,
        links=tuple(_link(model, index, sources[index]) for index in range(1, model.nbody)),
        joints=tuple(_joint(model, index, follows.get(index)) for index in range(model.njnt)),
        actuators=tuple(actuator_of(model, index, source) for index in range(model.nu)),
        mjcf=fulltext(spec),
        assets=assets,
        source=source,
        sha256=sha256(source, card_text, *(assets[key] for key in sorted(assets))),
        card=card,
        findings=tuple(_warning(words, spec.modelname, source) for words in warned),
        sensors=tuple(_sensor(model, index) for index in range(model.nsensor)),
        loops=tuple(_loop(model, index) for index in range(model.neq) if _closes(model, index)),
    )


def _warning(words: str, name: str, source: Path) -> DescriptionFinding:
    return DescriptionFinding(
        code="engine-warning",
        severity="info",
        where=Where(kind="robot", name=name, file=str(source)),
        what=f"MuJoCo warns: {words}",
        fix="correct what it names; tiny masses far down a chain make a matrix near singular",
    )


def _sources(spec: Any) -> dict[int, str]:
    """Return where each body's inertia comes from."""
    always = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    return {
        body.id: "mesh x density" if always or not body.explicitinertial else "description"
        for body in spec.bodies
    }


def _settle_inertias(spec: Any, model: Any) -> None:
    # Inertias are written as MuJoCo compiled them, so that no later reader
    # derives them from geoms again, nor scales or mends them again.
    for body in spec.bodies[1:]:
        ground = mujoco.mjtGeom.mjGEOM_HFIELD in [geom.type for geom in body.geoms]
        if ground and not body.explicitinertial and not model.body_weldid[body.id]:
            # MuJoCo weighs a field of hills at tons; it is no part of a robot.
            model.body_mass[body.id], model.body_inertia[body.id] = 0.0, 0.0
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
    return assets


def _bytes(path: Path, source: Path) -> bytes:
    try:
        return mesh_content(path)
    except MeshError as error:
        raise RobotError(
            f"names {path}, which {error.what}",
            where=str(source),
            fix="put the file there, or correct its name in the description",
        ) from error


def _link(model: Any, index: int, origin: str) -> Link:
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
        inertia_from=origin if model.body_mass[index] > 0 else "none",
        parent=model.body(model.body_parentid[index]).name,
        shapes=tuple(_shapes(model, index)),
    )


def _shapes(model: Any, body: int) -> list[str]:
    first = model.body_geomadr[body]
    geoms = range(first, first + model.body_geomnum[body])
    words = []
    for geom in geoms:
        kind = mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()
        touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
        words.append(f"{'collision' if touches else 'visual'} {kind}")
    return sorted(words, reverse=True)


def _joint(model: Any, index: int, mimic: Mimic | None) -> Joint:
    kinds = {
        mujoco.mjtJoint.mjJNT_FREE: "free",
        mujoco.mjtJoint.mjJNT_BALL: "ball",
        mujoco.mjtJoint.mjJNT_SLIDE: "slide",
        mujoco.mjtJoint.mjJNT_HINGE: "hinge",
    }
    low, high = model.jnt_range[index].tolist()
    x, y, z = model.jnt_axis[index].tolist()
    strongest = float(np.abs(model.jnt_actfrcrange[index]).max())
    dof = int(model.jnt_dofadr[index])
    return Joint(
        name=model.joint(index).name,
        kind=kinds[mujoco.mjtJoint(model.jnt_type[index])],
        link=model.body(model.jnt_bodyid[index]).name,
        limits=(low, high) if model.jnt_limited[index] else None,
        axis=(x, y, z),
        effort=strongest if model.jnt_actfrclimited[index] else None,
        damping=float(model.dof_damping[dof]),
        friction=float(model.dof_frictionloss[dof]),
        mimic=mimic and from_zero(model, index, mimic),
    )


def _sensor(model: Any, index: int) -> Sensor:
    kind = mujoco.mjtSensor(model.sensor_type[index]).name.removeprefix("mjSENS_").lower()
    sort, part = model.sensor_objtype[index], model.sensor_objid[index]
    name = mujoco.mj_id2name(model, sort, part) if part >= 0 else None
    return Sensor(name=model.sensor(index).name, kind=kind, part=name or "")


def _closes(model: Any, index: int) -> bool:
    kind = mujoco.mjtEq(model.eq_type[index])
    return kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD)


def _loop(model: Any, index: int) -> ClosedChain:
    ends = model.eq_obj1id[index], model.eq_obj2id[index]
    if model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE:
        ends = tuple(model.site_bodyid[end] for end in ends)
    kind = "weld" if model.eq_type[index] == mujoco.mjtEq.mjEQ_WELD else "connect"
    first, second = (model.body(int(end)).name for end in ends)
    return ClosedChain(name=model.equality(index).name, kind=kind, links=(first, second))
