"""Seven robots, each with something that its description lacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from experiments.unseen_rigs.plant import Foot, Plant, Push
from morph.arrays import Array
from morph.files import write_whole

FLOOR = '<geom name="floor" type="plane" size="0 0 1"/>'
WATER = '<option gravity="0 0 0" density="1000" viscosity="0"/>'
BALL = 0.02
"""Radius of feet, m."""


@dataclass(frozen=True, kw_only=True)
class Rig:
    """A description, the plant that is as described, and what the other one has beside."""

    described: Plant
    """The plant without anything left out."""
    lacking: Plant
    """The plant with it."""
    names: tuple[str, ...]
    """Labels of the laws that are right."""
    led: Callable[[Array, float], Mapping[str, float]]
    """Where its joints are led, rad, by random phases and the time; of motors that turn no joint
    the command."""
    gains: tuple[float, float]
    """Of the controller that leads joints, N m/rad and N m s/rad."""
    start: Mapping[str, float] = field(default_factory=dict)
    """Where joints start, rad."""
    base: str = ""
    """The link that floats; empty of a robot that is bolted down."""
    height: float = 0.0
    """At which it starts, m."""
    by_effort: bool = False
    """Whether joints' torques are logged in the place of commands."""
    once: bool = False
    """Whether the second run alone has what is lacking, as a push."""


def _inertial(mass: float, size: Sequence[float], place: str = "0 0 0") -> str:
    """Return the inertia of a box of some edges, as MJCF."""
    x, y, z = (each**2 for each in size)
    moments = " ".join(f"{mass / 12 * each:.9g}" for each in (y + z, x + z, x + y))
    return f'<inertial pos="{place}" mass="{mass:g}" diaginertia="{moments}"/>'


def _joint(name: str, axis: str = "0 1 0", *, armature: float = 0.002, damping: float = 0.0) -> str:
    return f'<joint name="{name}" axis="{axis}" armature="{armature:g}" damping="{damping:g}"/>'


def _motors(names: Sequence[str]) -> str:
    return "".join(f'<motor name="{name}" joint="{name}"/>' for name in names)


def _written(folder: Path, name: str, world: str, rest: str, *, option: str = "") -> Path:
    text = f'<mujoco model="{name}">{option}<worldbody>{world}</worldbody>{rest}</mujoco>'
    return write_whole(folder / f"{name}.xml", text)


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
            f'<body name="{leg}_shin" pos="0 0 -0.15">{_joint(knee)}'
            f"{_inertial(0.12, (0.02, 0.02, 0.15), '0 0 -0.075')}"
            f'<geom name="{leg}_foot" size="{BALL}" pos="0 0 -0.15" friction="0.8"/></body>'
        )
        body += (
            f'<body name="{leg}_thigh" pos="{x} {y} 0">{_joint(hip, axis)}'
            f"{_inertial(0.3, (0.04, 0.04, 0.15), '0 0 -0.075')}{shin}</body>"
        )
    base = f'<freejoint name="base"/>{trunk}<site name="imu"/>'
    world = f'{FLOOR}<body name="trunk">{base}{body}</body>'
    path = _written(folder, name, world, f"<actuator>{_motors(joints)}</actuator>")
    return path, feet, joints


def quadruped(folder: Path) -> Rig:
    """Return a quadruped that trots; the foot that wears slides at a third of the friction."""
    hips = {"fl": (0.15, 0.1), "fr": (0.15, -0.1), "hl": (-0.15, 0.1), "hr": (-0.15, -0.1)}
    trunk = _inertial(3.0, (0.35, 0.18, 0.08))
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
            f'<body name="{side}_sole" pos="0 0 -0.2">{_joint(names[2])}'
            f"{_inertial(0.2, (0.16, 0.08, 0.02), '0.02 0 -0.04')}{balls}</body>"
        )
        shin = (
            f'<body name="{side}_shin" pos="0 0 -0.2">{_joint(names[1])}'
            f"{_inertial(0.5, (0.05, 0.05, 0.2), '0 0 -0.1')}{sole}</body>"
        )
        body += (
            f'<body name="{side}_thigh" pos="0 {y} 0">{_joint(names[0])}'
            f"{_inertial(0.8, (0.06, 0.06, 0.2), '0 0 -0.1')}{shin}</body>"
        )
    trunk = _inertial(4.0, (0.15, 0.25, 0.2), "0 0 0.1")
    world = f'{FLOOR}<body name="trunk"><freejoint name="base"/>{trunk}{body}</body>'
    path = _written(folder, "biped", world, f"<actuator>{_motors(joints)}</actuator>")

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


