"""Candidates of a diagnosis compile from a description of whatever files, and move as it does."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import trimesh

from morph.body.load import load
from morph.body.spec import spec_of
from morph.model.hypothesis import bare_spec

ARM = """<mujoco model="arm"><asset><mesh name="touched" file="touched.stl"/>
<mesh name="shown" file="shown.stl"/><texture name="skin" type="2d" file="skin.png"/>
<material name="red" texture="skin"/></asset><worldbody><body><joint axis="0 1 0"/>
<geom type="mesh" mesh="touched" material="red"/><geom type="mesh" mesh="shown" contype="0"
conaffinity="0"/><body pos="0.5 0 0"><joint axis="0 1 0"/><geom size="0.1" material="red"/>
</body></body></worldbody></mujoco>"""


def png() -> bytes:
    """A red picture of 4 by 4 points."""

    def part(kind: bytes, content: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(kind + content))
        return struct.pack(">I", len(content)) + kind + content + check

    size = struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)
    rows = zlib.compress(b"".join(b"\0" + bytes([200, 10, 10] * 4) for _ in range(4)))
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", size) + part(b"IDAT", rows) + part(b"IEND", b"")


def test_what_is_only_shown_is_left_out_and_nothing_moves_otherwise(tmp_path: Path) -> None:
    for name, radius in (("touched", 0.1), ("shown", 0.2)):
        ball = trimesh.creation.icosphere(subdivisions=1, radius=radius)
        (tmp_path / f"{name}.stl").write_bytes(bytes(ball.export(file_type="stl")))
    (tmp_path / "skin.png").write_bytes(png())
    (tmp_path / "arm.xml").write_text(ARM)
    robot = load(tmp_path / "arm.xml")
    whole: Any = spec_of(robot, timestep=0.002).compile()
    bare: Any = bare_spec(robot, 0.002).copy().compile()
    assert (whole.nmesh, bare.nmesh) == (2, 1)
    runs = []
    for model in (whole, bare):
        data = mujoco.MjData(model)
        data.qvel[:] = (0.5, -1.0)
        mujoco.mj_step(model, data, nstep=500)
        runs.append(data.qpos.copy())
    # Text at 17 digits gives the same doubles.
    np.testing.assert_array_equal(*runs)
