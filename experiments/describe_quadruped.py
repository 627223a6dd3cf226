"""Writes `robots/quadruped_printed/robot.xml` from its meshes.

`python -m experiments.describe_quadruped`, after `python -m experiments.draw_parts`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from experiments.draw_parts import FOLDER, FOOT, HIP, HORN, KNEE, PLATE, SEAT, SERVO, SHIN
from morph.arrays import Array
from morph.body.mesh import read_mesh
from morph.files import write_whole

PLA = 1240.0
"""Density of solid PLA, kg/m3: parts of 3 to 5 mm are walls throughout, so infill is 100 %."""

SERVO_MASS, SERVO_CASE = 0.009, (SERVO.length, SERVO.width, 22.5)
"""Of a servo with its horn, kg and mm."""
CELLS_MASS, CELLS = 0.048, (50.0, 24.0, 22.0)
"""Of four AAA cells in a holder of two by two, kg and mm."""
BOARD_MASS, BOARD_SIZE, BOARD_GAP = 0.025, (65.0, 30.0, 15.0), 5.0
"""Of the board with its servo driver, kg and mm, and its height above the plate."""

LEGS = {"front_left": 45.0, "rear_left": 135.0, "rear_right": 225.0, "front_right": 315.0}
"""Which way each leg points, degrees from forward."""

SWING, LIFT = (-0.7, 0.7), (-0.5, 1.3)
"""Ranges of hips and knees, rad."""


@dataclass
class Weighed:
    """Masses gathered in one frame, metres and kilograms."""

    parts: list[tuple[float, Array, Array]] = field(default_factory=list)

    def mesh(self, name: str) -> None:
        """Add a printed part."""
        mesh = read_mesh((FOLDER / f"{name}.stl").read_bytes(), "stl", name).scaled(0.001)
        mass = round(mesh.volume * PLA, 9)
        self.parts.append((mass, mesh.com, mesh.inertia * mass / mesh.volume))

    def box(self, mass: float, size_mm: Array, middle_mm: Array, turn_deg: float = 0.0) -> None:
        """Add a uniform box, turned about z: m (a^2 + b^2) / 12."""
        a, b, c = np.square(np.array(size_mm) / 1000)
        angle = math.radians(turn_deg)
        sin, cos = math.sin(angle), math.cos(angle)
        turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        inertia = turn @ np.diag((b + c, a + c, a + b)) @ turn.T * mass / 12
        self.parts.append((mass, np.array(middle_mm) / 1000, inertia))

    def inertial(self) -> str:
        """Return the MJCF element of the whole, by the parallel axis theorem."""
        mass = sum(part[0] for part in self.parts)
        com: Array = np.sum([each * at for each, at, _ in self.parts], axis=0) / mass
        inertia = np.zeros((3, 3))
        for each, at, own in self.parts:
            away = at - com
            inertia += own + each * (away @ away * np.eye(3) - np.outer(away, away))
        rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
        full = _text(*inertia[rows, columns])
        return f'<inertial pos="{_text(*com)}" mass="{mass:.9f}"\n{{0}}  fullinertia="{full}"/>'


def description() -> str:
    """Return the whole description as MJCF text."""
    legs = "\n".join(_leg(name, angle) for name, angle in LEGS.items())
    stand = HORN + KNEE[2] - SHIN - FOOT
    servos = "\n".join(
        f'  <position name="{name}_{joint}" joint="{name}_{joint}" class="{joint}"/>'
        for name in LEGS
        for joint in ("hip", "knee")
    )
    text = HEAD + f'\n<body name="body" pos="0 0 {_text(-stand / 1000)}">\n'
    text += _indented(_body(), 2) + "\n\n" + _indented(legs, 2) + "\n</body>\n"
    whole = _indented(text.partition("<worldbody>\n")[2], 4)
    return text.partition("<worldbody>\n")[0] + "<worldbody>\n" + whole + FOOTER.format(servos)


def _body() -> str:
    weighed = Weighed()
    weighed.mesh("body")
    geoms = ['<geom name="plate" type="mesh" mesh="body" material="print"/>']
    reach = math.hypot(HIP, HIP) - SERVO.offset
    height = PLATE / 2 - SERVO.base + SERVO_CASE[2] / 2
    for name, angle in LEGS.items():
        way = math.radians(angle)
        at = np.array((reach * math.cos(way), reach * math.sin(way), height))
        weighed.box(SERVO_MASS, np.array(SERVO_CASE), at, angle)
        geoms.append(_box(f"{name}_hip_servo", SERVO_CASE, at, "servo", angle))
    for name, mass, size, level in (
        ("cells", CELLS_MASS, CELLS, -PLATE / 2 - CELLS[2] / 2),
        ("board", BOARD_MASS, BOARD_SIZE, PLATE / 2 + BOARD_GAP + BOARD_SIZE[2] / 2),
    ):
        weighed.box(mass, np.array(size), np.array((0, 0, level)))
        geoms.append(_box(name, size, np.array((0, 0, level)), name))
    inertial = weighed.inertial().format("")
    return "\n".join([inertial, '<freejoint name="root"/>', *geoms])


def _leg(name: str, angle: float) -> str:
    upper, lower = Weighed(), Weighed()
    upper.mesh("upper_leg")
    # The knee's servo lies on its side: its height is along y, its length along x.
    size = (SERVO_CASE[0], SERVO_CASE[2], SERVO_CASE[1])
    middle = (KNEE[0] - SERVO.offset, SEAT - SERVO.base + SERVO_CASE[2] / 2, KNEE[2])
    upper.box(SERVO_MASS, np.array(size), np.array(middle))
    lower.mesh("lower_leg")
    way = math.radians(angle)
    side = -1 if name.endswith("left") else 1
    at = _text(*(sign * HIP / 1000 for sign in np.sign((math.cos(way), math.sin(way)))))
    turn = _text(math.cos(way / 2), 0, 0, math.sin(way / 2))
    return f"""<body name="{name}_upper_leg" pos="{at} {_text(HORN / 1000)}" quat="{turn}">
  {upper.inertial().format("  ")}
  <joint name="{name}_hip" class="hip" axis="0 0 {side}"/>
  <geom name="{name}_upper_leg" type="mesh" mesh="upper_leg" material="print"/>
  {_box(f"{name}_knee_servo", size, np.array(middle), "servo")}
  <body name="{name}_lower_leg" pos="{_text(*(np.array(KNEE) / 1000))}">
    {lower.inertial().format("    ")}
    <joint name="{name}_knee" class="knee"/>
    <geom name="{name}_lower_leg" type="mesh" mesh="lower_leg" material="accent"/>
  </body>
