"""Reading the geometry of 3MF."""

from __future__ import annotations

import io
import posixpath
import zipfile
import zlib
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from xml.parsers import expat

import numpy as np

from morph.arrays import Array
from morph.body.mesh.gather import Gathering
from morph.body.mesh.limits import FACES, LARGEST, too_large, unreadable
from morph.body.mesh.numbers import floats
from morph.body.mesh.solid import Mesh

UNITS = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
"""Metres in each unit that a model may be in."""

ENTRIES = 10_000
"""Most files in the archive; Python's list of them takes half a kilobyte each."""

FREE, RATIO = 8 * 2**20, 50
"""Bytes to which any file may unpack, and how many times its own size beyond that: what CAD writes
packs to a tenth."""

ENTRY = b"PK\x01\x02"
"""How the entry of a file in an archive's list begins."""


@dataclass
class _Object:
    corners: array[float] = field(default_factory=lambda: array("d"))
    triangles: array[int] = field(default_factory=lambda: array("q"))
    parts: list[tuple[str, str, Array]] = field(default_factory=list)
    """Path of the model, id of the object, and place of each part."""


def read_3mf(content: bytes, where: str) -> Mesh:
    """Return what a 3MF file puts on the plate, as one mesh, in metres.

    Source: 3MF Core Specification 1.3, and the paths of its Production Extension.

    Raises:
        MeshError: It is no 3MF, unpacks to more than 64 MiB or than 50 times its size, or
            refers to what it does not hold.
    """
    if content.count(ENTRY) > ENTRIES:
        raise too_large(f"holds more than the {ENTRIES} files allowed", where)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            most = min(LARGEST, FREE + RATIO * len(content))
            return _Package(archive, where, most).mesh()
    except expat.ExpatError as error:
        raise unreadable(f"its model is not XML: {error}", where) from error
    except (
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,  # A compression that Python does not know.
        RuntimeError,  # A password.
        EOFError,
        OSError,
        ValueError,
        KeyError,
        IndexError,
        OverflowError,
    ) as error:
        raise unreadable(f"cannot be read as 3MF: {error!r}", where) from error


class _Package:
    """The models in an archive, each read once, and what they put on the plate."""

    def __init__(self, archive: zipfile.ZipFile, where: str, most: int) -> None:
        self.archive, self.where, self.most = archive, where, most
        self.unpacked = 0
        self.models: dict[str, _Model] = {}
        self.gathering = Gathering(where)

    def mesh(self) -> Mesh:
        start = self._start()
        model = self._model(start)
        place = np.diag((*[UNITS[model.unit]] * 3, 1.0))
        for path, name, own in model.items:
            self._show(path or start, name, place @ own, 0)
        return self.gathering.mesh()

    def _start(self) -> str:
        results: list[str] = []

        def start(tag: str, attributes: dict[str, str]) -> None:
            if tag == "Relationship" and attributes["Type"].endswith("/3dmodel"):
                results.append(attributes["Target"])

        _parse(self._content("_rels/.rels"), start)
        return results[0]

    def _content(self, path: str) -> bytes:
        info = self.archive.getinfo(posixpath.normpath(path).lstrip("/"))
        self.unpacked += info.file_size
        if self.unpacked > self.most:
            raise too_large(f"unpacks to more than the {self.most} bytes allowed", self.where)
        # Never more than the archive's list says, whatever the stream holds.
        with self.archive.open(info) as file:
            return file.read(info.file_size)

    def _model(self, path: str) -> _Model:
        if path not in self.models:
            self.models[path] = _Model(self._content(path), self.where)
        return self.models[path]

    def _show(self, path: str, name: str, place: Array, depth: int) -> None:
        self.gathering.enter(depth)
        shown = self._model(path).objects[name]
        if shown.triangles:
            corners = np.array(shown.corners, dtype=np.float64).reshape(-1, 3)
            faces = np.array(shown.triangles, dtype=np.int64).reshape(-1, 3)
            self.gathering.add(corners, faces, place)
        for part, inner, own in shown.parts:
            self._show(part or path, inner, place @ own, depth + 1)


class _Model:
    """The objects and the items of one model part."""

    def __init__(self, content: bytes, where: str) -> None:
        if content.count(b"<triangle ") > FACES:
            raise too_large(f"has more than the {FACES} faces allowed", where)
        self.unit = "millimeter"
        self.objects: dict[str, _Object] = {}
        self.items: list[tuple[str, str, Array]] = []
        self.current = _Object()
        _parse(content, self._start)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        tag = tag.rpartition(":")[2]
        if tag == "vertex":
            x, y, z = (float(attributes[axis]) for axis in "xyz")
            self.current.corners.extend((x, y, z))
        elif tag == "triangle":
            a, b, c = (int(attributes[corner]) for corner in ("v1", "v2", "v3"))
            self.current.triangles.extend((a, b, c))
        elif tag == "object":
            self.current = self.objects[attributes["id"]] = _Object()
        elif tag in ("component", "item"):
            listed = self.items if tag == "item" else self.current.parts
            path = next((attributes[key] for key in attributes if key.endswith(":path")), "")
            listed.append((path, attributes["objectid"], _place(attributes.get("transform"))))
        elif tag == "model":
            self.unit = attributes.get("unit", self.unit)


def _place(text: str | None) -> Array:
    # Twelve numbers, the columns of the matrix one after another: x' = R x + t.
    place = np.eye(4)
    if text:
        place[:3] = floats(text).reshape(4, 3).T
    return place


def _parse(content: bytes, start: Callable[[str, dict[str, str]], None]) -> None:
    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.StartDoctypeDeclHandler = _refuse
    parser.Parse(content, True)


def _refuse(*_: object) -> None:
    raise ValueError("its model has a document type, through which entities could come")