def swimmer(folder: Path) -> Rig:
    """Return a hull with four paddles in water; growth on one pair adds drag."""
    body, joints = "", []
    for name, x, y in (("fl", 0.15, 0.12), ("fr", 0.15, -0.12), ("hl", -0.15, 0.12),
                       ("hr", -0.15, -0.12)):  # fmt: skip
        joints.append(name)
        body += (
            f'<body name="{name}_paddle" pos="{x} {y} 0">{_joint(name)}'
            f"{_inertial(0.15, (0.15, 0.06, 0.01), '-0.08 0 0')}</body>"
        )
    trunk = _inertial(4.0, (0.4, 0.2, 0.12))
    path = _written(
        folder,
        "swimmer",
        f'<body name="hull"><freejoint name="base"/>{trunk}{body}</body>',
        f"<actuator>{_motors(joints)}</actuator>",
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
        f'<body name="crank">{_joint("crank", armature=rotor)}'
        f"{_inertial(0.2, (0.1, 0.02, 0.02), '0.05 0 0')}"
        f'<body name="coupler" pos="0.1 0 0">{_joint("coupler", armature=light)}'
        f"{_inertial(0.2, (0.02, 0.02, 0.02), '0.075 0 0.075')}</body></body>"
    )
    leg = (
        f'<body name="leg" pos="0.25 0 0">{_joint("leg", armature=light)}'
        f"{_inertial(0.6, (0.03, 0.03, 0.4), '0 0 -0.1')}</body>"
    )
    # The coupler ends where the leg does, 0.15 m above its hinge.
    ends = np.array([0.15, 0.0, 0.15]), np.array([0.0, 0.0, 0.15])
    loop = '<equality><connect body1="coupler" body2="leg" anchor="0.15 0 0.15"/></equality>'
    drive = f"<actuator>{_motors(['crank'])}</actuator>"
    # Pinocchio reads one tree.
    frame = f'<body name="frame">{crank}{leg}</body>'
    described = Plant(
        description=_written(folder, "fourbar", frame, drive + loop),
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
        inertia = _inertial(masses[at], (0.08, 0.08, 0.15), "0 0.01 0.07")
        place = "0 0 0.15" if at else "0 0 0"
        # As reflected by gears of a hundred to one.
        joint = _joint(joints[at], axis, armature=0.15 * masses[at], damping=0.6 * masses[at])
        body = f'<body name="link{at}" pos="{place}">{joint}{inertia}{body}</body>'
    path = _written(folder, "arm", body, f"<actuator>{_motors(joints)}</actuator>")

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
    hull = _inertial(15.0, (0.45, 0.3, 0.25))
    path = _written(
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

    motors = {
        name: (20.0 * np.array(force), np.array(place), "base")
        for name, (force, place) in places.items()
    }
    described = Plant(description=path, wet=True, motors=motors)
    return Rig(
        described=described,
        lacking=replace(described, weak={"heave_front": 0.65}),
        names=("torque_scale@heave_front",),
        led=led,
        gains=(0.0, 0.0),
        base="hull",
    )


def hexapod(folder: Path) -> Rig:
    """Return a robot on six legs that steps by threes and is pushed once."""
    hips = {
        f"{side}{at}": (0.16 * (1 - at), 0.12 * sign)
        for side, sign in (("l", 1), ("r", -1))
        for at in range(3)
    }
    trunk = _inertial(2.5, (0.4, 0.2, 0.06))
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


RIGS: Mapping[str, Callable[[Path], Rig]] = {
    each.__name__: each for each in (quadruped, biped, swimmer, fourbar, arm, vehicle, hexapod)
}
