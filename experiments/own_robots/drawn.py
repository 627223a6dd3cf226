"""Robots drawn at random: trees of links with any names, axes, sizes, weights and actuators."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from morph.files import write_whole

SIZES, DENSITIES = (0.01, 10.0), (150.0, 3000.0)
"""Size of a robot, m, and the density of its links, kg/m3."""
MASSES = (0.01, 1000.0)
"""The least and the greatest mass of a robot, kg."""
LETTERS = "abcdefghijklmnopqrstuvwxyz_0123456789éßж腕"
"""Of which names are drawn."""
ACTUATORS = ("motor", "position", "velocity", "general", "intvelocity", "damper")
"""Kinds of actuators of joints."""


def drawn(folder: Path, seed: int) -> Path:
    """Write the MJCF of a robot that is drawn by a random seed; return its file."""
    rng = np.random.default_rng([seed, 23])
    size = float(np.exp(rng.uniform(*np.log(SIZES))))
    density = float(np.exp(rng.uniform(*np.log(DENSITIES))))
    links = int(rng.integers(2, 9))
    parents = [0, *(int(rng.integers(0, at)) for at in range(1, links))]
    length = size / (1 + links / 2)
    mass = float(np.clip(density * 0.03 * length**3 * links, *MASSES)) / links
    bodies, joints = [], []
    for at in range(links):
        name, joint = _name(rng), _name(rng)
        reach = length * rng.uniform(0.5, 1.0)
        tip, place = reach * _direction(rng), (length * _direction(rng) if at else np.zeros(3))
        thick = 0.1 * reach
        shape = f'<geom type="capsule" fromto="0 0 0 {_text(tip)}" size="{thick:.6g}"'
        shape += f' mass="{mass:.6g}"/>'
        held = ""
        if at:
            kind = "slide" if rng.random() < 0.15 else "hinge"
            low, high = (-0.5 * length, 0.5 * length) if kind == "slide" else (-1.5, 1.5)
            ends = f'limited="true" range="{low:.6g} {high:.6g}"' if rng.random() < 0.7 else ""
            held = f'<joint name="{joint}" type="{kind}" axis="{_text(_direction(rng))}" {ends}/>'
            joints.append((joint, kind))
        elif rng.random() < 0.5:
            held = "<freejoint/>"
            place = np.array([0.0, 0.0, 2.0 * size])
        bodies.append((f'<body name="{name}" pos="{_text(place)}">{held}{shape}', "</body>"))
    moment = mass * 9.81 * length
    actuators = "".join(
        _actuator(rng, joint, kind, moment, length) for joint, kind in joints if rng.random() < 0.8
    )
    text = (
        f'<mujoco model="{_name(rng)}"><compiler angle="radian" autolimits="true"/><option '
        f'timestep="0.001"/><worldbody>{_tree(bodies, parents, 0)}</worldbody><actuator>{actuators}'
        "</actuator></mujoco>"
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"drawn_{seed}.xml"
    write_whole(path, text)
    return path


def _tree(bodies: list[tuple[str, str]], parents: list[int], at: int) -> str:
    below = "".join(
        _tree(bodies, parents, child) for child in range(1, len(bodies)) if parents[child] == at
    )
    opened, closed = bodies[at]
    return opened + below + closed


def _actuator(rng: np.random.Generator, joint: str, kind: str, moment: float, length: float) -> str:
    """Return an actuator that can lift some links of this moment, N m."""
    most = moment * math.exp(rng.uniform(0.0, 2.0)) * (1.0 if kind == "hinge" else 1.0 / length)
    gear = float(np.exp(rng.uniform(-2.0, 3.0))) * rng.choice([-1.0, 1.0])
    what = str(rng.choice(ACTUATORS))
    common = f'name="{_name(rng)}" joint="{joint}" gear="{gear:.6g}"'
    force = most / abs(gear)
    if what == "motor":
        return f'<motor {common} ctrlrange="{-force:.6g} {force:.6g}"/>'
    if what == "damper":
        return f'<damper {common} kv="{force:.6g}" ctrlrange="0 1"/>'
    limits = f'forcerange="{-force:.6g} {force:.6g}"'
    if what in ("velocity", "intvelocity"):
        more = f'kv="{force:.6g}"' if what == "velocity" else 'kp="{:.6g}" actrange="{:.6g} {:.6g}"'
        more = more.format(2.0 * force, -abs(gear), abs(gear)) if what == "intvelocity" else more
        return f'<{what} {common} {more} ctrlrange="-2 2" {limits}/>'
    if what == "position":
        return f'<position {common} kp="{3.0 * force / abs(gear):.6g}" {limits}/>'
    gain = float(np.exp(rng.uniform(-1.0, 1.0)))
    return (
        f'<general {common} gainprm="{force * gain:.6g}" biastype="affine" biasprm="0 0 '
        f'{-0.1 * force:.6g}" ctrlrange="{-1.0 / gain:.6g} {1.0 / gain:.6g}"/>'
    )


def _name(rng: np.random.Generator) -> str:
    return "x" + "".join(rng.choice(list(LETTERS), int(rng.integers(5, 12))))


def _direction(rng: np.random.Generator) -> np.ndarray:
    vector = rng.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def _text(vector: np.ndarray) -> str:
    return " ".join(f"{value:.6g}" for value in vector)
