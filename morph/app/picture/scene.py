"""What stands around a robot in a picture, and nowhere else: floor, sky, light, water."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SimulationFailed
from morph.physics.apply import apply
from morph.physics.contact.floor import FLOOR as TOUCHED
from morph.physics.contact.floor import NOWHERE
from morph.physics.effect import Effect

FLOOR = "picture_floor"
"""Name of the floor that is only in the picture."""

WET = {"added_mass", "buoyancy", "linear_drag", "quadratic_drag", "fluid_current", "thrust"}
"""Effects that mean water."""

Colour = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Mood:
    """The colours of a world, each red, green and blue from 0 to 1."""

    zenith: Colour
    """The sky, high up."""
    nadir: Colour
    """The sky, deep down; at the horizon it is the mean of both, and so is what is far."""
    tiles: tuple[Colour, Colour]
    """The floor's two kinds of tile."""
    joints: Colour
    """The lines between them."""
    ambient: float
    """Light that comes from everywhere."""
    diffuse: Colour
    """The lamp's light."""


STUDIO = Mood(
    zenith=(0.52, 0.66, 0.84),
    nadir=(1.0, 1.0, 1.0),
    tiles=((0.80, 0.82, 0.85), (0.74, 0.765, 0.80)),
    joints=(0.68, 0.70, 0.74),
    ambient=0.36,
    diffuse=(0.62, 0.61, 0.58),
)
"""Dry land."""

WATER = Mood(
    zenith=(0.30, 0.66, 0.76),
    nadir=(0.02, 0.18, 0.30),
    tiles=((0.34, 0.50, 0.50), (0.28, 0.44, 0.46)),
    joints=(0.22, 0.38, 0.42),
    ambient=0.42,
    diffuse=(0.52, 0.64, 0.66),
)
"""Below the surface."""


def is_wet(effects: Sequence[Effect]) -> bool:
    """Return whether a simulation takes place in water."""
    return any(effect.name in WET for effect in effects)


def scene_model(robot: Robot, effects: Sequence[Effect], size: tuple[int, int]) -> Any:
    """Return a `mujoco.MjModel` to draw: the robot under its effects, in a world that looks good.

    What the description already has is kept: its own floor, sky and lights. A floor that is
    only drawn touches nothing; `settle` says where it lies.

    Args:
        robot: The robot.
        effects: What acts on it; some bring a ground.
        size: Width and height of the picture, pixels.

    Raises:
        SimulationFailed: MuJoCo refuses the scene.
    """
    spec = spec_of(robot)
    apply(spec, effects)
    mood = WATER if is_wet(effects) else STUDIO
    spec.visual.global_.offwidth, spec.visual.global_.offheight = size
    spec.visual.quality.shadowsize, spec.visual.quality.offsamples = 2048, 4
    _sky(spec, mood)
    _floor(spec, mood)
    _light(spec, mood)
    try:
        return spec.compile()
    except ValueError as error:
        raise SimulationFailed(
            f"MuJoCo refuses to draw it: {error}",
            where=f"robot {robot.name}",
            fix="leave out --video; the recording does not need it",
        ) from error


def settle(model: Any, lowest: float, radius: float, *, wet: bool) -> None:
    """Fit the scene to what moves in it: floor, tiles, depth of view and reach of the lamp.

    Args:
        model: What `scene_model` gave; changed.
        lowest: The lowest point that the robot reaches, m: there the drawn floor lies.
        radius: Of what must be in the picture, m.
        wet: Whether it is in water, where the floor lies deeper and all fades with distance.
    """
    model.stat.extent = radius
    model.vis.map.znear, model.vis.map.zfar = 0.02, 400.0
    model.vis.map.shadowclip = 4.0
    model.vis.map.fogstart, model.vis.map.fogend = (4.0, 26.0) if wet else (8.0, 60.0)
    for geom in range(model.ngeom):
        if model.geom(geom).name == FLOOR:
            model.geom_pos[geom] = (0.0, 0.0, lowest - (0.6 * radius if wet else 0.0))
    for material in range(model.nmat):
        if model.mat(material).name == FLOOR:
            # With uniform textures the checker of two by two tiles repeats so often a metre.
            model.mat_texrepeat[material] = 0.5 / rounded(0.5 * radius)


def rounded(length: float) -> float:
    """Return the greatest of 1, 2 and 5 times a power of ten that is at most a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return next(many * power for many in (5.0, 2.0, 1.0) if many * power <= length * (1 + 1e-9))


def _sky(spec: Any, mood: Mood) -> None:
    skybox = mujoco.mjtTexture.mjTEXTURE_SKYBOX
    if not any(texture.type == skybox for texture in spec.textures):
        spec.add_texture(
            name="picture_sky",
            type=skybox,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
            rgb1=mood.zenith,
            rgb2=mood.nadir,
            width=512,
            height=512,
        )
    red, green, blue = (0.5 * (up + down) for up, down in zip(mood.zenith, mood.nadir, strict=True))
    spec.visual.rgba.haze = spec.visual.rgba.fog = (red, green, blue, 1.0)


def _floor(spec: Any, mood: Mood) -> None:
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    ground = (plane, mujoco.mjtGeom.mjGEOM_HFIELD)
    # An effect on contacts may have put a floor where nothing touches it.
    standing = [
        geom
        for geom in spec.worldbody.geoms
        if geom.type in ground and not (geom.name == TOUCHED and geom.pos[2] <= NOWHERE)
    ]
    if any(geom.material for geom in standing):
        return
    spec.add_texture(
        name=FLOOR,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        mark=mujoco.mjtMark.mjMARK_EDGE,
        rgb1=mood.tiles[0],
        rgb2=mood.tiles[1],
        markrgb=mood.joints,
        width=512,
        height=512,
    )
    material = spec.add_material(
        name=FLOOR,
        texuniform=True,
        specular=0.1,
        shininess=0.1,
    )
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = FLOOR
    for geom in standing:
        geom.material, geom.group = FLOOR, 0
    if not standing:
        spec.worldbody.add_geom(
            name=FLOOR,
            type=plane,
            # Not at zero: there MuJoCo would take the world's own place for the floor's.
            pos=(0.0, 0.0, -1.0),
            size=(0.0, 0.0, 1.0),
            material=FLOOR,
            contype=0,
            conaffinity=0,
            group=0,
        )


def _light(spec: Any, mood: Mood) -> None:
    if spec.lights:
        return
    spec.visual.headlight.ambient = (mood.ambient,) * 3
    spec.visual.headlight.diffuse = (0.22, 0.22, 0.22)
    spec.visual.headlight.specular = (0.05, 0.05, 0.05)
    spec.worldbody.add_light(
        name="picture_lamp",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(0.0, 0.0, 4.0),
        dir=(0.35, 0.45, -1.0),
        diffuse=mood.diffuse,
        specular=(0.25, 0.25, 0.25),
        castshadow=True,
    )
