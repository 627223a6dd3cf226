"""Wrong case, LFS stub, negative volume, moved origin: what happens to mesh files."""

from __future__ import annotations

import hashlib
from pathlib import PurePosixPath
from typing import Any, ClassVar

import numpy as np

from experiments.plant.defect import Defect, Done, Places, around, mesh_names
from experiments.plant.description import Description, link_in, numbers, text_of
from experiments.plant.errors import there
from experiments.plant.measure import inertial, solid, triangles
from experiments.plant.mesh_file import REWRITABLE, rewrite
from morph.arrays import Array


class OfMesh(Defect):
    """A defect of one link's mesh: its sites are the links with a mesh that is there."""

    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the links that show or touch with a mesh of a file."""
        return [link for link in original.links if self.mesh(original, link)]

    def mesh(self, description: Description, link: str) -> str:
        """Return the path of the link's first mesh that is there, as the URDF gives it."""
        found = (uri for uri in description.meshes(link) if description.file_of(uri))
        return next(found, "")


class WrongCase(OfMesh):
    """A mesh whose path has other capitals than its file: it worked on the author's computer."""

    name: ClassVar[str] = "wrong-case"
    variants: ClassVar[tuple[str, ...]] = ("extension", "stem", "path")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"mesh-case"})

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return that the path has the file's very capitals now."""
        uri = self.mesh(original, site)
        return f"{uri} is there letter for letter" if _other_case(uri, variant) != uri else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Rename the file, or one link's path to it."""
        uri = self.mesh(copy, site)
        file = there(copy.file_of(uri), f"mesh of {site}")
        users = [site] if variant == "path" else copy.users(file)
        places = Places(parts=frozenset(users), meshes=mesh_names([uri]))
        if variant != "path":
            other = PurePosixPath(_other_case(uri, variant)).name
            file.rename(file.with_name(other))
            return Done(did=f"{file.name} renamed to {other}", places=places)
        robot = copy.parse()
        for mesh in link_in(robot, site).iter("mesh"):
            if mesh.get("filename") == uri:
                mesh.set("filename", _other_case(uri, variant))
        copy.write(robot)
        return Done(did=f"{uri} became {_other_case(uri, variant)}", places=places)


class LfsStub(OfMesh):
    """A mesh file as a clone without Git-LFS has it."""

    name: ClassVar[str] = "lfs-stub"
    variants: ClassVar[tuple[str, ...]] = ("pointer",)

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"mesh-lfs-stub"})

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return that the mesh is a real one now."""
        uri = self.mesh(original, site)
        file = original.file_of(uri)
        return f"{uri} has {len(triangles(file).faces)} faces" if file else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Put the pointer in the place of the mesh, by the specification of Git-LFS, version 1.

        Source: github.com/git-lfs/git-lfs, docs/spec.md, "The Pointer".
        """
        uri = self.mesh(copy, site)
        file = there(copy.file_of(uri), f"mesh of {site}")
        users, content = copy.users(file), file.read_bytes()
        file.write_text(
            "version https://git-lfs.github.com/spec/v1\n"
            f"oid sha256:{hashlib.sha256(content).hexdigest()}\nsize {len(content)}\n"
        )
        return Done(
            did=f"{file.name} of {len(content)} bytes became a pointer",
            places=Places(parts=frozenset(users), meshes=mesh_names([uri])),
        )


class NegativeVolume(OfMesh):
    """A closed mesh turned inside out."""

    name: ClassVar[str] = "negative-volume"
    variants: ClassVar[tuple[str, ...]] = ("faces",)

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"mesh-inside-out"})

    def mesh(self, description: Description, link: str) -> str:
        """Return the path of the link's first mesh that can be rewritten."""
        for uri in description.meshes(link):
            file = description.file_of(uri)
            if file and file.suffix.lower() in REWRITABLE:
                return uri
        return ""

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the volume that is positive now, of a mesh that is closed."""
        file = original.file_of(self.mesh(original, site))
        mesh: Any = triangles(file) if file else None
        if mesh is None or not mesh.is_watertight or not mesh.is_winding_consistent:
            return ""
        solid_share = float(mesh.volume) / float(mesh.convex_hull.volume)
        return f"closed, {solid_share:.0%} of its hull" if solid_share > 0.05 else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Turn every face round."""
        uri = self.mesh(copy, site)
        file = there(copy.file_of(uri), f"mesh of {site}")
        users = copy.users(file)
        rewrite(file, lambda mesh: mesh.invert())
        return Done(
            did=f"faces of {file.name} inverted",
            places=Places(parts=frozenset(users), meshes=mesh_names([uri])),
        )


