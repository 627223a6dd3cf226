"""Reading the mesh files that a draft's shapes name; what cannot be read is left out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from morph.body.draft import Draft, DraftLink, Shape
from morph.body.finding import DescriptionFinding, Severity, Where
from morph.body.mesh import Mesh, mesh_content, read_mesh, thinned
from morph.body.mesh.limits import too_large
from morph.body.paths import Files, ResolvedPath
from morph.errors import MeshError

MOST_BYTES = 512 * 2**20
"""Most that all meshes of one description may hold, bytes."""

MOST_FACES = 100_000
"""Most faces of a mesh that is handed on; MuJoCo's reader of STL refuses more than 200 000."""

MOST_TOGETHER, COARSE = 1_500_000, 500
"""Most faces of all meshes together, and of each further mesh once there are so many."""

MOST_DRAWN = 4 * MOST_TOGETHER
"""Most faces of all shapes, a mesh counted as often as it is drawn: MuJoCo holds it once."""


def read_shapes(draft: Draft, files: Files) -> tuple[Draft, list[DescriptionFinding]]:
    """Return the draft with the content of its meshes, and what was found on the way.

    A shape whose file is missing or damaged stays in the draft without a mesh,
    so that checks know of it; the robot is built without it.
    """
    reader = _Reader(draft, files)
    changed = {link.name: reader.link(link) for link in draft.links}
    return draft.with_links(changed), reader.findings


class _Reader:
    """Reads each file once and reports each fault once for each link."""

    def __init__(self, draft: Draft, files: Files) -> None:
        self.draft, self.files = draft, files
        self.findings: list[DescriptionFinding] = []
        self.read: dict[Path, Mesh | MeshError] = {}
        self.thin: set[Path] = set()
        self.coarse: dict[Path, Mesh] = {}
        self.counted: set[int] = set()
        self.bytes = self.faces = self.drawn = 0
        self.told: set[tuple[str, str, str]] = set()

    def link(self, link: DraftLink) -> DraftLink:
        shapes = tuple(
            self.shape(shape, link) if shape.kind == "mesh" and shape.mesh is None else shape
            for shape in link.shapes
        )
        return replace(link, shapes=shapes)

    def shape(self, shape: Shape, link: DraftLink) -> Shape:
        result = self.files.find(shape.file)
        if how := HOW.get(result.how):
            self.tell(link, shape, *how(shape, result, self.files.folder))
        if result.path is None:
            return shape
        if result.path not in self.read:
            self.read[result.path] = self.content(result.path)
        content = self.read[result.path]
        if isinstance(content, MeshError):
            self.tell(
                link,
                shape,
                content.code,
                "repaired",
                f"{result.path.name} {content.what}",
                "the shape was left out",
                content.fix,
            )
            return replace(shape, path=result.path)
        if self.too_many(content) and len(content.faces) > COARSE:
            content = self.coarsened(result.path, content)
            what = f"the shapes up to {result.path.name} have more than {MOST_TOGETHER} faces"
            self.tell(
                *(link, shape, "mesh-too-large", "repaired", what),
                f"{result.path.name} was thinned to {len(content.faces)}",
                "export the meshes coarser",
            )
        elif result.path in self.thin:
            what = f"{result.path.name} has more than {MOST_FACES} faces, which MuJoCo cannot take"
            self.tell(
                *(link, shape, "mesh-too-large", "repaired", what),
                f"it was thinned to {len(content.faces)}",
                "export it coarser",
            )
        self.drawn += len(content.faces)
        # A mesh lives as long as the reader, so that no other has its identity.
        if id(content) not in self.counted:
            self.counted.add(id(content))
            self.faces += len(content.faces)
        return replace(shape, path=result.path, mesh=content)

    def too_many(self, mesh: Mesh) -> bool:
        """Return whether a further shape of this mesh is too much beside all that were read."""
        more = 0 if id(mesh) in self.counted else len(mesh.faces)
        return self.faces + more > MOST_TOGETHER or self.drawn + len(mesh.faces) > MOST_DRAWN

    def coarsened(self, path: Path, mesh: Mesh) -> Mesh:
        if path not in self.coarse:
            self.coarse[path] = thinned(mesh, COARSE)
        return self.coarse[path]

    def content(self, path: Path) -> Mesh | MeshError:
        try:
            content = mesh_content(path)
            self.bytes += len(content)
            if self.bytes > MOST_BYTES:
                what = f"makes the meshes hold more than {MOST_BYTES} bytes"
                raise too_large(what, str(path))
            mesh = read_mesh(content, path.suffix, str(path))
        except MeshError as error:
            return error
        if len(mesh.faces) > MOST_FACES:
            self.thin.add(path)
        # What does not fit beside the others as a whole is thinned once and not twice.
        if self.faces + min(len(mesh.faces), MOST_FACES) > MOST_TOGETHER:
            return mesh
        return thinned(mesh, MOST_FACES)

    def tell(
        self,
        link: DraftLink,
        shape: Shape,
        code: str,
        severity: Severity,
        what: str,
        done: str,
        fix: str,
    ) -> None:
        if (link.name, code, shape.file) in self.told:
            return
        self.told.add((link.name, code, shape.file))
        where = Where(kind="link", name=link.name, file=str(self.draft.file), line=shape.line)
        self.findings.append(
            DescriptionFinding(
                code=code, severity=severity, where=where, what=what, done=done, fix=fix
            )
        )


Said = tuple[str, Severity, str, str, str]


def _missing(shape: Shape, result: ResolvedPath, folder: Path) -> Said:
    return (
        "mesh-missing",
        "repaired",
        f"the mesh {shape.file!r} is nowhere in {folder}",
        "the shape was left out",
        result.fix,
    )


def _outside(shape: Shape, result: ResolvedPath, folder: Path) -> Said:
    return (
        "mesh-outside",
        "repaired",
        f"the mesh {shape.file!r} lies outside {folder}, where nothing is read",
        "the shape was left out",
        result.fix,
    )


def _case(shape: Shape, result: ResolvedPath, folder: Path) -> Said:
    return (
        "mesh-case",
        "repaired",
        f"the mesh {shape.file!r} is there as {_shown(result, folder)!r}",
        "that file was taken",
        "write its name with the same capitals; most systems tell them apart",
    )


def _moved(shape: Shape, result: ResolvedPath, folder: Path) -> Said:
    return (
        "mesh-path",
        "repaired",
        f"the mesh {shape.file!r} is not where its path says, but at {_shown(result, folder)!r}",
        "that file was taken",
        "correct the path",
    )


def _shown(result: ResolvedPath, folder: Path) -> str:
    return "" if result.path is None else str(result.path.relative_to(folder))


HOW: dict[str, Callable[[Shape, ResolvedPath, Path], Said]] = {
    "missing": _missing,
    "outside": _outside,
    "case": _case,
    "moved": _moved,
}
"""What to say of each way in which a path is not what it should be."""