</body>
"""


def _box(
    name: str, size_mm: tuple[float, ...], at_mm: Array, material: str, turn_deg: float = 0.0
) -> str:
    half = _text(*(np.array(size_mm) / 2000))
    angle = math.radians(turn_deg) / 2
    turn = f' quat="{_text(math.cos(angle), 0, 0, math.sin(angle))}"' if turn_deg else ""
    place = _text(*(at_mm / 1000))
    return (
        f'<geom name="{name}" type="box" pos="{place}"{turn} size="{half}" material="{material}"/>'
    )


def _text(*numbers: float) -> str:
    return " ".join(f"{number + 0.0:.9g}" if abs(number) > 1e-15 else "0" for number in numbers)


def _indented(text: str, by: int) -> str:
    return "\n".join(" " * by + line if line.strip() else "" for line in text.split("\n"))


HEAD = f"""<mujoco model="quadruped_printed">
  <!-- A printed quadruped with eight micro servos: each leg swings about an upright hip and
       lifts about a level knee. x points forward, y to the left. At zero the legs point along
       the diagonals and the lower legs straight down. A positive hip swings the leg forward
       and a positive knee lifts the foot outward, so that one command for left and right
       gives two mirrored legs. All four legs are of the same two parts. Written by
       experiments/describe_quadruped.py from the meshes, which experiments/draw_parts.py
       draws, in millimetres. Shapes touch the ground, never each other. Every figure is
       accounted for in card.toml. -->
  <compiler angle="radian" inertiafromgeom="false" autolimits="true" meshdir="meshes"/>
  <option gravity="0 0 -9.81"/>

  <default>
    <geom contype="0" conaffinity="1" group="1"/>
    <joint armature="2e-5"/>
    <position kp="1.77" kv="0.0169" forcerange="-0.177 0.177"/>
    <default class="hip">
      <joint range="{SWING[0]} {SWING[1]}"/>
      <position ctrlrange="{SWING[0]} {SWING[1]}"/>
    </default>
    <default class="knee">
      <joint axis="0 -1 0" range="{LIFT[0]} {LIFT[1]}"/>
      <position ctrlrange="{LIFT[0]} {LIFT[1]}"/>
    </default>
  </default>

  <asset>
    <mesh name="body" file="body.stl" scale="0.001 0.001 0.001"/>
    <mesh name="upper_leg" file="upper_leg.stl" scale="0.001 0.001 0.001"/>
    <mesh name="lower_leg" file="lower_leg.stl" scale="0.001 0.001 0.001"/>
    <material name="print" rgba="0.93 0.91 0.86 1"/>
    <material name="accent" rgba="0.87 0.46 0.13 1"/>
    <material name="servo" rgba="0.16 0.30 0.46 1"/>
    <material name="cells" rgba="0.12 0.13 0.15 1"/>
    <material name="board" rgba="0.16 0.42 0.32 1"/>
  </asset>

  <worldbody>
"""

FOOTER = """  </worldbody>

  <actuator>
  {}
  </actuator>
</mujoco>
"""


def main() -> None:
    """Write the description."""
    path = write_whole(FOLDER.parent / "robot.xml", description())
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
