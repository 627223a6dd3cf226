"""Parts for a printer, as `morph print` makes them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from morph.extras import require

if TYPE_CHECKING:
    from morph.fabrication.content import Package


def print_package(
    robot: str | Path,
    printer: str,
    material: str,
    out: str | Path,
    *,
    policy: str | Path | None = None,
    slicer: Literal["auto", "needed", "none"] = "auto",
    seed: int = 0,
) -> Package:
    """Return the parts of a robot for a printer, with their masses and checks, and write them.

    Args:
        robot: As `morph.load` takes it.
        printer: A name from `morph list printers`.
        material: A name from `morph list materials`.
        out: Folder for plates, parts, the robot as printed and a report.
        policy: Folder of the robot's policy: it is matched to the printed robot.
        slicer: Ask PrusaSlicer if it is there, refuse to go on without it, or estimate.
        seed: Random seed.

    Raises:
        MorphError: An input cannot be used, or the package cannot be written.
    """
    require("print", "morph.print_package")
    from morph.app.cli.print import packaged
    from morph.app.cli.print_arguments import Print

    return packaged(
        Print(
            robot=str(robot),
            printer=printer,
            material=material,
            out=str(out),
            policy=None if policy is None else str(policy),
            slicer=slicer,
            seed=seed,
            quiet=True,
        )
    )
