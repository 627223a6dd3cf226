"""From what `package.json` holds to a package, each number looked at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from morph.arrays import Array
from morph.body.inertia import is_physical
from morph.errors import MakeError
from morph.fabrication.content import Package
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.packed import Packed, PackedLink, PackedPart, PrintedCopy, Spread
from morph.print.job import Job, Laid, Orientation, Plate
from morph.print.mesh import Mesh
from morph.print.part import Check, Hinge, Part, Placement, Seat
from morph.print.sliced import Sliced
from morph.print.weight import Weight


def unpacked(packed: Packed, folder: Path, mesh_of: Callable[[PackedPart], Mesh | None]) -> Package:
    """Return the package that a `package.json` describes.

    Args:
        packed: Its content.
        folder: Where it lies.
        mesh_of: Gives a part's solid in the part's own frame.

    Raises:
        MakeError: A number in it is none, or a matrix is no pose.
    """
    reader = _Reader(where=str(folder / "package.json"))
    every = [*packed.parts, *packed.gauges]
    parts = {each.name: reader.part(each, mesh_of(each)) for each in every}
    if len(parts) < len(every):
        raise reader.wrong("two parts have the same name")
    printed = [each for each in every if each.printed is not None]
    job = Job(
        profile=packed.profile,
        parts=tuple(parts[each.name] for each in packed.parts if each.name not in packed.refused),
        refused=tuple(parts[each.name] for each in packed.parts if each.name in packed.refused),
        checks=tuple(_check(each) for each in packed.checks),
        orientations={
            each.name: reader.orientation(each.printed) for each in printed if each.printed
        },
        sliced={each.name: reader.sliced(each) for each in printed},
        plates=tuple(reader.plate(each) for each in packed.plates),
        gauges=tuple(parts[each.name] for each in packed.gauges),
        notes=(),
    )
    return Package(
        name=packed.name,
        title=packed.title,
        designed_sha256=packed.designed_sha256,
        made_sha256=packed.made_sha256,
        job=job,
        links=tuple(reader.link(each) for each in packed.links),
        hinges=tuple(reader.hinge(each) for each in packed.hinges),
        complete=frozenset(packed.complete),
        readings={
            each.name: 1e-3 * each.measured_g for each in every if each.measured_g is not None
        },
        policy=packed.policy,
        notes=packed.notes,
        command=packed.command,
        folder=folder,
    )


class _Reader:
    """Turns rows of numbers into matrices, and names what is wrong."""

    def __init__(self, where: str) -> None:
        self.where = where

    def wrong(self, what: str) -> MakeError:
        return MakeError(what, where=self.where, fix="make the package anew with `morph print`")

    def matrix(self, values: Sequence[float], *shape: int) -> Array:
        result = np.array(values, dtype=np.float64)
        if result.size != np.prod(shape) or not np.isfinite(result).all():
            raise self.wrong(
                f"{result.size} numbers stand where {np.prod(shape)} finite ones belong"
            )
        return result.reshape(shape)

    def turn(self, values: Sequence[float]) -> Array:
        result = self.matrix(values, 3, 3)
        # 1e-6 is far above the rounding of a product of turns, and far below a scale.
        if np.abs(result @ result.T - np.eye(3)).max() > 1e-6:
            raise self.wrong("a matrix that should turn also stretches")
        return result

    def pose(self, values: Sequence[float]) -> Array:
        result = self.matrix(values, 4, 4)
        self.turn(result[:3, :3].ravel().tolist())
        return result

    def weight(self, packed: Spread) -> Weight:
        xx, yy, zz, xy, xz, yz = self.matrix(packed.inertia_kgm2, 6)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        com = self.matrix(packed.com_m, 3)
        if not 0 <= packed.mass_kg < np.inf or (inertia.any() and not is_physical(inertia)):
            raise self.wrong(f"a mass of {packed.mass_kg:g} kg has an inertia that no body has")
        return Weight(mass=packed.mass_kg, com=com, inertia=inertia)

    def part(self, packed: PackedPart, mesh: Mesh | None) -> Part:
        if packed.kind not in ("printed", "bought", "fused") or packed.hand not in (
            "",
            "left",
            "right",
        ):
            raise self.wrong(f"the part {packed.name!r} is {packed.kind!r} and {packed.hand!r}")
        return Part(
            name=packed.name,
            kind=cast(Any, packed.kind),
            mesh=mesh,
            placements=tuple(
                Placement(link=at.link, pose=self.pose(at.pose_mm), world=self.pose(at.world_mm))
                for at in packed.copies
            ),
            hand=cast(Any, packed.hand),
            seats=tuple(
                Seat(
                    holds=seat.holds,
                    position=self.matrix(seat.position_mm, 3),
                    axis=self.matrix(seat.axis, 3),
                    bore_mm=seat.bore_mm,
                )
                for seat in packed.holds
            ),
            weight=None if packed.weight is None else self.weight(packed.weight),
            into=packed.into,
            number=packed.number,
            piece_of=packed.piece_of,
        )

    def orientation(self, packed: PrintedCopy) -> Orientation:
        return Orientation(
            turn=self.turn(packed.turn),
            support_mm3=packed.support_mm3,
            first_support_mm3=packed.first_support_mm3,
            height_mm=packed.height_mm,
        )

    def sliced(self, packed: PackedPart) -> Sliced:
        printed = packed.printed
        if printed is None or packed.weight is None or printed.source not in ("gcode", "estimate"):
            raise self.wrong(f"the printed part {packed.name!r} has no weight, or one from nowhere")
        return Sliced(
            source=cast(Any, printed.source),
            weight=self.weight(packed.weight),
            support_kg=printed.support_kg,
            seconds=printed.seconds,
            by_feature={each.name: each.mass_kg for each in printed.features},
            warnings=printed.warnings,
            slicer=printed.slicer,
        )

    def plate(self, document: Any) -> Plate:
        laid = tuple(
            Laid(part=each.part, copy=each.copy, pose=self.pose(each.pose_mm))
            for each in document.laid
        )
        return Plate(name=document.name, laid=laid)

    def link(self, packed: PackedLink) -> LinkMass:
        if packed.source not in ("description", "estimate", "gcode", "scale"):
            raise self.wrong(f"the mass of {packed.link!r} comes from {packed.source!r}")
        return LinkMass(
            link=packed.link,
            designed=self.weight(packed.designed),
            predicted=None if packed.predicted is None else self.weight(packed.predicted),
            measured=None if packed.measured is None else self.weight(packed.measured),
            source=cast(Any, packed.source),
        )

    def hinge(self, document: Any) -> Hinge:
        return Hinge(
            name=document.name,
            kind=document.kind,
            position=self.matrix(document.position_mm, 3),
            axis=self.matrix(document.axis, 3),
            low=document.low,
            high=document.high,
            still=document.still,
            moving=document.moving,
        )


def _check(document: Any) -> Check:
    return Check(**vars(document))
