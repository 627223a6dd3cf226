"""Writing an alignment; `align.json` comes last, and makes it whole."""

from __future__ import annotations

from pathlib import Path

from morph.app.report.align.outcome import MAP, Aligned
from morph.app.report.align.page import align_page
from morph.files import write_whole
from morph.policy_transfer.hop_checkpoint import write_map

RECORD, REPORT = "align.json", "report.html"
"""What an alignment writes beside its map."""


def write_align(result: Aligned, out: Path) -> None:
    """Write the map, the report and the record.

    Raises:
        OutputError: The folder cannot be written to.
    """
    # Made before anything is written: what fails here leaves nothing behind.
    page, text = align_page(result), result.text()
    write_map(out / MAP, result.map)
    write_whole(out / REPORT, page)
    write_whole(out / RECORD, text)
