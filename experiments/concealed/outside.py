"""Physics that no law of `effects.md` describes; the right answer to it is `unknown`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.concealed.body_laws import add_mass
from experiments.concealed.law import Figures, Law, Setting, fields
from experiments.concealed.mechanism import Mechanism
from experiments.concealed.plant import Array, Plant, add_leaf


def _driven(mechanism: Mechanism, i: int) -> bool:
    return bool(mechanism.plant.of_joint("drive")[i])


def _hinge(mechanism: Mechanism, i: int) -> bool:
    return not mechanism.plant.slide[i]


def _across(plant: Plant, i: int) -> Array:
    """Return a unit vector across the joint's axis and the link, so that motion excites it."""
    vector = np.cross(plant.axis[i], plant.com[i] + 1e-3)
    return np.asarray(vector / np.linalg.norm(vector))


def _loose_figures(size: float, x: Setting) -> Figures:
    return {"share": 0.45 * min(size, 1.0), "frequency": 1.5 + 3.0 * x.chance[0], "damping": 0.1}


def _leaf(plant: Plant, i: int, f: Figures, *, slide: bool) -> Plant:
    """Hang a share of a link's mass on a spring inside it."""
    mass = f["share"] * float(plant.of_body("mass")[i])
    at = 1.5 * plant.com[i]
    rest = add_mass(plant, i, -mass, at)
    arm = 0.15 * float(np.linalg.norm(plant.com[i])) + 0.02
    pole = np.zeros(3) if slide else arm * plant.com[i] / np.linalg.norm(plant.com[i])
    axis = _across(plant, i) if slide else plant.axis[i]
    light = 1e-6 * mass * np.eye(3)
    leafy = add_leaf(
        rest, i, slide=slide, origin=at - pole, axis=axis, mass=mass, com=pole, inertia=light
    )
    moved = mass if slide else mass * arm**2
    rate = 2 * np.pi * f["frequency"]
    return leafy.with_joint(
        leafy.count - 1, stiffness=moved * rate**2, viscous=2 * f["damping"] * moved * rate
    )


def _sprung_figures(size: float, x: Setting) -> Figures:
    return {"share": 0.4 * min(size, 1.0), "frequency": 3.0 + 5.0 * x.chance[0], "damping": 0.05}


def _turn_axis(plant: Plant, i: int, f: Figures) -> Plant:
    """Turn the axis of a joint in its body by an angle, the posture at q = 0 unchanged."""
    axis, every = plant.axis[i], plant.axis.copy()
    aside = np.cross(axis, [f["x"], f["y"], f["z"]])
    aside /= np.linalg.norm(aside)
    every[i] = np.cos(f["angle"]) * axis + np.sin(f["angle"]) * aside
    return replace(plant, axis=every)


def _clock(plant: Plant, i: int, f: Figures) -> Plant:
    """Leave the plant as it is: the written times are wrong, see `readings.py`."""
    return plant


OUTSIDE_LAWS = (
    Law(
        name="loose_mass", kind="body", figures=_loose_figures, largest=1.0, acts=_hinge,
        apply=lambda plant, i, f: _leaf(plant, i, f, slide=True),
        why="a part of the link's mass slides on a soft spring across it",
    ),
    Law(
        name="second_resonance", kind="body", figures=_sprung_figures, largest=1.0, acts=_hinge,
        apply=lambda plant, i, f: _leaf(plant, i, f, slide=False),
        why="a part of the link's mass swings on a stiff spring",
    ),
    Law(
        name="axis_misalignment", kind="joint", apply=_turn_axis, largest=1.0,
        figures=lambda s, x: {
            "angle": 0.5 * s, "x": x.chance[0], "y": x.chance[1] - 0.5, "z": 0.7,
        },
        acts=lambda m, i: m.plant.count > 2,
        why="the joint's axis is off by an angle",
    ),
    Law(
        name="gear_transmission_error", kind="joint", apply=fields(e="tooth", n="tooth_n"),
        largest=0.5, acts=lambda m, i: _driven(m, i) and _hinge(m, i),
        figures=lambda s, x: {"e": 0.1 * s, "n": float(5 + int(10 * x.chance[0]))},
        why="the gear's ratio ripples with its angle; the encoder sits on the motor",
    ),
    Law(
        name="warming_viscosity", kind="joint", apply=fields(b="warm", rate="warm_rate"),
        figures=lambda s, x: {
            "b": 2 * s * x.of("effort") / x.of("speed"),
            "rate": 1.5 / (x.of("speed") ** 2 * x.seconds),
        },
        why="oil that thins as the joint's own friction warms it",
    ),
    Law(
        name="supply_ripple", kind="actuator", apply=fields(a="supply", f="supply_rate"),
        largest=0.8, acts=_driven,
        figures=lambda s, x: {"a": s, "f": 0.3 + 1.5 * x.chance[0]},
        why="the drive's strength swings with the supply at a frequency of its own",
    ),
    Law(
        name="winding_drum", kind="joint", apply=fields(r="drum"), largest=1.5, judge=True,
        acts=_driven,
        figures=lambda s, x: {"r": 0.5 * s * x.side / (x.of("spread") + 0.1)},
        why="a cable that winds on itself: the transmission ratio changes with the turns",
    ),
    Law(
        name="coupled_detent", kind="joint", apply=fields(a="detent", n="detent_n"), judge=True,
        acts=lambda m, i: i + 1 < m.plant.count and _hinge(m, i) and _hinge(m, i + 1),
        figures=lambda s, x: {"a": s * x.of("effort"), "n": float(3 + int(6 * x.chance[0]))},
        why="magnets of two neighbouring joints pull at each other",
    ),
    Law(
        name="friction_with_memory", kind="joint", judge=True, largest=0.6,
        apply=fields(c="coulomb", m="memory", T="memory_time"),
        figures=lambda s, x: {"c": s * x.of("effort"), "m": 0.9, "T": 0.5 + 1.5 * x.chance[0]},
        why="dry friction that grows while the joint keeps its direction",
    ),
    Law(
        name="spinning_rotor", kind="body", judge=True, largest=3.0,
        acts=lambda m, i: i >= 2 and m.plant.count > 2,
        apply=lambda plant, i, f: plant.with_body(i, spin=f["h"]),
        figures=lambda s, x: {"h": s * x.of("effort") / x.of("speed")},
        why="a flywheel turns inside the link",
    ),
    Law(
        name="clock_drift", kind="world", judge=True, apply=_clock, largest=1.0,
        figures=lambda s, x: {"drift": 0.1 * s * x.side},
        why="the logger's clock runs too fast or too slowly",
    ),
)  # fmt: skip
"""Half of them are flagged `judge`: only that suite has them."""
