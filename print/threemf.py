"""A plate as a 3MF file: what is on it, where, under which names and part numbers."""

from __future__ import annotations

import os
import re
import tempfile
import uuid
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.errors import PlateError
from morph.print.job import Plate
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.threemf_read import read_3mf as read_3mf
from morph.print.threemf_read import told

KNOWN = frozenset(
    [
        "Title",
        "Designer",
        "Description",
        "Copyright",
        "LicenseTerms",
        "Rating",
        "CreationDate",
        "ModificationDate",
        "Application",
    ]
)
"""Names of metadata that need no namespace; source: 3MF core specification 1.3, section 3.4.1."""

ILLEGAL = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 holds to be no character (section 2.2)."""

OURS = "urn:morph:print:1"
"""The namespace of every other name."""

COLOURS = ("4E79A7", "F28E2B", "59A14F", "E15759", "B07AA1", "76B7B2", "EDC948", "9C755F")
"""One part after the other, red, green and blue; source: Tableau 10, without pink and grey."""


def write_3mf(
    path: Path, plate: Plate, parts: Sequence[Part], *, metadata: Mapping[str, str]
) -> Path:
    """Write a plate under a temporary name beside it, then rename it into place.

    Args:
        path: The file.
        plate: What lies where.
        parts: At least the parts that lie on it.
        metadata: What it says of itself; names that 3MF does not know are put in our namespace.

    Returns:
        The path written.

    Raises:
        PlateError: The file cannot be written, or a part on the plate is missing.
    """
    content = bytes_3mf(plate, parts, metadata=metadata)
    temporary: str | None = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except OSError as error:
        raise PlateError(
            f"cannot write: {error.strerror or error}",
            where=str(path),
            fix="choose a folder that exists, can be written to and has room",
        ) from error
    finally:
        if temporary is not None and os.path.exists(temporary):
            os.unlink(temporary)
    return path


def bytes_3mf(plate: Plate, parts: Sequence[Part], *, metadata: Mapping[str, str]) -> bytes:
    """Return what `write_3mf` writes.

    Raises:
        PlateError: A part on the plate is missing or has no mesh, or lib3mf refuses it.
    """
    import lib3mf

    with told(f"plate {plate.name}"):
        wrapper = lib3mf.get_wrapper()
        model = wrapper.CreateModel()
        model.SetUnit(lib3mf.ModelUnit.MilliMeter)
        about = model.GetMetaDataGroup()
        for key, text in metadata.items():
            _check(key, text, f"plate {plate.name}")
            about.AddMetaData("" if key in KNOWN else OURS, key, text, "xs:string", True)
        _fill(lib3mf, wrapper, model, plate, {part.name: part for part in parts})
        model.SetBuildUUID(_same(plate.name))
        writer = model.QueryWriter("3mf")
        writer.SetStrictModeActive(True)
        writer.SetDecimalPrecision(6)
        return bytes(writer.WriteToBuffer())


def _fill(lib3mf: Any, wrapper: Any, model: Any, plate: Plate, by_name: Mapping[str, Part]) -> None:
    """Add one object for each part and one item for each copy."""
    colours = model.AddBaseMaterialGroup()
    objects: dict[str, Any] = {}
    for laid in plate.laid:
        if laid.part not in objects:
            part = by_name.get(laid.part)
            if part is None or part.mesh is None:
                raise PlateError(
                    f"part {laid.part!r} is laid here, and has no mesh",
                    where=f"plate {plate.name}",
                    fix="hand over the parts that were laid",
                )
            made = model.AddMeshObject()
            made.SetName(part.name)
            made.SetPartNumber(part.number)
            made.SetUUID(_same(plate.name, part.name))
            made.SetGeometry(*_geometry(lib3mf, part.mesh))
            red, green, blue = bytes.fromhex(COLOURS[len(objects) % len(COLOURS)])
            colour = colours.AddMaterial(part.name, wrapper.RGBAToColor(red, green, blue, 255))
            made.SetObjectLevelProperty(colours.GetResourceID(), colour)
            objects[laid.part] = made
        item = model.AddBuildItem(objects[laid.part], _transform(lib3mf, laid.pose))
        item.SetPartNumber(f"{by_name[laid.part].number or laid.part}/{laid.copy + 1}")
        item.SetUUID(_same(plate.name, laid.part, str(laid.copy)))


def _same(*names: str) -> str:
    """Return an identifier that is the same every time, so that equal plates are equal files."""
    return str(uuid.uuid5(uuid.NAMESPACE_URL, "/".join((OURS, *names))))


def _check(key: str, text: str, where: str) -> None:
    """Refuse what XML cannot hold; lib3mf would write it and could not read it.

    Raises:
        PlateError: The key is no name, or a character of the text is none of XML's.
    """
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_.-]*", key) or ILLEGAL.search(text):
        raise PlateError(
            f"metadata {key[:60]!r} = {text[:60]!r} cannot stand in a 3MF file",
            where=where,
            fix="name it by letters, digits and underscores, and use no control characters",
        )


def _geometry(lib3mf: Any, mesh: Mesh) -> tuple[Any, Any]:
    """Return corners and triangles as lib3mf takes them."""
    corners = np.ascontiguousarray(mesh.vertices, dtype=np.float32)
    faces = np.ascontiguousarray(mesh.faces, dtype=np.uint32)
    return (
        (lib3mf.Position * len(corners)).from_buffer_copy(corners),
        (lib3mf.Triangle * len(faces)).from_buffer_copy(faces),
    )


def _transform(lib3mf: Any, pose: Array) -> Any:
    """Return a pose as lib3mf takes it: four columns, each of three coordinates."""
    columns = np.ascontiguousarray(pose[:3].T, dtype=np.float32)
    return lib3mf.Transform.from_buffer_copy(columns)
