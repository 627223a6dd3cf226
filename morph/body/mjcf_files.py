"""The files that an MJCF names, read inside its folder; and what it may not hold."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

from morph.body.finding import Finding, Severity
from morph.body.mesh import read_mesh
from morph.body.mjcf_draft import Lines
from morph.body.mjcf_numbers import check_numbers
from morph.body.paths import Files
from morph.body.xml import DEEPEST, MOST_BYTES, Element, parse
from morph.errors import MeshError, RobotError

FORBIDDEN = ("plugin", "extension", "model")
"""Elements that load code or other models."""

GREATEST = {
    "count": 10_000,
    "nrow": 4096,
    "ncol": 4096,
    "width": 8192,
    "height": 8192,
    "nuser_body": 1000,
    "nuser_jnt": 1000,
    "nuser_geom": 1000,
    "nuser_site": 1000,
    "nuser_cam": 1000,
    "nuser_tendon": 1000,
    "nuser_actuator": 1000,
    "nuser_sensor": 1000,
    "nkey": 100_000,
    "nuserdata": 100_000,
    "njmax": 1_000_000,
    "nconmax": 1_000_000,
    "nstack": 100_000_000,
    "maxhullvert": 100_000,
    "octree_maxdepth": 10,
    "maxcontacts": 100_000,
    "order": 10,
    "nsample": 10_000,
}
"""Greatest value of attributes by which a few letters ask for much memory."""

MOST_MEMORY = 2**30
"""Most memory that an MJCF may ask for, bytes."""

MOST_PIXELS = 2**26
"""Most pixels of a picture."""

REFERENCES = {"mesh": ("mesh",), "hfield": ("hfield",), "texture": ("texture",)}
"""Attributes that name an asset of a kind."""


def gather(
    tree: Element, path: Path, files: Files, lines: Lines
) -> tuple[Element, dict[str, bytes], list[Finding]]:
    """Return an MJCF with its includes in place, the files it names, and what was found.

    Each file stands in the tree under a name of its own, so that MuJoCo opens
    nothing. What is not there is taken out, with all that uses it.

    Raises:
        RobotError: It holds an element that runs code or a number that is absurd, asks
            for absurd amounts of memory, or includes a file that is not there.
    """
    _include(tree, path, files, lines, {path.resolve()}, 0)
    findings = check_numbers(tree, lines)
    for element in tree.everything():
        _check(element)
    _check_repeats(tree, 1)
    gathered = _Gatherer(tree, files, lines)
    gathered.run()
    return tree, gathered.assets, [*findings, *gathered.findings]


def _include(
    tree: Element, path: Path, files: Files, lines: Lines, open_: set[Path], depth: int
) -> None:
    for parent in list(tree.everything()):
        for at, child in reversed(list(enumerate(parent))):
            if not isinstance(child, Element) or child.tag != "include":
                continue
            found = files.find(child.get("file", ""))
            if found.path is None or depth > DEEPEST or found.path.resolve() in open_:
                why = "lies outside its folder" if found.how == "outside" else "is not there"
                if found.path is not None:
                    why = "is included twice"
                raise RobotError(
                    f"the file {child.get('file', '')!r} that it includes {why}",
                    where=child.place,
                    fix=f"put it into {files.folder}, and include it once",
                )
            open_.add(found.path.resolve())
            if found.path.stat().st_size > MOST_BYTES:
                raise RobotError("is too large", where=str(found.path), fix="include less")
            other = parse(found.path.read_bytes(), str(found.path))
            lines.add(other)
            _include(other, found.path, files, lines, open_, depth + 1)
            parent.remove(child)
            for offset, grandchild in enumerate(list(other)):
                parent.insert(at + offset, grandchild)


def _check(element: Element) -> None:
    if element.tag in FORBIDDEN:
        raise RobotError(
            f"<{element.tag}> loads code or another model, which descriptions from strangers "
            "may not",
            where=element.place,
            fix="describe the robot in one file, without it",
        )
    # MuJoCo 4.0 takes some of its own messages for formats, and so a name's % for a command.
    for key, value in element.attrib.items():
        if "%" in value:
            raise RobotError(
                f"<{element.tag}> has a per cent sign in {key}={value[:80]!r}",
                where=element.place,
                fix="write it without the sign",
            )
    for key, greatest in GREATEST.items():
        for word in element.get(key, "").split():
            try:
                small = abs(float(word)) <= greatest
            except ValueError:
                small = True  # MuJoCo says what it is.
            if not small:
                raise RobotError(
                    f"<{element.tag}> asks for {key}={word}; {greatest} are allowed",
                    where=element.place,
                    fix="ask for less",
                )
    if "memory" in element.attrib and _bytes(element.get("memory", "")) > MOST_MEMORY:
        raise RobotError(
            f"<{element.tag}> asks for {element.get('memory')} of memory",
            where=element.place,
            fix="leave memory out; MuJoCo knows how much it needs",
        )


def _bytes(text: str) -> float:
    units = {"K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40, "P": 2**50, "E": 2**60}
    try:
        factor = units.get(text.strip()[-1:].upper(), 1)
        return float(text.strip().rstrip("KMGTPEkmgtpe")) * factor
    except ValueError:
        return 0.0


def _check_repeats(element: Element, times: int) -> None:
    for child in element.children():
        each = times
        if child.tag == "replicate":
            each *= max(1, int(float(child.get("count", "1") or 1)))
        if child.tag in ("composite", "flexcomp"):
            for word in child.get("count", "1").split():
                each *= max(1, int(float(word)))
        if each > GREATEST["count"]:
            raise RobotError(
                f"its copies multiply to {each}; {GREATEST['count']} are allowed",
                where=child.place,
                fix="repeat less",
            )
        _check_repeats(child, each)


class _Gatherer:
    """Reads the files of assets; takes out those that cannot be read."""

    def __init__(self, tree: Element, files: Files, lines: Lines) -> None:
        self.tree, self.files, self.lines = tree, files, lines
        self.assets: dict[str, bytes] = {}
        self.findings: list[Finding] = []
        self.folders = {"mesh": "", "texture": ""}

    def run(self) -> None:
        for compiler in list(self.tree.everything()):
            if compiler.tag != "compiler":
                continue
            for kind, key in (("mesh", "meshdir"), ("texture", "texturedir")):
                folder = compiler.attrib.pop(key, compiler.get("assetdir"))
                self.folders[kind] = self.folders[kind] if folder is None else folder
            compiler.attrib.pop("assetdir", None)
            compiler.attrib.pop("strippath", None)
        missing: set[tuple[str, str]] = set()
        for parent, element in list(_pairs(self.tree)):
            for key in [key for key in element.attrib if key.startswith("file")]:
                if element.tag == "include" or self.read(element, key):
                    continue
                missing.add((element.tag, asset_name(element)))
                if element in list(parent):
                    parent.remove(element)
        for parent, element in list(_pairs(self.tree)):
            for kind, name in missing:
                if element.tag != kind and element.get(kind) == name:
                    self.drop(parent, element, kind)

    def drop(self, parent: Element, element: Element, kind: str) -> None:
        if kind == "texture" or element.tag == "default":
            del element.attrib[kind]
        elif element in list(parent):
            parent.remove(element)

    def read(self, element: Element, key: str) -> bool:
        """Take a file in; return whether it could be."""
        written = element.get(key, "")
        folder = self.folders["texture" if element.tag == "texture" else "mesh"]
        found = self.files.find(written, folder)
        name = asset_name(element)
        if found.path is None:
            code = "mesh-outside" if found.how == "outside" else "mesh-missing"
            what = f"the file {written!r} is nowhere in {self.files.folder}"
            self.tell(element, code, "repaired", what, "what uses it was left out")
            return False
        try:
            content = found.path.read_bytes()
            if element.tag == "mesh" and found.path.suffix.lower() != ".msh":
                read_mesh(content, found.path.suffix, str(found.path))
            if element.tag == "texture":
                _check_picture(content, str(found.path))
        except MeshError as error:
            what = f"{found.path.name} {error.what}"
            self.tell(element, error.code, "repaired", what, "what uses it was left out")
            return False
        except OSError as error:
            what = f"{found.path.name} cannot be read: {error.strerror}"
            self.tell(element, "mesh-unreadable", "repaired", what, "what uses it was left out")
            return False
        if found.how in ("case", "moved"):
            shown = found.path.relative_to(self.files.folder)
            code = "mesh-case" if found.how == "case" else "mesh-path"
            what = f"the file {written!r} is there as {str(shown)!r}"
            self.tell(element, code, "repaired", what, "that file was taken")
        element.set("name", name)
        asset = f"{len(self.assets)}_{found.path.name}"
        self.assets[asset] = content
        element.set(key, asset)
        return True

    def tell(self, element: Element, code: str, severity: Severity, what: str, done: str) -> None:
        where = self.lines.place(element.tag, asset_name(element))
        if not where.line:
            where = type(where)(
                kind=element.tag, name=asset_name(element), file=element.file, line=element.line
            )
        fix = "put the file there, or correct its name"
        self.findings.append(
            Finding(code=code, severity=severity, where=where, what=what, done=done, fix=fix)
        )


def asset_name(element: Element) -> str:
    """Return an asset's name; without one, MuJoCo takes its file's."""
    return element.get("name") or Path(element.get("file", "").replace("\\", "/")).stem


def _pairs(tree: Element) -> Iterator[tuple[Element, Element]]:
    for parent in tree.everything():
        for child in parent.children():
            yield parent, child


def _check_picture(content: bytes, where: str) -> None:
    if content[:8] == b"\x89PNG\r\n\x1a\n" and len(content) > 24:
        width, height = struct.unpack(">II", content[16:24])
        if width * height <= MOST_PIXELS:
            return
    raise MeshError(
        "is no PNG picture of a usual size",
        where=where,
        fix="give a PNG",
        code="mesh-unreadable",
    )
