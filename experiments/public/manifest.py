"""The manifests of public data: which files a set has, where each is public and where it is here.

`data.toml` says what a person decided (origin, licence, how files are stored or made);
`manifests/<set>.toml` lists each file's size and hash and is written by a command.
"""

from __future__ import annotations

import os
import re
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import quote

from experiments.public.content import FORMS, DataError

REPOSITORY = Path(__file__).resolve().parents[2]
FETCHED = REPOSITORY / "experiments" / "data"
"""Where `python -m experiments.data` puts what it fetches; git ignores it."""
VARIABLES = {"recordings": "MORPH_RECORDINGS", "robots": "MORPH_ROBOTS"}
"""The kinds of data, and the environment variable that names the folder of each."""
LISTING = Path(__file__).resolve().parents[1] / "data.toml"
MANIFESTS = LISTING.parent / "manifests"
UNKNOWN = "unknown"
"""A commit that could not be established: the default branch is asked, and the hash decides."""
MOST_BYTES = 64 * 2**20
"""Largest file that a manifest may declare."""
MAX_STORED = 2 * MOST_BYTES
"""Bytes of a file that are read: XML may be indented more than its canonical form."""


@dataclass(frozen=True, kw_only=True)
class Hosts:
    """The servers that hold public repositories."""

    raw: str = "https://raw.githubusercontent.com"
    """Serves files of git."""
    media: str = "https://media.githubusercontent.com/media"
    """Serves what git LFS keeps outside of git."""


@dataclass(frozen=True, kw_only=True)
class Origin:
    """A public folder, and the files of a set that come from it."""

    repository: str = ""
    """`owner/name` on GitHub; empty if a package holds the files."""
    commit: str = ""
    """40 hex digits, or `unknown`."""
    package: str = ""
    """A package of PyPI that holds the files, installed here; empty for a repository."""
    version: str = ""
    """The version of that package."""
    folder: str = ""
    """The public folder."""
    below: str = ""
    """The folder of the set that its files go into."""
    files: tuple[str, ...] = ()
    """The only files that come from here, below `below`; empty for all that there are."""
    joined: str = ""
    """What replaces the slashes of public paths in the names of the set's files."""

    def path_of(self, file: str) -> str | None:
        """Return the public path of a set's file; None if it does not come from here."""
        inside = file.removeprefix(f"{self.below}/") if self.below else file
        if (self.below and inside == file) or (self.files and inside not in self.files):
            return None
        public = inside.replace(self.joined, "/") if self.joined else inside
        return f"{self.folder}/{public}" if self.folder else public

    def url(self, path: str, base: str) -> str:
        """Return the address of a public path on a host."""
        commit = "HEAD" if self.commit == UNKNOWN else self.commit
        return f"{base}/{self.repository}/{commit}/{quote(path)}"

    def __str__(self) -> str:
        if self.package:
            return f"{self.package} {self.version}"
        commit = "commit unknown" if self.commit == UNKNOWN else f"at {self.commit[:7]}"
        return f"{self.repository} {commit}"


@dataclass(frozen=True, kw_only=True)
class Made:
    """A file of a set that is made from public ones."""

    file: str
    """The file."""
    by: str
    """The converter: a key of `CONVERTERS`."""
    inputs: tuple[str, ...]
    """Names of the public files, or files of the set itself."""
    origin: Origin = Origin()
    """Where the public files are; without repository they are files of the set."""


@dataclass(frozen=True, kw_only=True)
class PublicFile:
    """One file of a set."""

    file: str
    """Its path inside the set's folder."""
    form: str
    """What its size and hash are of: a key of `FORMS`."""
    size: int
    """Bytes of the content, in that form."""
    sha256: str
    """Hash of the content, in that form."""
    origin: Origin = Origin()
    """Where it is public."""
    path: str = ""
    """Its public path."""
    made: Made | None = None
    """How it is made, if it is not public as it is."""


@dataclass(frozen=True, kw_only=True)
class DataSet:
    """One set of public data."""

    name: str
    """Its name, and that of its folder."""
    kind: str
    """`recordings` or `robots`."""
    licence: str
    """SPDX name of the licence of its files, or `none stated`."""
    about: str
    """What it is."""
    origins: tuple[Origin, ...]
    """Where its files are public; the first that fits a file counts."""
    unsettled: str = ""
    """What of its origin could not be established."""
    stored: str = "raw"
    """The form of its tables on disk: `raw`, or `gzip`."""
    notes: tuple[str, ...] = ()
    """Files beside it that who collected it wrote: no study reads them."""
    made: tuple[Made, ...] = ()
    """What is made from public files."""
    files: tuple[PublicFile, ...] = field(default=(), repr=False)
    """Its files, from its manifest."""

    def folder(self, root: Path) -> Path:
        """Return where the set is under a root that holds both kinds of data."""
        return root / self.kind / self.name

    def source_of(self, file: str) -> PublicFile:
        """Return a file of the set without size and hash.

        Raises:
            DataError: No origin of the set has it.
        """
        for made in self.made:
            if made.file == file:
                form = {".urdf": "xml", ".npz": "npz"}.get(PurePosixPath(file).suffix, "raw")
                return PublicFile(file=file, form=form, size=0, sha256="", made=made)
        packed = self.stored == "gzip" and file.endswith(".gz")
        for origin in self.origins:
            if path := origin.path_of(file.removesuffix(".gz") if packed else file):
                form = "gzip" if packed else "raw"
                return PublicFile(file=file, form=form, size=0, sha256="", origin=origin, path=path)
        raise DataError(
            f"no origin of {self.name} has {file}",
            where=str(LISTING),
            fix=f"name its origin under [[set.origin]] of {self.name}, or list it under notes",
        )


