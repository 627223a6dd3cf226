"""Small recordings that ask for far more memory or time than they have bytes."""

from __future__ import annotations

import gzip
import sqlite3
import struct
import zlib
from contextlib import closing
from pathlib import Path

import numpy as np

from experiments.bomb_pieces import MIB, Bomb, archive, gz, npy


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


def header_npz(path: Path) -> None:
    """An array's header of 400 MB."""
    size = 400 * MIB
    archive(path, {"a.npy": b"\x93NUMPY\x02\x00" + struct.pack("<I", size) + bytes(size)})


def headers_npz(path: Path) -> None:
    """Ten thousand headers, each with 600 entries for Python to parse."""
    entries = "'fortran_order': False, 'shape': (1,), " + "'descr': '<f8', " * 600
    head = f"{{{entries}}}\n".encode()
    body = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + bytes(8)
    archive(path, {"a.npy": body}, times=9999)


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
    # Least and greatest values take longer than all else, and make the file larger.
    told = {"compression": "zstd", "write_statistics": False}
    with parquet.ParquetWriter(path, table.schema, **told) as writer:
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
        made = file.create_dataset("time", 25 * MIB, "<f8", chunks=(MIB,), compression="gzip")
        packed = zlib.compress(bytes(8 * MIB))
        for at in range(25):
            made.id.write_direct_chunk((at * MIB,), packed)


def sets_hdf5(path: Path) -> None:
    """A data set by 20,000 names."""
    import h5py

    with h5py.File(path, "w") as file:
        file["0"] = np.zeros(9)
        for at in range(1, 20_000):
            file.id.links.create_hard(str(at).encode(), file.id, b"0")


def groups_hdf5(path: Path) -> None:
    """10^12 groups: twelve within each other, each by ten names."""
    import h5py

    with h5py.File(path, "w") as file:
        group = file
        for _ in range(12):
            inner = group.create_group("0")
            for at in range(1, 10):
                group[str(at)] = inner
            group = inner


def chunk_hdf5(path: Path) -> None:
    """A hundred data sets of one number, each in a chunk of 250 MB."""
    import h5py

    size = 250 * MIB
    with h5py.File(path, "w") as file:
        like = {"maxshape": (None,), "chunks": (size,), "compression": "gzip"}
        made = file.create_dataset("0", (1,), "i1", **like)
        made.id.write_direct_chunk((0,), zlib.compress(bytes(size)))
        for at in range(1, 100):
            file.id.links.create_hard(str(at).encode(), file.id, b"0")


def tree_db3(path: Path) -> None:
    """70^12 messages: each page of a tree lists the one below it 70 times.

    Source: https://www.sqlite.org/fileformat2.html, section 1.6.
    """
    size, children = 512, 70
    with closing(sqlite3.connect(path)) as database:
        database.executescript(
            f"PRAGMA page_size = {size}; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, "
            "type TEXT, serialization_format TEXT); CREATE TABLE messages(id INTEGER PRIMARY KEY, "
            "topic_id INTEGER, timestamp INTEGER, data BLOB); "
            "INSERT INTO topics VALUES (1, '/a', 'std_msgs/msg/Header', 'cdr'); "
            "INSERT INTO messages VALUES (1, 2, 3, x'00');"
        )
        ((root,),) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'")
    content = bytearray(path.read_bytes())
    begin, places = (root - 1) * size, range(size - 5 * children, size, 5)
    content += content[begin : begin + size]
    for _ in range(12):
        below = len(content) // size
        page = struct.pack(">BHHHBI", 5, 0, children, places[0], 0, below)
        page += struct.pack(f">{children}H", *places)
        page += bytes(places[0] - len(page)) + (struct.pack(">I", below) + b"\x01") * children
        content += page
    content[begin : begin + size] = page
    content[28:32] = struct.pack(">I", len(content) // size)
    path.write_bytes(content)


def chunks_mcap(path: Path) -> None:
    """Chunks of 64 MB of zeros, packed to some kilobytes each."""
    import zstandard

    body = bytes(64 * MIB)
    packed = zstandard.compress(body)
    chunk = struct.pack("<QQQI", 0, 0, len(body), 0) + struct.pack("<I", 4) + b"zstd"
    chunk += struct.pack("<Q", len(packed)) + packed
    record = struct.pack("<BQ", 6, len(chunk)) + chunk
    path.write_bytes(b"\x89MCAP0\r\n" + 20 * record)


RECORDINGS = (
    Bomb(name="zeros.npz", reader="recording", make=zeros_npz),
    Bomb(name="long.npz", reader="recording", make=long_npz),
    Bomb(name="objects.npz", reader="recording", make=objects_npz),
    Bomb(name="many.npz", reader="recording", make=many_npz),
    Bomb(name="header.npz", reader="recording", make=header_npz),
    Bomb(name="headers.npz", reader="recording", make=headers_npz),
    Bomb(name="zeros.csv.gz", reader="recording", make=lambda p: gz(p, b"0,0\n" * MIB, 128)),
    Bomb(name="commas.csv.gz", reader="recording", make=lambda p: gz(p, b"," * MIB, 500)),
    Bomb(
        name="words.csv.gz",
        reader="recording",
        make=lambda p: gz(p, b"0,a\n" * MIB, 128, b"time,a\n"),
    ),
    Bomb(
        name="lists.csv.gz",
        reader="recording",
        make=lambda p: gz(p, (b'0,"[0' + b",0" * 999 + b']"\n') * 512, 64, b"time,a\n"),
    ),
    Bomb(
        name="blanks.csv.gz",
        reader="recording",
        make=lambda p: gz(p, b"0\n\n\n\n" * (MIB // 4), 48, b"a\n"),
    ),
    Bomb(name="nested.csv.gz", reader="recording", make=nested_gz),
    Bomb(
        name="columns.csv",
        reader="recording",
        make=lambda p: p.write_text(",".join(f"c{at}" for at in range(100_000)) + "\n0"),
    ),
    Bomb(name="line.csv", reader="recording", make=lambda p: p.write_bytes(b"1," * (50 * MIB))),
    Bomb(
        name="ragged.csv",
        reader="recording",
        make=lambda p: p.write_bytes(b"0,0\n" * (4 * MIB) + b"0,0,0\n"),
    ),
    Bomb(
        name="quote.csv",
        reader="recording",
        make=lambda p: p.write_bytes(b'time,a\n0,"' + b"0,0\n" * (4 * MIB)),
    ),
    Bomb(
        name="text.csv",
        reader="recording",
        make=lambda p: p.write_bytes(b"0,a\n" * (4 * MIB)),
        read=True,
    ),
    Bomb(name="rows.parquet", reader="recording", make=rows_parquet),
    Bomb(name="lists.parquet", reader="recording", make=lists_parquet),
    Bomb(name="texts.parquet", reader="recording", make=texts_parquet, read=True),
    Bomb(name="fill.h5", reader="recording", make=fill_hdf5),
    Bomb(name="zeros.h5", reader="recording", make=zeros_hdf5),
    Bomb(name="sets.h5", reader="recording", make=sets_hdf5),
    Bomb(name="groups.h5", reader="recording", make=groups_hdf5),
    Bomb(name="chunk.h5", reader="recording", make=chunk_hdf5),
    Bomb(name="tree.db3", reader="recording", make=tree_db3),
    Bomb(name="chunks.mcap", reader="recording", make=chunks_mcap),
)
"""Tricks on readers of recordings."""
