"""A biped of our own to plant defects in."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import pytest
import trimesh

from experiments.plant.description import Description

SHAPES = {
    "torso": ((0.20, 0.12, 0.30), 5.0),
    "thigh": ((0.05, 0.04, 0.30), 0.8),
    "shin": ((0.04, 0.05, 0.30), 0.6),
    "foot": ((0.20, 0.05, 0.03), 0.2),
}
"""Box in m and mass in kg of each part."""


def _link(name: str, part: str, *, collision: bool) -> str:
    (a, b, c), mass = SHAPES[part]
    # A box of sides a, b, c: m (b^2 + c^2) / 12 about the first axis, and so on round.
    moments = [mass * (p * p + q * q) / 12 for p, q in ((b, c), (a, c), (a, b))]
    mesh = f'<geometry><mesh filename="package://biped/meshes/{part}.stl"/></geometry>'
    touch = f'<collision><origin xyz="0 0 0"/>{mesh}</collision>' if collision else ""
    return f"""<link name="{name}">
      <inertial><origin xyz="0 0.01 0"/><mass value="{mass}"/>
        <inertia ixx="{moments[0]:.9g}" ixy="0" ixz="0" iyy="{moments[1]:.9g}" iyz="0"
                 izz="{moments[2]:.9g}"/></inertial>
      <visual><origin xyz="0 0 0"/>{mesh}</visual>{touch}</link>"""


def _joint(name: str, parent: str, child: str, xyz: str) -> str:
    return f"""<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
      <origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="0 1 0"/>
      <limit lower="-0.5" upper="1.2" effort="9" velocity="9"/></joint>"""


@pytest.fixture
def biped(tmp_path: Path) -> Description:
    """Return a torso on two legs of three links, hips 0.08 m to the left and right."""
    root = tmp_path / "own" / "biped"
    (root / "meshes").mkdir(parents=True)
    for part, (box, _) in SHAPES.items():
        trimesh.creation.box(box).export(root / "meshes" / f"{part}.stl")
    parts = [_link("torso", "torso", collision=True)]
    for side, y in (("left", "0.08"), ("right", "-0.08")):
        parts += [
            _link(f"{side}_thigh", "thigh", collision=True),
            _link(f"{side}_shin", "shin", collision=False),
            _link(f"{side}_foot", "foot", collision=True),
            _joint(f"{side}_hip", "torso", f"{side}_thigh", f"0 {y} -0.15"),
            _joint(f"{side}_knee", f"{side}_thigh", f"{side}_shin", "0 0 -0.3"),
            _joint(f"{side}_ankle", f"{side}_shin", f"{side}_foot", "0 0 -0.3"),
        ]
    (root / "biped.urdf").write_text(f'<robot name="biped"><!-- ours -->{"".join(parts)}</robot>')
    return Description(name="biped", root=root, urdf=PurePosixPath("biped.urdf"))