class MovedMeshOrigin(OfMesh):
    """A shape that lies further from its link than the link is large."""

    name: ClassVar[str] = "moved-mesh-origin"
    variants: ClassVar[tuple[str, ...]] = ("all shapes", "collision", "file")

    def codes(self, variant: str) -> frozenset[str]:
        """Return the code that names it."""
        return frozenset({"mesh-moved"})

    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return that the centre of mass lies in the shape now, and how large the shape is."""
        shape, mass = solid(original, site), inertial(original, site)
        if shape is None or mass is None or not shape.size > 0.01:
            return ""
        # A tenth of the size around, for shapes that show less than there is.
        low, high = shape.low - 0.1 * shape.size, shape.high + 0.1 * shape.size
        inside = bool(np.all(mass.centre > low) and np.all(mass.centre < high))
        link = link_in(original.robot, site)
        if variant == "collision" and not (link.findall("visual") and link.findall("collision")):
            return ""
        if variant == "file" and not _only_mesh(original, site):
            return ""
        return f"shape {shape.size:.3f} m across holds the centre of mass" if inside else ""

    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Move the shape 1.5 to 4 times its own size, in a direction drawn at random."""
        shape = there(solid(copy, site), f"shape of {site}")
        direction = rng.normal(size=3)
        away: Array = direction / np.linalg.norm(direction) * shape.size * rng.uniform(1.5, 4.0)
        if variant == "file":
            return _moved_in_file(copy, site, away)
        robot = copy.parse()
        link = link_in(robot, site)
        moved = link.findall("collision")
        moved += link.findall("visual") if variant == "all shapes" else []
        for one in moved:
            origin = one.find("origin")
            if origin is None:
                origin = one.makeelement("origin", {})
                one.insert(0, origin)
            old = numbers(origin, "xyz", "0 0 0")
            origin.set("xyz", text_of(np.add(old, away)))
        copy.write(robot)
        return Done(did=f"{variant} by {text_of(np.round(away, 4))} m", places=around(copy, site))


def _only_mesh(description: Description, link: str) -> str:
    """Return the path of the link's mesh, if it is its only one, and rewritable."""
    uris = description.meshes(link)
    file = description.file_of(uris[0]) if len(uris) == 1 else None
    return uris[0] if file and file.suffix.lower() in REWRITABLE else ""


def _moved_in_file(copy: Description, link: str, away: Array) -> Done:
    uri = _only_mesh(copy, link)
    file = there(copy.file_of(uri), f"only mesh of {link}")
    users = copy.users(file)
    element = next(m for m in link_in(copy.robot, link).iter("mesh"))
    # `away` is in metres; the file may be in other units.
    scale = np.abs(numbers(element, "scale", "1 1 1"))
    rewrite(file, lambda mesh: mesh.apply_translation(away / scale))
    return Done(
        did=f"{file.name} exported {text_of(np.round(away, 4))} m from its origin",
        places=Places(parts=frozenset(users), meshes=mesh_names([uri])),
    )


def _other_case(uri: str, variant: str) -> str:
    """Return a mesh's path with other capitals."""
    path = PurePosixPath(uri)
    if variant == "extension":
        return uri[: -len(path.suffix)] + path.suffix.swapcase()
    name = path.stem.upper() if variant == "path" else path.stem[:1].swapcase() + path.stem[1:]
    return uri[: -len(path.name)] + name + path.suffix
