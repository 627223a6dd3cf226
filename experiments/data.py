"""`python -m experiments.data`: the public recordings that the studies use, verified."""

from __future__ import annotations

import argparse
import gzip
import hashlib
import os
import sys
import tomllib
import urllib.error
import urllib.request
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path

from morph.errors import MorphError
from morph.files import write_whole

HERE = Path(__file__).resolve().parent
RAW = "https://raw.githubusercontent.com"
EXAMPLE = """example:
  python -m experiments.data --set dfki_double_pendulum
  python -m experiments.data --check
"""
Fetch = Callable[[str], bytes]


class DataError(MorphError):
    """A public recording cannot be had, or is not what was used."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """One recording's file and where it is public."""

    set: str
    """The set that it belongs to."""
    file: str
    """Its gzipped file inside the set's folder."""
    url: str
    """Where the raw, uncompressed file is public."""
    size: int
    """Bytes of the uncompressed file."""
    sha256: str
    """Hash of the uncompressed file."""

    def at(self, root: Path) -> Path:
        """Return where the file stands under a root."""
        return root / self.set / self.file


def data_root() -> Path:
    """Return the folder of the recordings.

    MORPH_RECORDINGS if it is set, else `../shared/recordings` beside the
    repository if it is there, else `experiments/data`, where downloads go.
    """
    named = os.environ.get("MORPH_RECORDINGS")
    if named:
        return Path(named)
    shared = HERE.parent.parent / "shared" / "recordings"
    return shared if shared.is_dir() else HERE / "data"


def sources(listing: Path = HERE / "data.toml", *, raw: str = RAW) -> list[Source]:
    """Return every recording that `data.toml` names."""
    table = tomllib.loads(listing.read_text())
    return [
        Source(
            set=group["name"],
            file=entry["file"],
            url=f"{raw}/{group['repository']}/{group['commit']}/{entry['path']}",
            size=entry["size"],
            sha256=entry["sha256"],
        )
        for group in table["set"]
        for entry in group["file"]
    ]


def fetch(url: str) -> bytes:
    """Return what a URL holds.

    Raises:
        DataError: The network, the server or the address fails, or the answer is cut short.
    """
    try:
        with urllib.request.urlopen(url, timeout=60) as answer:
            return bytes(answer.read())
    except (OSError, HTTPException, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        raise DataError(
            f"cannot download: {reason}",
            where=url,
            fix="check the network, or put the files in a folder that MORPH_RECORDINGS names",
        ) from error


def verify(source: Source, content: bytes, where: str) -> None:
    """Check that uncompressed bytes are those that were used.

    Raises:
        DataError: The size or the hash differs.
    """
    fix = "download again with python -m experiments.data"
    if len(content) != source.size:
        raise DataError(
            f"holds {len(content)} bytes instead of {source.size}", where=where, fix=fix
        )
    found = hashlib.sha256(content).hexdigest()
    if found != source.sha256:
        raise DataError(f"has sha256 {found} instead of {source.sha256}", where=where, fix=fix)


def check(source: Source, root: Path) -> None:
    """Check that a recording stands under a root, whole and unchanged.

    Raises:
        DataError: It is missing, damaged or different.
    """
    path = source.at(root)
    try:
        content = gzip.decompress(path.read_bytes())
    except (OSError, EOFError, zlib.error) as error:
        raise DataError(
            f"cannot be read: {getattr(error, 'strerror', None) or error}",
            where=str(path),
            fix="download it with python -m experiments.data",
        ) from error
    verify(source, content, str(path))


def present(source: Source, root: Path) -> bool:
    """Return whether a verified copy already stands under a root."""
    try:
        check(source, root)
    except DataError:
        return False
    return True


def download(source: Source, root: Path, *, get: Fetch = fetch) -> bool:
    """Put a recording under a root, verified and gzipped; return False if it was there.

    Raises:
        DataError: It cannot be had, or is not what was used; nothing is written.
    """
    if present(source, root):
        return False
    content = get(source.url)
    verify(source, content, source.url)
    write_whole(source.at(root), gzip.compress(content, mtime=0))
    return True


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit status."""
    known = sources()
    parser = argparse.ArgumentParser(
        prog="python -m experiments.data",
        description="Download and verify the public recordings that the studies use.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    names = sorted({source.set for source in known})
    parser.add_argument("--set", choices=names, help="only this set (default: all)")
    parser.add_argument(
        "--where", action="store_true", help="print the folder that the studies read, for --root"
    )
    parser.add_argument(
        "--check", action="store_true", help="only verify the files that the studies would read"
    )
    chosen = parser.parse_args(arguments)
    if chosen.where:
        print(data_root() / chosen.set if chosen.set else data_root())
        return 0
    wanted = [source for source in known if chosen.set in (None, source.set)]
    root = data_root() if chosen.check else HERE / "data"
    try:
        if chosen.check:
            for source in wanted:
                check(source, root)
            print(f"{len(wanted)} recordings under {root} are those that were used")
            return 0
        new = 0
        for number, source in enumerate(wanted, start=1):
            fresh = download(source, root)
            new += fresh
            print(f"[{number}/{len(wanted)}] {source.at(root)}{'' if fresh else ' (was there)'}")
        print(f"{len(wanted)} recordings under {root}, {new} of them new")
    except MorphError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
