"""From a package to what `package.json` holds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import morph
from morph.arrays import Array
from morph.fabrication.content import Package
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.packed import (
    SCHEMA,
    Copy,
    Feature,
    Held,
    Packed,
    PackedCheck,
    PackedHinge,
    PackedLaid,
    PackedLink,
    PackedPart,
    PackedPlate,
    PrintedCopy,
    Spread,
)
from morph.print.job import Job, Plate
from morph.print.part import Check, Hinge, Part
from morph.print.weight import Weight


def packed(package: Package, files: Mapping[str, str]) -> Packed:
    """Return what `package.json` is to hold.

    Args:
        package: The package.
        files: For each part and plate, by its name, its file in the package; for the G-code
            of a plate, the plate's name with `.gcode`.
    """
    job = package.job
    return Packed(
        schema=SCHEMA,
        morph=morph.__version__,
        name=package.name,
        title=package.title,
        designed_sha256=package.designed_sha256,
        made_sha256=package.made_sha256,
        profile=job.profile,
        parts=tuple(_part(part, package, files) for part in (*job.parts, *job.refused)),
        gauges=tuple(_part(part, package, files) for part in job.gauges),
        refused=tuple(part.name for part in job.refused),
        checks=tuple(map(_check, job.checks)),
        plates=tuple(_plate(plate, files) for plate in job.plates),
        links=tuple(map(_link, package.links)),
        complete=tuple(sorted(package.complete)),
        hinges=tuple(map(_hinge, package.hinges)),
        policy=package.policy,
        notes=(*package.notes, *job.notes),
        command=package.command,
    )


def row(values: Array | Sequence[float]) -> tuple[float, ...]:
    """Return the numbers of an array, row by row."""
    import numpy as np

    return tuple(float(value) for value in np.asarray(values, dtype=np.float64).ravel())


def spread(weight: Weight) -> Spread:
    """Return a weight as the numbers that are written."""
    i = weight.inertia
    return Spread(
        mass_kg=float(weight.mass),
        com_m=row(weight.com),
        inertia_kgm2=row([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]),
    )


def _part(part: Part, package: Package, files: Mapping[str, str]) -> PackedPart:
    reading = package.readings.get(part.name)
    return PackedPart(
        number=part.number,
        name=part.name,
        kind=part.kind,
        hand=part.hand,
        file=files.get(part.name, ""),
        piece_of=part.piece_of,
        into=part.into,
        copies=tuple(
            Copy(link=at.link, pose_mm=row(at.pose), world_mm=row(at.world))
            for at in part.placements
        ),
        holds=tuple(
            Held(
                holds=seat.holds,
                position_mm=row(seat.position),
                axis=row(seat.axis),
                bore_mm=float(seat.bore_mm),
            )
            for seat in part.seats
        ),
        weight=None if part.weight is None else spread(part.weight),
        printed=_printed(part.name, package.job),
        measured_g=None if reading is None else 1e3 * reading,
    )


def _printed(name: str, job: Job) -> PrintedCopy | None:
    if name not in job.sliced:
        return None
    sliced, lies = job.sliced[name], job.orientations[name]
    return PrintedCopy(
        source=sliced.source,
        slicer=sliced.slicer,
        turn=row(lies.turn),
        support_mm3=float(lies.support_mm3),
        first_support_mm3=float(lies.first_support_mm3),
        height_mm=float(lies.height_mm),
        support_kg=float(sliced.support_kg),
        seconds=float(sliced.seconds),
        features=tuple(
            Feature(name=feature, mass_kg=float(mass))
            for feature, mass in sliced.by_feature.items()
        ),
        warnings=sliced.warnings,
    )


def _check(check: Check) -> PackedCheck:
    return PackedCheck(
        part=check.part,
        name=check.name,
        verdict=check.verdict,
        what=check.what,
        fix=check.fix,
        value=_finite(check.value),
        limit=_finite(check.limit),
    )


def _finite(value: Any) -> float | None:
    """Return a number that JSON can hold, or None."""
    return None if value is None or not math.isfinite(value) else float(value)


def _plate(plate: Plate, files: Mapping[str, str]) -> PackedPlate:
    return PackedPlate(
        name=plate.name,
        file=files.get(plate.name, ""),
        gcode=files.get(f"{plate.name}.gcode", ""),
        laid=tuple(
            PackedLaid(part=laid.part, copy=laid.copy, pose_mm=row(laid.pose))
            for laid in plate.laid
        ),
    )


def _link(mass: LinkMass) -> PackedLink:
    return PackedLink(
        link=mass.link,
        source=mass.source,
        designed=spread(mass.designed),
        predicted=None if mass.predicted is None else spread(mass.predicted),
        measured=None if mass.measured is None else spread(mass.measured),
    )


def _hinge(hinge: Hinge) -> PackedHinge:
    return PackedHinge(
        name=hinge.name,
        kind=hinge.kind,
        position_mm=row(hinge.position),
        axis=row(hinge.axis),
        low=float(hinge.low),
        high=float(hinge.high),
        still=hinge.still,
        moving=hinge.moving,
    )
