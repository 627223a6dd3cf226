"""Robots on legs, each with something that its description lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.unseen_rigs.plant import Foot, Plant, Push
from experiments.unseen_rigs.rig import Rig, inertial, joint, motors, written
from morph.arrays import Array

FLOOR = '<geom name="floor" type="plane" size="0 0 1"/>'
BALL = 0.02
"""Radius of feet, m."""


def _legs(
    folder: Path, name: str, trunk: str, hips: Mapping[str, tuple[float, float]], axis: str
) -> tuple[Path, list[Foot], list[str]]:
    """Return a robot on legs of two links of 0.15 m whose feet are balls, below a trunk."""
    body, feet, joints = "", [], []
    for leg, (x, y) in hips.items():
        hip, knee = f"{leg}_hip", f"{leg}_knee"
        joints += [hip, knee]
        feet.append(Foot(joint=knee, place=(0.0, 0.0, -0.15), radius=BALL))
        shin = (
            f'<body name="{leg}_shin" pos="0 0 -0.15">{joint(knee)}'
            f"{inertial(0.12, (0.02, 0.02, 0.15), '0 0 -0.075')}"
            f'<geom name="{leg}_foot" size="{BALL}" pos="0 0 -0.15" friction="0.8"/></body>'
        )
        body += (
            f'<body name="{leg}_thigh" pos="{x} {y} 0">{joint(hip, axis)}'
            f"{inertial(0.3, (0.04, 0.04, 0.15), '0 0 -0.075')}{shin}</body>"
        )
    base = f'<freejoint name="base"/>{trunk}<site name="imu"/>'
    world = f'{FLOOR}<body name="trunk">{base}{body}</body>'
    path = written(folder, name, world, f"<actuator>{motors(joints)}</actuator>")
    return path, feet, joints


def quadruped(folder: Path) -> Rig:
    """Return a quadruped that trots; the foot that wears slides at a third of the friction."""
    hips = {"fl": (0.15, 0.1), "fr": (0.15, -0.1), "hl": (-0.15, 0.1), "hr": (-0.15, -0.1)}
    trunk = inertial(3.0, (0.35, 0.18, 0.08))
    path, feet, _ = _legs(folder, "quadruped", trunk, hips, "0 1 0")
    worn = [replace(feet[0], mu=0.25), *feet[1:]]

    def led(phases: Array, t: float) -> Mapping[str, float]:
        at = dict[str, float]()
        for leg in hips:
            turn = 2.0 * np.pi * 1.7 * t + phases[0] + np.pi * (leg in ("fr", "hl"))
            grown = min(1.0, t)
            at[f"{leg}_hip"] = 0.5 + 0.15 * grown * np.sin(turn)
            at[f"{leg}_knee"] = -1.0 - 0.35 * grown * max(0.0, np.cos(turn))
        return at

    described = Plant(description=path, feet=feet)
    return Rig(
        described=described,
        lacking=replace(described, feet=worn),
        names=("contact_friction@fl_shin+floor", "contact_friction@any+floor"),
        led=led,
        gains=(40.0, 1.0),
        start={f"{leg}_{j}": at for leg in hips for j, at in (("hip", 0.5), ("knee", -1.0))},
        base="trunk",
        height=0.15 * (np.cos(0.5) * 2) + BALL,
    )


def biped(folder: Path) -> Rig:
    """Return a biped that squats and sways on flat feet, with a load on its trunk."""
    body, feet, joints = "", [], []
    corners = [(x, y, -0.05) for x in (-0.06, 0.1) for y in (-0.04, 0.04)]
    balls = "".join(
        f'<geom size="{BALL / 2}" pos="{x} {y} {z}" friction="0.8"/>' for x, y, z in corners
    )
    for side, y in (("left", 0.1), ("right", -0.1)):
        names = [f"{side}_{each}" for each in ("hip", "knee", "ankle")]
        joints += names
        feet += [Foot(joint=names[2], place=each, radius=BALL / 2) for each in corners]
        sole = (
            f'<body name="{side}_sole" pos="0 0 -0.2">{joint(names[2])}'
            f"{inertial(0.2, (0.16, 0.08, 0.02), '0.02 0 -0.04')}{balls}</body>"
        )
        shin = (
            f'<body name="{side}_shin" pos="0 0 -0.2">{joint(names[1])}'
            f"{inertial(0.5, (0.05, 0.05, 0.2), '0 0 -0.1')}{sole}</body>"
        )
        body += (
            f'<body name="{side}_thigh" pos="0 {y} 0">{joint(names[0])}'
            f"{inertial(0.8, (0.06, 0.06, 0.2), '0 0 -0.1')}{shin}</body>"
        )
    trunk = inertial(4.0, (0.15, 0.25, 0.2), "0 0 0.1")
    world = f'{FLOOR}<body name="trunk"><freejoint name="base"/>{trunk}{body}</body>'
    path = written(folder, "biped", world, f"<actuator>{motors(joints)}</actuator>")

    def led(phases: Array, t: float) -> Mapping[str, float]:
        grown, at = min(1.0, t), dict[str, float]()
        bend = 0.4 + 0.2 * grown * np.sin(2.0 * np.pi * 0.6 * t + phases[0])
        bend += 0.08 * grown * np.sin(2.0 * np.pi * 1.9 * t + phases[1])
        sway = 0.06 * grown * np.sin(2.0 * np.pi * 0.9 * t + phases[2])
        for side in ("left", "right"):
            at |= {
                f"{side}_hip": -bend + sway,
                f"{side}_knee": 2.0 * bend,
                f"{side}_ankle": -bend,
            }
        return at

    described = Plant(description=path, feet=feet)
    start = {"hip": -0.4, "knee": 0.8, "ankle": -0.4}
    return Rig(
        described=described,
        lacking=replace(described, carried=("base", 1.0, (0.03, 0.0, 0.2))),
        names=("payload@trunk", "link_inertia@trunk"),
        led=led,
        gains=(80.0, 1.0),
        start={f"{side}_{j}": at for side in ("left", "right") for j, at in start.items()},
        base="trunk",
        height=0.4 * np.cos(0.4) + 0.05 + BALL / 2,
    )


def hexapod(folder: Path) -> Rig:
    """Return a robot on six legs that steps by threes and is pushed once."""
    hips = {
        f"{side}{at}": (0.16 * (1 - at), 0.12 * sign)
        for side, sign in (("l", 1), ("r", -1))
        for at in range(3)
    }
    trunk = inertial(2.5, (0.4, 0.2, 0.06))
    path, feet, _ = _legs(folder, "hexapod", trunk, hips, "1 0 0")
    three = ("l0", "l2", "r1")

    def led(phases: Array, t: float) -> Mapping[str, float]:
        at, grown = dict[str, float](), min(1.0, t)
        for leg in hips:
            turn = 2.0 * np.pi * 1.1 * t + phases[0] + np.pi * (leg in three)
            at[f"{leg}_hip"] = 0.1 * grown * np.sin(turn + phases[1])
            at[f"{leg}_knee"] = -0.25 * grown * max(0.0, np.cos(turn))
        return at

    described = Plant(description=path, feet=feet)
    return Rig(
        described=described,
        lacking=replace(described, push=Push(start=3.0, end=3.15, force=(0.0, 25.0, 0.0))),
        names=("external_push@trunk",),
        led=led,
        gains=(40.0, 1.0),
        base="trunk",
        height=0.3 + BALL,
        once=True,
    )
