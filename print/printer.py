"""Printers, materials and the settings of a print, by name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

from morph.print.errors import ProfileError


@dataclass(frozen=True, kw_only=True)
class Printer:
    """A machine that lays down melted plastic."""

    name: str
    """What users call it."""
    title: str
    """Its maker's name for it."""
    bed_mm: tuple[float, float, float]
    """Width, depth and height that it can print."""
    nozzle_mm: float = 0.4
    """Bore of its nozzle."""
    filament_mm: float = 1.75
    """Diameter of the filament."""
    retract_mm: float = 0.8
    """Filament drawn back before a move without printing; more where a tube leads it."""
    level: str = ""
    """Its command that probes the bed after homing; empty for one that is levelled by hand."""


@dataclass(frozen=True, kw_only=True)
class Material:
    """A plastic."""

    name: str
    """What users call it."""
    density: float
    """kg/m3."""
    nozzle_c: int
    """Temperature of the nozzle, deg C."""
    bed_c: int
    """Temperature of the bed, deg C."""
    fan_percent: int = 100
    """How fast the fan turns that cools what was printed."""


PRINTERS = (
    # Beds, and the command that probes them, as in OrcaSlicer's profiles of these machines
    # (github.com/SoftFever/OrcaSlicer, resources/profiles: MK4, Ender-3 V2 and A1 read there);
    # the MINI's and the Ender's height and the A1's G29 from memory, not checked.
    Printer(name="mk4", title="Prusa MK4", bed_mm=(250.0, 210.0, 220.0), level="G29"),
    Printer(
        name="mini",
        title="Prusa MINI+",
        bed_mm=(180.0, 180.0, 180.0),
        retract_mm=3.2,
        level="G29",
    ),
    Printer(
        name="ender3", title="Creality Ender-3 V2", bed_mm=(220.0, 220.0, 250.0), retract_mm=5.0
    ),
    Printer(name="a1", title="Bambu Lab A1", bed_mm=(256.0, 256.0, 256.0), level="G29"),
)
"""Every printer known by name."""

MATERIALS = (
    # PLA 1.22 to 1.26, PETG 1.25 to 1.29 g/cm3 (additive.tools/materials); PETG and ASA as in
    # the profiles that slicers ship. A roll differs by a per cent or two: a scale settles it.
    Material(name="pla", density=1240.0, nozzle_c=215, bed_c=60),
    Material(name="petg", density=1270.0, nozzle_c=240, bed_c=85, fan_percent=50),
    Material(name="asa", density=1070.0, nozzle_c=260, bed_c=105, fan_percent=15),
)
"""Every material known by name."""


@dataclass(frozen=True, kw_only=True)
class Profile:
    """How a part is printed: what PrusaSlicer is told and what the estimator assumes."""

    printer: Printer
    """The machine."""
    material: Material
    """The plastic."""
    layer_mm: float = 0.2
    """Height of a layer."""
    line_mm: float = 0.45
    """Width of a line."""
    walls: int = 2
    """Lines around each layer."""
    solid_layers: tuple[int, int] = (5, 4)
    """Solid layers on top and at the bottom."""
    infill: float = 0.15
    """Part of the inside that is filled, 0 to 1."""
    overhang_deg: float = 50.0
    """Faces that lean further than this from upright are supported."""
    clearance_mm: float = 0.2
    """Play on each side between what is to go together; a gauge measures it."""

    def __post_init__(self) -> None:
        """Check every number against what a printer of this nozzle can do."""
        nozzle = self.printer.nozzle_mm
        for name, low, high in (
            ("layer_mm", 0.04, 0.8 * nozzle),
            ("line_mm", 0.8 * nozzle, 2.0 * nozzle),
            ("walls", 1, 20),
            ("infill", 0.0, 1.0),
            ("overhang_deg", 0.0, 90.0),
            ("clearance_mm", 0.0, 2.0),
        ):
            value = getattr(self, name)
            # A comparison with NaN is false, so this also finds what is not a number.
            if not low <= value <= high:
                raise ProfileError(
                    f"{name} is {value:g}, not from {low:g} to {high:g}",
                    where=f"the profile of {self.printer.name} and {self.material.name}",
                    fix=f"give {name} a value within these bounds",
                )
        if not all(0 <= layers <= 1000 for layers in self.solid_layers):
            raise ProfileError(
                f"there are {self.solid_layers} solid layers",
                where=f"the profile of {self.printer.name} and {self.material.name}",
                fix="give solid_layers two counts from 0 to 1000",
            )

    @property
    def thinnest_mm(self) -> float:
        """Least wall that prints as two lines, mm."""
        return 2.0 * self.line_mm


Named = TypeVar("Named", Printer, Material)


def printer(name: str) -> Printer:
    """Return a printer by its name.

    Raises:
        ProfileError: There is no such printer.
    """
    return _named(name, PRINTERS, "printer")


def material(name: str) -> Material:
    """Return a material by its name.

    Raises:
        ProfileError: There is no such material.
    """
    return _named(name, MATERIALS, "material")


def _named(name: str, known: Iterable[Named], kind: str) -> Named:
    by_name = {each.name: each for each in known}
    if name.lower() in by_name:
        return by_name[name.lower()]
    near = difflib.get_close_matches(name.lower()[:100], by_name, n=3, cutoff=0.4) or by_name
    raise ProfileError(
        f"no {kind} is called {name[:100]!r}; there are {', '.join(by_name)}",
        where=f"--{kind}",
        fix=f"name one of these, such as {next(iter(near))}",
    )
