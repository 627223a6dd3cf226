"""Small files that ask for far more memory or time than they have bytes, one maker for each trick.

Sources: D. Fifield, "A better zip bomb", USENIX WOOT 2019 (members that share their bytes); the
"billion laughs" of W3C XML 1.0 entities; the formats' own specifications for sizes in headers.
"""

from __future__ import annotations

import gzip
import io
import json
import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MIB = 2**20


@dataclass(frozen=True, kw_only=True)
class Bomb:
    """A trick."""

    name: str
    """The file's name; its ending says how it is read."""
    reader: str
    """Who reads it: a key of `READERS` of `experiments.bomb_readers`."""
    make: Callable[[Path], object]
    """Writes it."""
    read: bool = False
    """Whether it is read all the same, as what would cost is passed over."""


def npy(shape: str, data: bytes = b"", kind: str = "<f8") -> bytes:
    """Return an array in NumPy's format whose header says what one likes."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    head = text.ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


def archive(path: Path, members: dict[str, bytes], *, times: int = 1) -> None:
    """Write an archive; each member is listed so many times, its bytes stand there once."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in members.items():
            packed.writestr(name, data)
        packed.filelist *= times


def zeros_npz(path: Path) -> None:
    """3 GB of zeros: 48 members that share the bytes of one."""
    archive(path, {"a.npy": npy(f"({8 * MIB},)", bytes(64 * MIB))}, times=48)


def long_npz(path: Path) -> None:
    """An array of 8 TB in an archive of 200 bytes."""
    archive(path, {"a.npy": npy("(1000000, 1000000)")})


def objects_npz(path: Path) -> None:
    """An array of objects."""
    archive(path, {"a.npy": npy("(9,)", b"\x80\x04K\x01.", "|O")})


def many_npz(path: Path) -> None:
    """Two million members."""
    archive(path, {"a.npy": npy("(1,)", bytes(8))}, times=200_000)


def deflated(piece: bytes, times: int, head: bytes = b"") -> bytes:
    """Return a raw stream of a piece over and over, which is packed once.

    After a full flush nothing refers to what came before (RFC 1951, and zlib's manual).
    """
    packer = zlib.compressobj(6, wbits=-zlib.MAX_WBITS)
    first = packer.compress(head) + packer.flush(zlib.Z_FULL_FLUSH)
    block = packer.compress(piece) + packer.flush(zlib.Z_FULL_FLUSH)
    return first + block * times + packer.flush()


def gz(path: Path, piece: bytes, times: int, head: bytes = b"") -> None:
    """Write a packed file of one piece over and over."""
    check, size = zlib.crc32(head), len(head) + times * len(piece)
    for _ in range(times):
        check = zlib.crc32(piece, check)
    began = b"\x1f\x8b\x08" + bytes(6) + b"\xff"
    path.write_bytes(began + deflated(piece, times, head) + struct.pack("<II", check, size))


def nested_gz(path: Path) -> None:
    """A packed file within a packed file."""
    path.write_bytes(gzip.compress(gzip.compress(bytes(64 * MIB))))


def rows_parquet(path: Path) -> None:
    """10^8 equal rows, by their number and their value: 800 MB."""
    _parquet(path, {"time": np.zeros(10_000_000)}, 10)


def lists_parquet(path: Path) -> None:
    """Fifty cells with a million numbers each, all equal: 400 MB as they are read."""
    import pyarrow

    cell = pyarrow.array(np.zeros(50 * MIB, dtype=np.int8))
    ends = np.arange(51, dtype=np.int32) * MIB
    _parquet(path, {"q": pyarrow.ListArray.from_arrays(ends, cell)}, 1)


def texts_parquet(path: Path) -> None:
    """The same text of 10 kB in each of 100,000 rows."""
    import pyarrow

    words = pyarrow.DictionaryArray.from_arrays(np.zeros(100_000, dtype=np.int32), ["a" * 10_000])
    _parquet(path, {"time": np.zeros(100_000), "words": words}, 1)


def _parquet(path: Path, columns: dict[str, object], times: int) -> None:
    import pyarrow
    from pyarrow import parquet

    table = pyarrow.table(columns)
    with parquet.ParquetWriter(path, table.schema, compression="zstd") as writer:
        for _ in range(times):
            writer.write_table(table, row_group_size=len(table))


def fill_hdf5(path: Path) -> None:
    """10^9 numbers of which none is stored."""
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("time", shape=(10**9,), chunks=(10**6,), dtype="f8", fillvalue=1.0)


def zeros_hdf5(path: Path) -> None:
    """200 MB of zeros, packed."""
    import h5py

    with h5py.File(path, "w") as file:
        file.create_dataset("time", data=np.zeros(25 * MIB), chunks=(MIB,), compression="gzip")


def chunks_mcap(path: Path) -> None:
    """Chunks of 64 MB of zeros, packed to some kilobytes each."""
    import zstandard

    body = bytes(64 * MIB)
    packed = zstandard.compress(body)
    chunk = struct.pack("<QQQI", 0, 0, len(body), 0) + struct.pack("<I", 4) + b"zstd"
    chunk += struct.pack("<Q", len(packed)) + packed
    record = struct.pack("<BQ", 6, len(chunk)) + chunk
    path.write_bytes(b"\x89MCAP0\r\n" + 20 * record)


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
    Bomb(name="zeros.npz", reader="recording", make=zeros_npz),
    Bomb(name="long.npz", reader="recording", make=long_npz),
    Bomb(name="objects.npz", reader="recording", make=objects_npz),
    Bomb(name="many.npz", reader="recording", make=many_npz),
    Bomb(name="zeros.csv.gz", reader="recording", make=lambda p: gz(p, b"0,0\n" * MIB, 128)),
    Bomb(name="commas.csv.gz", reader="recording", make=lambda p: gz(p, b"," * MIB, 500)),
    Bomb(
        name="words.csv.gz",
        reader="recording",
        make=lambda p: gz(p, b"0,a\n" * MIB, 128, b"time,a\n"),
    ),
    Bomb(name="nested.csv.gz", reader="recording", make=nested_gz),
    Bomb(
        name="columns.csv",
        reader="recording",
        make=lambda p: p.write_text(",".join(f"c{at}" for at in range(100_000)) + "\n0"),
    ),
    Bomb(name="line.csv", reader="recording", make=lambda p: p.write_bytes(b"1," * (50 * MIB))),
    Bomb(name="rows.parquet", reader="recording", make=rows_parquet),
    Bomb(name="lists.parquet", reader="recording", make=lists_parquet),
    Bomb(name="texts.parquet", reader="recording", make=texts_parquet, read=True),
    Bomb(name="fill.h5", reader="recording", make=fill_hdf5),
    Bomb(name="zeros.h5", reader="recording", make=zeros_hdf5),
    Bomb(name="chunks.mcap", reader="recording", make=chunks_mcap),
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
