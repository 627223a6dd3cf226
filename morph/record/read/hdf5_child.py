"""The process that reads one HDF5 file: what HDF5 does to itself there, it does to nobody else."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

LIBRARIES_BYTES = 2 * 2**30
"""Address space that the libraries take, beside a column as it is stored and as numbers."""
CPU_SECONDS = 10
"""Time of computing after which the system ends the process, for a small file."""
BYTES_A_SECOND = 2_000_000
"""How much of a large file is read for each second more; many small data sets take longest."""


def main() -> None:
    """Read what standard input asks for; write lines of JSON, and numbers after those of columns.

    Lines are `{"key", "named", "names", "note"}` for an episode, then for each of its
    data sets `{"shape"}` and its numbers as they stand in memory; `{"what", "where",
    "fix"}` for an error, and `{"end": true}`.
    """
    request = json.loads(sys.stdin.buffer.read())
    path = Path(request["path"])
    _limit(path)
    from morph.errors import RecordingError

    try:
        _read(request, path)
        _say({"end": True})
    except RecordingError as error:
        _say({"what": error.what, "where": error.where, "fix": error.fix})
    # h5py raises a dozen unrelated errors on damaged bytes.
    except Exception as error:
        _say({"what": str(error)[:200] or type(error).__name__})
    sys.stdout.buffer.flush()


def _read(request: dict[str, Any], path: Path) -> None:
    import h5py

    from morph.record.read.hdf5_file import Bounds, blocks_in, numbers_of

    bounds = Bounds(path)
    # Each chunk is read once: a cache of them for each data set would only take memory.
    with h5py.File(path, "r", locking=False, rdcc_nbytes=0) as file:
        for block in blocks_in(file, path, request["key"], request["wanted"], request["every"]):
            names = list(block.columns)
            _say({"key": block.key, "named": block.named, "names": names, "note": block.note})
            for numbers in numbers_of(block, bounds):
                _say({"shape": numbers.shape})
                sys.stdout.buffer.write(numbers.tobytes())


def _say(line: dict[str, Any]) -> None:
    sys.stdout.buffer.write(json.dumps(line).encode() + b"\n")


def _limit(path: Path) -> None:
    import resource

    from morph.record.limits import most_unpacked

    size = path.stat().st_size
    seconds = CPU_SECONDS + size // BYTES_A_SECOND
    for what, most in (
        (resource.RLIMIT_AS, LIBRARIES_BYTES + 2 * most_unpacked(size)),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 32),
    ):
        hard = resource.getrlimit(what)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(what, (least, least))
