"""Laws of bodies, of the fluid and of the world, as `effects.md` states them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.concealed.law import Figures, Law, Setting
from experiments.concealed.mechanism import STANDARD_GRAVITY, Mechanism
from experiments.concealed.plant import Array, Plant

WATER = 1000.0
"""Density of fresh water, kg/m3."""
PADDLE = 0.12
"""Height of the submerged arm's paddle, m; its description tells it."""
AT_POINT = ("x", "y", "z", "cx", "cy", "cz")
"""Figures that nobody can know who is not told the point to which they refer."""


def _vector(figures: Figures) -> Array:
    return np.array([figures["x"], figures["y"], figures["z"]])


def _direction(x: Setting) -> Array:
    """Return a unit vector that the setting's chance fixes."""
    raw = np.cos(2 * np.pi * x.chance[:3]) + 0.3
    return np.asarray(raw / np.linalg.norm(raw))


def _xyz(vector: Array) -> dict[str, float]:
    return dict(zip("xyz", (float(each) for each in vector), strict=True))


def point_inertia(offset: Array) -> Array:
    """Return the inertia of a unit mass at an offset, shape (3, 3)."""
    return np.asarray((offset @ offset) * np.eye(3) - np.outer(offset, offset))


def add_mass(plant: Plant, i: int, mass: float, at: Array) -> Plant:
    """Return a plant whose body i has one more point mass; a negative one takes away."""
    before, com = float(plant.of_body("mass")[i]), plant.com[i]
    total = before + mass
    centre = (before * com + mass * at) / total
    inertia = (
        plant.inertia[i] + before * point_inertia(com - centre) + mass * point_inertia(at - centre)
    )
    return plant.with_body(i, mass=total).with_com(i, centre).with_inertia(i, inertia)


def _scale_link(plant: Plant, i: int, f: Figures) -> Plant:
    heavier = plant.with_body(i, mass=plant.of_body("mass")[i] * f["mass"])
    return heavier.with_inertia(i, plant.inertia[i] * f["inertia"])


def _link_beside(f: Figures, described: Plant, true: Plant, i: int) -> Figures:
    mass = true.of_body("mass")[i] / described.of_body("mass")[i]
    inertia = np.trace(true.inertia[i]) / np.trace(described.inertia[i])
    return {"mass": f["mass"] * float(mass), "inertia": f["inertia"] * float(inertia)}


def _tilt(plant: Plant, i: int, f: Figures) -> Plant:
    """Turn gravity as a base that stands rolled about x, then pitched about y, feels it."""
    a, b = f["roll"], f["pitch"]
    roll = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    pitch = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    return replace(plant, gravity=(pitch @ roll).T @ plant.gravity)


