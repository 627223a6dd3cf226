"""Small files that ask for far more memory or time than they have bytes, one maker for each trick.

Sources: the "billion laughs" of W3C XML 1.0 entities; the formats' own specifications for sizes in
headers.
"""

from __future__ import annotations

import io
import json
import struct
import zlib
from pathlib import Path

import numpy as np

from experiments.bomb_pieces import MIB, Bomb, archive, deflated, npy
from experiments.bomb_recordings import RECORDINGS


def png(path: Path) -> None:
    """Write a picture of 2 x 2 points whose data unpack to 500 MB."""
    check = 1
    for _ in range(500):
        check = zlib.adler32(bytes(MIB), check)
    data = b"\x78\x9c" + deflated(bytes(MIB), 500) + struct.pack(">I", check)
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)),
        (b"IDAT", data),
        (b"IEND", b""),
    )
    content = b"\x89PNG\r\n\x1a\n"
    for kind, inner in parts:
        content += struct.pack(">I", len(inner)) + kind + inner
        content += struct.pack(">I", zlib.crc32(kind + inner))
    path.write_bytes(content)


def textured(path: Path) -> None:
    """A body with such a picture on it."""
    png(path.with_suffix(".png"))
    path.write_text(
        f'<mujoco><asset><texture name="t" type="2d" file="{path.stem}.png"/><material name="m" '
        'texture="t"/></asset><worldbody><body name="b"><joint name="j"/><geom size="1" mass="1" '
        'material="m"/></body></worldbody></mujoco>'
    )


def laughs(path: Path) -> None:
    """Entities that each stand for ten of the one before."""
    entities = "".join(f'<!ENTITY e{at + 1} "{f"&e{at};" * 10}">' for at in range(9))
    path.write_text(
        f'<!DOCTYPE robot [<!ENTITY e0 "ha">{entities}]><robot name="&e9;"><link name="a"/></robot>'
    )


def model_3mf(path: Path) -> None:
    """A model that unpacks to 60 MB."""
    rels = '<Relationships><Relationship Target="/m" Type="x/3dmodel"/></Relationships>'
    vertex = b'<vertex x="0" y="0" z="0"/>' * (60 * MIB // 27)
    model = b"<model><resources><object id='1'><mesh><vertices>" + vertex
    archive(path, {"_rels/.rels": rels.encode(), "m": model})


def safetensors(path: Path) -> None:
    """A header of a tensor of 8 TB."""
    said = {"w": {"dtype": "F64", "shape": [10**6, 10**6], "data_offsets": [0, 8 * 10**12]}}
    head = json.dumps(said).encode()
    path.write_bytes(struct.pack("<Q", len(head)) + head)


def state_npz(path: Path) -> None:
    """The state of a search with 2 GB of zeros."""
    text = io.BytesIO()
    np.save(text, np.array("{}"))
    archive(path, {"state.a.npy": npy(f"({8 * MIB},)", bytes(64 * MIB))}, times=32)


PLY = (
    "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2147483647\nproperty list uchar int vertex_indices\n"
    "end_header\n"
)

BOMBS = (
    *RECORDINGS,
    Bomb(
        name="dots.toml",
        reader="binding",
        make=lambda p: p.write_text("a." * 100_000 + "a = 1\n"),
    ),
    Bomb(name="deep.toml", reader="binding", make=lambda p: p.write_text("x = " + "[" * 200_000)),
    Bomb(
        name="dots/card.toml",
        reader="card",
        make=lambda p: p.write_text(("a." * 450 + "a = 1\n") * 280),
    ),
    Bomb(
        name="effects.toml",
        reader="effects",
        make=lambda p: p.write_text(("a." * 450 + "a = 1\n") * 4000),
    ),
    Bomb(name="deep.json", reader="view", make=lambda p: p.write_text("[" * 900_000)),
    Bomb(name="package.json", reader="package", make=lambda p: p.write_text("[" + "{}," * 2**21)),
    Bomb(name="laughs.urdf", reader="robot", make=laughs),
    Bomb(name="deep.urdf", reader="robot", make=lambda p: p.write_text("<robot>" * 500_000)),
    Bomb(
        name="many.urdf",
        reader="robot",
        make=lambda p: p.write_text('<robot name="a">' + "<a/>" * 900_000 + "</robot>"),
    ),
    Bomb(name="texture.xml", reader="robot", make=textured, read=True),
    Bomb(
        name="faces.stl",
        reader="mesh",
        make=lambda p: p.write_bytes(bytes(80) + struct.pack("<I", 2**31) + bytes(50)),
    ),
    Bomb(name="faces.ply", reader="mesh", make=lambda p: p.write_bytes(PLY.encode() + bytes(64))),
    Bomb(
        name="corners.obj",
        reader="mesh",
        make=lambda p: p.write_bytes(b"v 0 0 0\n" * 8 + b"f" + b" 1" * (15 * MIB) + b"\n"),
    ),
    Bomb(name="model.3mf", reader="mesh", make=model_3mf),
    Bomb(name="state.npz", reader="search", make=state_npz),
    Bomb(name="pairs.npz", reader="pairs", make=state_npz),
    Bomb(name="map.npz", reader="map", make=state_npz),
    Bomb(name="weights.safetensors", reader="weights", make=safetensors),
)
"""All tricks."""
