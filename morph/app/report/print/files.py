"""The pages of a package: the report, and the sheet to assemble by."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from morph.app.report.print.page import print_page
from morph.fabrication.content import Package
from morph.fabrication.margins import Margin
from morph.files import write_whole
from morph.print.sheet import sheet

REPORT, ASSEMBLY = "report.html", "assembly.html"
"""Their names in the package."""


def write_pages(folder: Path, package: Package, margins: Sequence[Margin] = ()) -> None:
    """Write the report and the assembly sheet.

    Raises:
        OutputError: The folder cannot be written to.
    """
    sliced = {path.stem for path in (folder / "plates").glob("*.gcode")}
    write_whole(folder / REPORT, print_page(package, margins, sliced))
    page = sheet(package.job, package.hinges, title=package.title, command=package.command)
    write_whole(folder / ASSEMBLY, page)
