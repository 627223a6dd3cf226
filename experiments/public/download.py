"""Fetching a set of public data: every file bounded, verified, and written whole or not at all."""

from __future__ import annotations

import gzip
import re
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from glob import escape
from http.client import HTTPException
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from experiments.public.content import DataError, verify
from experiments.public.convert import CONVERTERS
from experiments.public.manifest import MAX_STORED, DataSet, Hosts, Made, Origin, PublicFile
from morph.files import write_whole
from morph.regular_file import read_regular

PATIENCE = 120.0
"""Longest time for one file, s."""
MOST_UNHASHED = 2**20
"""Largest input of a converter, whose own hash nobody could note; its result has one."""
POINTER = re.compile(
    rb"version https://git-lfs\.github\.com/spec/v1\noid sha256:([0-9a-f]{64})\nsize (\d+)\s*"
)
"""What git holds in place of a file that git LFS keeps."""
LONGEST_POINTER = 512
Get = Callable[[str, int], bytes]


def install(
    whole: DataSet,
    public: PublicFile,
    root: Path,
    *,
    hosts: Hosts | None = None,
    get: Get | None = None,
) -> bool:
    """Put a file of a set under a root; return False if it was there already.

    What is made from other files of its set needs those there first.

    Raises:
        DataError: It cannot be had, or is not what was used; nothing is written.
    """
    hosts, get = hosts or Hosts(), get or fetch
    folder = whole.folder(root)
    path = inside(folder, public.file)
    if present(public, path):
        return False
    if public.made is not None:
        data = _convert(public.made, folder, hosts, get)
        where = f"{public.file}, made by the converter {public.made.by}"
    else:
        data = _public(public, hosts, get)
        where = f"{public.origin}, {public.path}"
    verify(public, data, where)
    write_whole(path, data)
    # What a killed run had begun to write of this file.
    for begun in path.parent.glob(f".{escape(path.name)}.*"):
        begun.unlink(missing_ok=True)
    return True


def inside(folder: Path, file: str) -> Path:
    """Return the path of a file inside a folder.

    Raises:
        DataError: A link in the folder leads out of it.
    """
    path = folder / file
    if not path.resolve().is_relative_to(folder.resolve()):
        raise DataError(
            f"{file} is led outside by a link",
            where=str(folder),
            fix="remove the link, or fetch into another folder by --to",
        )
    return path


def present(public: PublicFile, path: Path) -> bool:
    """Return whether the right file stands at a path already."""
    try:
        verify(public, read_regular(path, MAX_STORED), str(path))
    except (OSError, DataError):
        return False
    return True


def fetch(url: str, most: int, *, patience: float = PATIENCE) -> bytes:
    """Return what a URL holds.

    Args:
        url: The address.
        most: Largest answer, bytes.
        patience: Longest time in all, s.

    Raises:
        DataError: The network, the server or the address fails, the answer takes
            too long, or it is larger than `most`.
    """
    deadline = time.monotonic() + patience
    chunks, size = [], 0
    try:
        with _OPENER.open(url, timeout=patience) as answer:
            while chunk := answer.read1(2**16):
                chunks.append(chunk)
                size += len(chunk)
                if size > most:
                    raise DataError(
                        f"answers with more than the {most} bytes that are declared",
                        where=url,
                        fix="see that the manifest's commit and path are those of the file",
                    )
                if time.monotonic() > deadline:
                    raise TimeoutError(f"not complete after {patience:g} s")
    except (OSError, HTTPException, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        code = f"{error.code} " if isinstance(error, urllib.error.HTTPError) else ""
        raise DataError(
            f"cannot download: {code}{reason}",
            where=url,
            fix="check the network and run it again, or put the files into a folder "
            "that MORPH_RECORDINGS or MORPH_ROBOTS names",
        ) from error
    return b"".join(chunks)


class SafeRedirect(urllib.request.HTTPRedirectHandler):
    """Follows redirects, but not from an encrypted connection to an open one."""

    def redirect_request(
        self, req: Any, fp: Any, code: int, msg: str, headers: Any, newurl: str
    ) -> Any:
        """Return the request for a new address, unless that is not encrypted any more."""
        if req.full_url.startswith("https:") and not newurl.startswith("https:"):
            raise urllib.error.URLError(f"redirected to {newurl}, which is not encrypted")
        return super().redirect_request(req, fp, code, msg, headers, newurl)


_OPENER = urllib.request.build_opener(SafeRedirect)


def _public(public: PublicFile, hosts: Hosts, get: Get) -> bytes:
    """Return a public file as the set stores it."""
    if public.origin.package:
        return _packaged(public.origin, public.path)
    url = public.origin.url(public.path, hosts.raw)
    data = get(url, max(public.size, LONGEST_POINTER))
    pointer = POINTER.fullmatch(data)
    # A pointer may itself be the file that was used; what it points to is named by its hash.
    if pointer and pointer[1].decode() == public.sha256 and int(pointer[2]) == public.size:
        data = get(public.origin.url(public.path, hosts.media), public.size)
    return gzip.compress(data, mtime=0) if public.form == "gzip" else data


def _packaged(origin: Origin, path: str) -> bytes:
    """Return a file of an installed package."""
    fix = f"run pip install {origin.package}=={origin.version}"
    try:
        package = distribution(origin.package)
        if package.version == origin.version:
            return Path(str(package.locate_file(path))).read_bytes()
    except (PackageNotFoundError, OSError) as error:
        raise DataError(f"has no {path}: {error}", where=origin.package, fix=fix) from error
    what = f"is version {package.version} instead of {origin.version}"
    raise DataError(what, where=origin.package, fix=fix)


def _convert(made: Made, folder: Path, hosts: Hosts, get: Get) -> bytes:
    """Return a file that is made from others."""
    if not made.origin.repository:
        return CONVERTERS[made.by](folder, dict.fromkeys(made.inputs, b""))
    inputs = {}
    for name in made.inputs:
        path = made.origin.path_of(name) or name
        inputs[name] = get(made.origin.url(path, hosts.raw), MOST_UNHASHED)
    return CONVERTERS[made.by](folder, inputs)