def _at_point(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_body(i, fx=f["cx"], fy=f["cy"], fz=f["cz"])


def _point(x: Setting) -> dict[str, float]:
    return dict(zip(("cx", "cy", "cz"), (float(each) for each in 0.8 * x.tip), strict=True))


def _wet(mechanism: Mechanism, i: int) -> bool:
    return mechanism.submerged


def _blows(mechanism: Mechanism, i: int) -> bool:
    return mechanism.submerged and i == mechanism.plant.count - 1


def _along(name: str, size: float, x: Setting) -> Figures:
    return {**_xyz(size * (0.4 + 0.6 * x.chance[3:6])), **_point(x)}


def _fluid(field: str) -> Law:
    """Return the drag of a name, its figures along the body's axes."""
    power = 1 if field == "linear" else 2

    def figures(size: float, x: Setting) -> Figures:
        speed = x.of("speed") * (0.8 * x.lever)
        return _along(field, size * x.of("effort") / (0.8 * x.lever * speed**power), x)

    def apply(plant: Plant, i: int, f: Figures) -> Plant:
        x, y, z = _vector(f)
        return _at_point(plant, i, f).with_body(i, **{field: x, f"{field}_y": y, f"{field}_z": z})

    return Law(
        name=f"{field}_drag", kind="body", figures=figures, apply=apply, acts=_wet, given=AT_POINT,
    )  # fmt: skip


def _added(plant: Plant, i: int, f: Figures) -> Plant:
    x, y, z = _vector(f)
    return _at_point(plant, i, f).with_body(i, added=x, added_y=y, added_z=z)


def _buoyant(plant: Plant, i: int, f: Figures) -> Plant:
    lift = f["density"] * f["volume"] * STANDARD_GRAVITY
    return _at_point(plant, i, f).with_body(i, buoyancy=lift)


def _thrust(plant: Plant, i: int, f: Figures) -> Plant:
    moved = np.pi / 4 * f["density"] * f["span"] ** 2
    return _at_point(plant, i, f).with_body(i, thrust=f["C"] * moved)


def _payload(size: float, x: Setting) -> Figures:
    at = x.tip * (0.6 + 0.6 * x.chance[4]) + 0.3 * x.lever * (x.chance[:3] - 0.5)
    return {"m": size * x.mass, **_xyz(at)}


def _tether(size: float, x: Setting) -> Figures:
    anchor = x.lever * np.array([1.0, -0.5, 1.5]) + 0.5 * (x.chance[:3] - 0.5)
    stretch = 0.3 * x.lever + 0.1
    return {
        "k": size * x.of("effort") / (x.lever * stretch),
        "length": float(np.linalg.norm(anchor)) * (0.3 + 0.4 * x.chance[3]),
        **dict(zip(("ax", "ay", "az"), (float(each) for each in anchor), strict=True)),
        **_point(x),
    }


def _tie(plant: Plant, i: int, f: Figures) -> Plant:
    return _at_point(plant, i, f).with_body(
        i, tether_k=f["k"], tether_length=f["length"], anchor=f["ax"], anchor_y=f["ay"],
        anchor_z=f["az"],
    )  # fmt: skip


def _push(size: float, x: Setting) -> Figures:
    start, length = x.seconds * (0.2 + 0.6 * x.chance[3]), 0.05 + 0.25 * x.chance[4]
    force = 4.0 * size * x.of("peak") / x.lever
    return {"start": start, "end": start + length, **_xyz(force * length * _direction(x))}


def _pushed(plant: Plant, i: int, f: Figures) -> Plant:
    x, y, z = _vector(f) / (f["end"] - f["start"])
    return plant.with_body(i, push_start=f["start"], push_end=f["end"], push=x, push_y=y, push_z=z)


def _tilt_figures(size: float, x: Setting) -> Figures:
    angle = 2 * np.pi * x.chance[0]
    return {"roll": float(0.3 * size * np.cos(angle)), "pitch": float(0.3 * size * np.sin(angle))}


BODY_LAWS = (
    Law(
        name="payload", kind="body", figures=_payload, largest=3.0,
        apply=lambda plant, i, f: add_mass(plant, i, f["m"], _vector(f)),
        least=lambda x: x.vary["mass"] + 0.1,
    ),
    Law(
        name="com_offset", kind="body", largest=1.0,
        figures=lambda s, x: _xyz(0.5 * s * x.lever * _direction(x)),
        apply=lambda plant, i, f: plant.with_com(i, plant.com[i] + _vector(f)),
        beside=lambda f, described, true, i: _xyz(_vector(f) + true.com[i] - described.com[i]),
    ),
    Law(
        name="link_inertia", kind="body", apply=_scale_link, largest=1.5, beside=_link_beside,
        least=lambda x: float(np.log1p(max(x.vary["mass"], x.vary["inertia"]))) + 0.1,
        figures=lambda s, x: {
            "mass": float(np.exp(s * x.side)), "inertia": float(np.exp(s * x.side)),
        },
    ),
    _fluid("linear"),
    _fluid("quadratic"),
    Law(
        name="added_mass", kind="body", apply=_added, largest=3.0, acts=_wet,
        given=AT_POINT, least=lambda x: x.vary["mass"] + 0.1,
        figures=lambda s, x: _along("added", s * x.mass, x),
    ),
    Law(
        name="buoyancy", kind="body", apply=_buoyant, acts=_wet, largest=1.5,
        given=("volume", "density", "cx", "cy", "cz"), least=lambda x: x.vary["mass"] + 0.05,
        figures=lambda s, x: {"volume": s * x.mass / WATER, "density": WATER, **_point(x)},
    ),
    Law(
        name="thrust", kind="body", apply=_thrust, acts=_blows, largest=3.0,
        given=("C", "density", "span", "cx", "cy", "cz"),
        figures=lambda s, x: {"C": s, "density": WATER, "span": PADDLE, **_point(x)},
    ),
    Law(
        name="external_push", kind="body", figures=_push, apply=_pushed, largest=3.0,
    ),
    Law(
        name="tether", kind="body", figures=_tether, apply=_tie, largest=2.0,
        given=("k", "length", "ax", "ay", "az", "cx", "cy", "cz"),
    ),
)  # fmt: skip

WORLD_LAWS = (
    Law(name="base_tilt", kind="world", figures=_tilt_figures, apply=_tilt),
    Law(
        name="fluid_current", kind="world", needs="linear_drag", largest=2.0,
        acts=lambda mechanism, i: mechanism.submerged,
        figures=lambda s, x: _xyz(0.5 * s * _direction(x)),
        apply=lambda plant, i, f: replace(plant, current=_vector(f)),
    ),
)  # fmt: skip
