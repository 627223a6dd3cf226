"""A package as `package.json` holds it: the schema morph.package/1, field by field."""

from __future__ import annotations

from dataclasses import dataclass

from morph.print.printer import Profile

SCHEMA = "morph.package/1"
"""Name and version of `package.json`."""

FILE = "package.json"
"""Its name; it makes a folder a package."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A mass and how it is spread."""

    mass_kg: float
    """Mass, kg."""
    com_m: tuple[float, ...]
    """Centre of mass, m."""
    inertia_kgm2: tuple[float, ...]
    """About the centre of mass, kg m2: xx, yy, zz, xy, xz, yz."""


@dataclass(frozen=True, kw_only=True)
class Copy:
    """Where one copy of a part sits."""

    link: str
    """The link that carries it."""
    pose_mm: tuple[float, ...]
    """From the part's frame to the link's: a 4 by 4 matrix, row by row, mm."""
    world_mm: tuple[float, ...]
    """The same to the world's with all joints at zero."""


@dataclass(frozen=True, kw_only=True)
class Held:
    """What a part holds, and where."""

    holds: str
    """A servo, a horn, a bearing or a screw."""
    position_mm: tuple[float, ...]
    """Its origin in the part's frame."""
    axis: tuple[float, ...]
    """Its axis, out of the part."""
    bore_mm: float
    """Diameter of the hole; 0 where there is none."""


@dataclass(frozen=True, kw_only=True)
class Feature:
    """How much of one type of line there is."""

    name: str
    """The slicer's name for it."""
    mass_kg: float
    """Its mass, kg."""


@dataclass(frozen=True, kw_only=True)
class PrintedCopy:
    """How one copy of a part is printed."""

    source: str
    """`gcode` or `estimate`."""
    slicer: str
    """Name and version of the slicer; empty for an estimate."""
    turn: tuple[float, ...]
    """Rotation from the part's frame to the bed's: a 3 by 3 matrix, row by row."""
    support_mm3: float
    """Volume under faces that need support, as it lies."""
    first_support_mm3: float
    """The same as it was drawn."""
    height_mm: float
    """How high it stands."""
    support_kg: float
    """Plastic that is thrown away, kg."""
    seconds: float
    """How long it takes."""
    features: tuple[Feature, ...] = ()
    """Mass of each type of line."""
    warnings: tuple[str, ...] = ()
    """What the slicer warned of."""


@dataclass(frozen=True, kw_only=True)
class PackedPart:
    """One part."""

    number: str
    """Its number, such as `P-03`."""
    name: str
    """Its name."""
    kind: str
    """`printed`, `bought` or `fused`."""
    hand: str = ""
    """`left` or `right` where there is a mirrored twin."""
    file: str = ""
    """Its STL in the package, lying as it is printed; empty of what has no shape."""
    piece_of: str = ""
    """The part that was too large for the bed."""
    into: str = ""
    """The part into which it is fused."""
    copies: tuple[Copy, ...] = ()
    """Where each copy sits."""
    holds: tuple[Held, ...] = ()
    """What is held in it."""
    weight: Spread | None = None
    """Of one copy in the part's frame, as predicted; of what is bought, as its maker says."""
    printed: PrintedCopy | None = None
    """How it is printed; None of what is not."""
    measured_g: float | None = None
    """What a scale showed for one copy, g."""


@dataclass(frozen=True, kw_only=True)
class PackedCheck:
    """One thing that was looked at."""

    part: str
    name: str
    verdict: str
    what: str
    fix: str = ""
    value: float | None = None
    limit: float | None = None


@dataclass(frozen=True, kw_only=True)
class PackedLaid:
    """One copy of a part on a plate."""

    part: str
    """The part's name."""
    copy: int
    """Which of its copies, from 0."""
    pose_mm: tuple[float, ...]
    """From the part's frame to the plate's: a 4 by 4 matrix, row by row, mm."""


@dataclass(frozen=True, kw_only=True)
class PackedPlate:
    """What is printed at once."""

    name: str
    """Such as `plate_1`."""
    file: str
    """Its 3MF in the package."""
    gcode: str = ""
    """Its G-code in the package; empty where no slicer was asked."""
    laid: tuple[PackedLaid, ...] = ()
    """Everything on it."""


@dataclass(frozen=True, kw_only=True)
class PackedLink:
    """What one link weighs."""

    link: str
    """The link."""
    source: str
    """Where its mass now comes from: `description`, `estimate`, `gcode` or `scale`."""
    designed: Spread
    """By the description."""
    predicted: Spread | None = None
    """By its parts."""
    measured: Spread | None = None
    """By the scale."""


@dataclass(frozen=True, kw_only=True)
class PackedHinge:
    """A joint between two links."""

    name: str
    kind: str
    position_mm: tuple[float, ...]
    axis: tuple[float, ...]
    low: float
    high: float
    still: str
    moving: str


@dataclass(frozen=True, kw_only=True)
class PackedPolicy:
    """The policy that came with the package."""

    task: str
    """What it is for."""
    verdict: str
    """`holds`, `matched` or `lost`."""
    what: str
    """What was measured, in words."""
    sha256: str = ""
    """Hash of its numbers."""


@dataclass(frozen=True, kw_only=True)
class Packed:
    """All of `package.json`."""

    schema: str
    """`morph.package/1`."""
    morph: str
    """Version of morph."""
    name: str
    """The robot."""
    title: str
    """What to call it in a heading."""
    designed_sha256: str
    """Hash of the robot as designed."""
    made_sha256: str
    """Hash of the robot as it comes off the printer: that of `robot/robot.xml`."""
    profile: Profile
    """Printer, material and settings."""
    parts: tuple[PackedPart, ...]
    """Printed, bought and fused."""
    gauges: tuple[PackedPart, ...] = ()
    """What to print first."""
    refused: tuple[str, ...] = ()
    """Names of parts that cannot be printed; their checks say why."""
    checks: tuple[PackedCheck, ...] = ()
    """Everything that was looked at."""
    plates: tuple[PackedPlate, ...] = ()
    """What is printed at once."""
    links: tuple[PackedLink, ...] = ()
    """What each link weighs."""
    complete: tuple[str, ...] = ()
    """Links of which everything that weighs is a part."""
    hinges: tuple[PackedHinge, ...] = ()
    """How the links move."""
    policy: PackedPolicy | None = None
    """The policy; None if none was given."""
    notes: tuple[str, ...] = ()
    """What a reader should know."""
    command: str = ""
    """The command that made it."""