def data_root(kind: str = "recordings", *, repository: Path = REPOSITORY) -> Path:
    """Return the folder of the recordings or of the robots.

    The folder that MORPH_RECORDINGS or MORPH_ROBOTS names; else `../shared/<kind>` beside
    the repository if it is there; else `experiments/data/<kind>`, where downloads go.
    """
    named = os.environ.get(VARIABLES[kind])
    if named:
        return Path(named)
    shared = repository.parent / "shared" / kind
    return shared if shared.is_dir() else repository / "experiments" / "data" / kind


def load_sets(listing: Path = LISTING, manifests: Path = MANIFESTS) -> list[DataSet]:
    """Return every set that `data.toml` names, with the files of its manifest.

    Raises:
        DataError: A set or a file is described in a way that could reach outside its
            folder or its repository, or a key is missing or unknown.
    """
    found = []
    for table in tomllib.loads(listing.read_text())["set"]:
        whole = _set(table, str(listing))
        manifest = manifests / f"{whole.name}.toml"
        if manifest.is_file():
            rows = tomllib.loads(manifest.read_text())["file"]
            whole = with_files(whole, rows, str(manifest))
        found.append(whole)
    return found


def with_files(whole: DataSet, rows: dict[str, Any], where: str) -> DataSet:
    """Return a set with the files of a manifest: name to size and hash.

    Raises:
        DataError: A name, a size or a hash is not one.
    """
    files = []
    for name, row in sorted(rows.items()):
        _check(_plain(name), f"file {name!r}", "give a path inside the set, without ..", where)
        good = isinstance(row, list) and len(row) == 2 and isinstance(row[0], int)
        good = good and 0 <= row[0] <= MOST_BYTES and bool(re.fullmatch("[0-9a-f]{64}", row[1]))
        fix = f"give its size, at most {MOST_BYTES} bytes, and its sha256"
        _check(good, f"size and hash of {name!r}: {row}", fix, where)
        source = whole.source_of(name)
        files.append(replace(source, size=row[0], sha256=row[1]))
    # What is made may need the rest, so it comes last.
    files.sort(key=lambda public: public.made is not None)
    return replace(whole, files=tuple(files))


def _set(table: dict[str, Any], where: str) -> DataSet:
    table = dict(table)
    try:
        origins = tuple(_origin(one, where) for one in table.pop("origin"))
        made = tuple(_made(dict(one), where) for one in table.pop("made", ()))
        notes = tuple(table.pop("notes", ()))
        whole = DataSet(**table, origins=origins, made=made, notes=notes)
    except (KeyError, TypeError) as error:
        raise DataError(
            f"set {table.get('name')}: {error}",
            where=where,
            fix="give name, kind, licence, about and [[set.origin]], and no unknown key",
        ) from error
    _check(bool(re.fullmatch(r"\w+", whole.name)), f"name {whole.name!r}", "use a word", where)
    _check(whole.kind in VARIABLES, f"kind {whole.kind!r}", f"use {' or '.join(VARIABLES)}", where)
    _check(whole.stored in FORMS, f"stored {whole.stored!r}", "use raw or gzip", where)
    return whole


def _made(table: dict[str, Any], where: str) -> Made:
    origin = _origin(table.pop("origin"), where) if "origin" in table else Origin()
    numbered = table.pop("numbered", 0)
    inputs = [each.format(n) for each in table.pop("inputs") for n in range(numbered or 1)]
    made = Made(**table, inputs=tuple(inputs), origin=origin)
    for path in (made.file, *inputs):
        _check(_plain(path), f"file {path!r}", "give a path inside the set, without ..", where)
    return made


def _origin(table: dict[str, Any], where: str) -> Origin:
    origin = Origin(**{**table, "files": tuple(table.get("files", ()))})
    names = (origin.folder, origin.below, *origin.files)
    _check(all(map(_plain, filter(None, names))), f"folder {names}", "give it without ..", where)
    if origin.package:
        return origin
    _check(
        bool(re.fullmatch(r"\w[\w.-]*/\w[\w.-]*", origin.repository)),
        f"repository {origin.repository!r}",
        "give owner/name",
        where,
    )
    _check(
        origin.commit == UNKNOWN or bool(re.fullmatch("[0-9a-f]{40}", origin.commit)),
        f"commit {origin.commit!r} of {origin.repository}",
        f"give all 40 hex digits, or {UNKNOWN!r}",
        where,
    )
    return origin


def _plain(path: str) -> bool:
    """Return whether a path stays inside the folder that it is relative to."""
    parts = path.split("/")
    return "\\" not in path and "\0" not in path and not {"", ".", ".."} & set(parts)


def _check(good: bool, what: str, fix: str, where: str) -> None:
    if not good:
        raise DataError(f"cannot use {what}", where=where, fix=fix)
