"""The files that an MJCF names, read inside its folder; and what it may not hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from morph.body.finding import DescriptionFinding, Severity
from morph.body.mjcf_assets import asset_content
from morph.body.mjcf_bounds import check_bounds
from morph.body.mjcf_draft import ElementLines
from morph.body.mjcf_numbers import check_numbers
from morph.body.numbers import float_or
from morph.body.paths import Files
from morph.body.shapes import MOST_FACES
from morph.body.source import read_text
from morph.body.xml import DEEPEST, Element, parse
from morph.errors import MeshError, RobotError

MOST_FILES = 200
"""Most files that an MJCF may include."""

KINDS = ("mesh", "hfield", "texture")
"""Assets that others name in an attribute of that name."""


def gather(
    tree: Element, path: Path, files: Files, lines: ElementLines
) -> tuple[Element, dict[str, bytes], list[DescriptionFinding]]:
    """Return an MJCF with its includes in place, the files it names, and what was found.

    Each file stands in the tree under a name of its own, so that MuJoCo opens
    nothing. What is not there is taken out, with all that uses it.

    Raises:
        RobotError: It holds an element that runs code or a number that is absurd, asks
            for absurd amounts of memory, or includes a file that is not there.
    """
    _include(tree, path, files, lines, {path.resolve()}, 0)
    findings = check_numbers(tree, lines)
    check_bounds(tree)
    gathered = _Gatherer(tree, files, lines)
    gathered.run()
    return tree, gathered.assets, [*findings, *gathered.findings]


def _include(
    tree: Element, path: Path, files: Files, lines: ElementLines, open_: set[Path], depth: int
) -> None:
    for parent in list(tree.everything()):
        for at, child in reversed(list(enumerate(parent))):
            if not isinstance(child, Element) or child.tag != "include":
                continue
            result = files.find(child.get("file", ""))
            if result.path is None or depth > DEEPEST or result.path.resolve() in open_:
                why = "lies outside its folder" if result.how == "outside" else "is not there"
                if result.path is not None:
                    why = "is included twice"
                raise RobotError(
                    f"the file {child.get('file', '')!r} that it includes {why}",
                    where=child.place,
                    fix=result.fix if result.path is None else "include it once",
                )
            open_.add(result.path.resolve())
            if len(open_) > MOST_FILES:
                what = f"it includes more than {MOST_FILES} files"
                raise RobotError(what, where=child.place, fix="include less")
            other = parse(read_text(result.path), str(result.path))
            lines.add(other)
            _include(other, result.path, files, lines, open_, depth + 1)
            parent.remove(child)
            for offset, grandchild in enumerate(list(other)):
                parent.insert(at + offset, grandchild)


class _Gatherer:
    """Reads the files of assets; takes out those that cannot be read."""

    def __init__(self, tree: Element, files: Files, lines: ElementLines) -> None:
        self.tree, self.files, self.lines = tree, files, lines
        self.assets: dict[str, bytes] = {}
        self.findings: list[DescriptionFinding] = []
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
        gone: set[int] = set()
        missing: dict[str, set[str]] = {kind: set() for kind in KINDS}
        for element in self.tree.everything():
            for key in [key for key in element.attrib if key.startswith("file")]:
                if not self.read(element, key):
                    missing.setdefault(element.tag, set()).add(asset_name(element))
                    gone.add(id(element))
                    break
        if not gone:
            return
        for parent, element in _pairs(self.tree):
            for kind in KINDS:
                if element.tag != kind and element.attrib.get(kind) in missing[kind]:
                    self.drop(parent, element, kind, gone)
        for parent in list(self.tree.everything()):
            parent[:] = [child for child in parent if id(child) not in gone]

    def drop(self, parent: Element, element: Element, kind: str, gone: set[int]) -> None:
        """Take an element out that needs what is missing, or only its mention of it."""
        if kind == "texture" or "default" in (element.tag, parent.tag):
            del element.attrib[kind]
            return
        gone.add(id(element))
        if element.tag == "geom" and parent.tag == "body" and weighs(self.tree, parent, element):
            self.tell(
                parent,
                "mass-missing",
                "repaired",
                f"its mass comes from its shapes, and {element.get(kind)!r} is missing",
                "it weighs what is left",
                "put the file there, or give the body an <inertial>",
            )

    def read(self, element: Element, key: str) -> bool:
        """Take a file in; return whether it could be."""
        written = element.get(key, "")
        folder = self.folders["texture" if element.tag == "texture" else "mesh"]
        result = self.files.find(written, folder)
        if result.path is None:
            outside = result.how == "outside"
            code = "mesh-outside" if outside else "mesh-missing"
            why = f"lies outside {self.files.folder}" if outside else "is nowhere"
            what = f"the file {written!r} {why}"
            if not outside:
                what += f" in {self.files.folder}"
            self.tell(element, code, "repaired", what, "what uses it was left out", result.fix)
            return False
        try:
            content, ending, done = asset_content(element.tag, result.path)
        except MeshError as error:
            what = f"{result.path.name} {error.what}"
            self.tell(element, error.code, "repaired", what, "what uses it was left out", error.fix)
            return False
        if done:
            what = f"{result.path.name} has more than {MOST_FACES} faces, which MuJoCo cannot take"
            self.tell(element, "mesh-too-large", "repaired", what, done, "export it coarser")
        if result.how in ("case", "moved"):
            shown = result.path.relative_to(self.files.folder)
            code = "mesh-case" if result.how == "case" else "mesh-path"
            what = f"the file {written!r} is there as {str(shown)!r}"
            self.tell(element, code, "repaired", what, "that file was taken")
        element.set("name", asset_name(element))
        element.attrib.pop("content_type", None)
        asset = f"{len(self.assets)}_{result.path.stem}{ending}"
        self.assets[asset] = content
        element.set(key, asset)
        return True

    def tell(
        self,
        element: Element,
        code: str,
        severity: Severity,
        what: str,
        done: str,
        fix: str = "put the file there, or correct its name",
    ) -> None:
        where = self.lines.place(element.tag, asset_name(element))
        if not where.line:
            where = replace(where, file=element.file, line=element.line)
        self.findings.append(
            DescriptionFinding(
                code=code, severity=severity, where=where, what=what, done=done, fix=fix
            )
        )


def asset_name(element: Element) -> str:
    """Return an asset's name; without one, MuJoCo takes its file's."""
    return element.get("name") or Path(element.get("file", "").replace("\\", "/")).stem


def _pairs(tree: Element) -> Iterator[tuple[Element, Element]]:
    for parent in tree.everything():
        for child in parent.children():
            yield parent, child


def weighs(tree: Element, body: Element, geom: Element) -> bool:
    """Return whether a body's mass comes in part from a geom."""
    if body.child("inertial") is not None:
        return False
    compilers = [each for each in tree.everything() if each.tag == "compiler"]
    if any(each.get("inertiafromgeom") == "false" for each in compilers):
        return False
    kind = geom.get("class") or body.get("childclass")
    geoms = [geom]
    for default in tree.everything():
        if default.tag == "default" and default.get("class") == kind:
            geoms += default.children("geom")
    given = [each.get(key, "") for each in geoms for key in ("mass", "density")]
    return not any(word.strip() and float_or(word, 1.0) == 0.0 for word in given)
