"""Robots without feet, each with something that its description lacks; and all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.unseen_rigs.legged import biped, hexapod, quadruped
from experiments.unseen_rigs.plant import Plant
from experiments.unseen_rigs.rig import Rig, inertial, joint, motors, written
from morph.arrays import Array

WATER = '<option gravity="0 0 0" density="1000" viscosity="0"/>'


def swimmer(folder: Path) -> Rig:
    """Return a hull with four paddles in water; growth on one pair adds drag."""
    body, joints = "", []
    for name, x, y in (("fl", 0.15, 0.12), ("fr", 0.15, -0.12), ("hl", -0.15, 0.12),
                       ("hr", -0.15, -0.12)):  # fmt: skip
        joints.append(name)
        body += (
            f'<body name="{name}_paddle" pos="{x} {y} 0">{joint(name)}'
            f"{inertial(0.15, (0.15, 0.06, 0.01), '-0.08 0 0')}</body>"
        )
    trunk = inertial(4.0, (0.4, 0.2, 0.12))
    path = written(
        folder,
        "swimmer",
        f'<body name="hull"><freejoint name="base"/>{trunk}{body}</body>',
        f"<actuator>{motors(joints)}</actuator>",
        option=WATER,
    )

    def led(phases: Array, t: float) -> Mapping[str, float]:
        grown = min(1.0, t)
        return {
            name: 0.6 * grown * np.sin(2.0 * np.pi * (0.7 + 0.25 * at) * t + phases[at])
            for at, name in enumerate(joints)
        }

    described = Plant(description=path, wet=True)
    return Rig(
        described=described,
        lacking=replace(
            described, drag={"fl": (np.array([-0.1, 0.0, 0.0]), np.array([0.0, 0.0, 8.0]))}
        ),
        names=("quadratic_drag@fl_paddle",),
        led=led,
        gains=(3.0, 0.1),
        base="hull",
    )


def fourbar(folder: Path) -> Rig:
    """Return a leg of four bars whose crank has play between its motor and itself."""
    rotor, light = 0.002, 1e-4
    crank = (
        f'<body name="crank">{joint("crank", armature=rotor)}'
        f"{inertial(0.2, (0.1, 0.02, 0.02), '0.05 0 0')}"
        f'<body name="coupler" pos="0.1 0 0">{joint("coupler", armature=light)}'
        f"{inertial(0.2, (0.02, 0.02, 0.02), '0.075 0 0.075')}</body></body>"
    )
    leg = (
        f'<body name="leg" pos="0.25 0 0">{joint("leg", armature=light)}'
        f"{inertial(0.6, (0.03, 0.03, 0.4), '0 0 -0.1')}</body>"
    )
    # The coupler ends where the leg does, 0.15 m above its hinge.
    ends = np.array([0.15, 0.0, 0.15]), np.array([0.0, 0.0, 0.15])
    loop = '<equality><connect body1="coupler" body2="leg" anchor="0.15 0 0.15"/></equality>'
    drive = f"<actuator>{motors(['crank'])}</actuator>"
    # Pinocchio reads one tree.
    frame = f'<body name="frame">{crank}{leg}</body>'
    described = Plant(
        description=written(folder, "fourbar", frame, drive + loop),
        loop=("coupler", ends[0], "leg", ends[1]),
    )

    def led(phases: Array, t: float) -> Mapping[str, float]:
        grown = min(1.0, t)
        quick = 0.1 * np.sin(2.0 * np.pi * 2.1 * t + phases[1])
        return {"crank": grown * (0.5 * np.sin(2.0 * np.pi * 0.6 * t + phases[0]) + quick)}

    return Rig(
        described=described,
        lacking=replace(described, gap=("crank", 0.03, rotor)),
        names=("backlash@crank",),
        led=led,
        gains=(20.0, 0.6),
    )


def arm(folder: Path) -> Rig:
    """Return an arm of seven joints, of which torques are logged, with a tool at its hand."""
    body, masses = "", (3.0, 2.5, 2.0, 1.6, 1.2, 0.8, 0.5)
    joints = [f"a{at}" for at in range(7)]
    for at in reversed(range(7)):
        axis = ("0 0 1", "0 1 0")[at % 2]
        inertia = inertial(masses[at], (0.08, 0.08, 0.15), "0 0.01 0.07")
        place = "0 0 0.15" if at else "0 0 0"
        # As reflected by gears of a hundred to one.
        turns = joint(joints[at], axis, armature=0.15 * masses[at], damping=0.6 * masses[at])
        body = f'<body name="link{at}" pos="{place}">{turns}{inertia}{body}</body>'
    path = written(folder, "arm", body, f"<actuator>{motors(joints)}</actuator>")

    def led(phases: Array, t: float) -> Mapping[str, float]:
        grown = min(1.0, t)
        return {
            name: grown * 0.6 * np.sin(2.0 * np.pi * (0.25 + 0.11 * at) * t + phases[at])
            for at, name in enumerate(joints)
        }

    damping = {name: 0.6 * mass for name, mass in zip(joints, masses, strict=True)}
    described = Plant(description=path, damping=damping)
    return Rig(
        described=described,
        lacking=replace(described, carried=("a6", 0.8, (0.0, 0.03, 0.12))),
        names=("payload@link6", "link_inertia@link6"),
        led=led,
        gains=(120.0, 8.0),
        by_effort=True,
    )


def vehicle(folder: Path) -> Rig:
    """Return a vehicle in water with six thrusters, of which one gives two thirds."""
    places = {
        "surge_left": ((1.0, 0.0, 0.0), (-0.2, 0.15, 0.0)),
        "surge_right": ((1.0, 0.0, 0.0), (-0.2, -0.15, 0.0)),
        "sway_front": ((0.0, 1.0, 0.0), (0.2, 0.0, 0.0)),
        "sway_rear": ((0.0, 1.0, 0.0), (-0.2, 0.0, 0.05)),
        "heave_left": ((0.0, 0.0, 1.0), (0.0, 0.15, 0.0)),
        "heave_front": ((0.0, 0.0, 1.0), (0.2, -0.1, 0.0)),
    }
    sites, drives = "", ""
    for name, (force, place) in places.items():
        at, along = (" ".join(map(str, each)) for each in (place, force))
        sites += f'<site name="{name}" pos="{at}"/>'
        drives += f'<general name="{name}" site="{name}" gear="{along} 0 0 0" gainprm="20"/>'
    hull = inertial(15.0, (0.45, 0.3, 0.25))
    path = written(
        folder,
        "vehicle",
        f'<body name="hull"><freejoint name="base"/>{hull}{sites}</body>',
        f"<actuator>{drives}</actuator>",
        option=WATER,
    )

    def led(phases: Array, t: float) -> Mapping[str, float]:
        grown = min(1.0, t)
        return {
            name: grown * 0.7 * np.sin(2.0 * np.pi * (0.1 + 0.07 * at) * t + phases[at])
            for at, name in enumerate(places)
        }

    thrusters = {
        name: (20.0 * np.array(force), np.array(place), "base")
        for name, (force, place) in places.items()
    }
    described = Plant(description=path, wet=True, motors=thrusters)
    return Rig(
        described=described,
        lacking=replace(described, weak={"heave_front": 0.65}),
        names=("torque_scale@heave_front",),
        led=led,
        gains=(0.0, 0.0),
        base="hull",
    )


RIGS: Mapping[str, Callable[[Path], Rig]] = {
    each.__name__: each for each in (quadruped, biped, swimmer, fourbar, arm, vehicle, hexapod)
}
