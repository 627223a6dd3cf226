"""The bill of materials as a table of text: what is printed, bought and screwed together."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from morph.print.fasteners import fasteners
from morph.print.job import Job
from morph.print.part import Part

COLUMNS = (
    "number",
    "name",
    "kind",
    "hand",
    "count",
    "material",
    "grams_each",
    "links",
    "file",
    "note",
)
"""Heads of the columns."""

DANGEROUS = ("=", "+", "-", "@", "\t", "\r", "\n")
"""What a spreadsheet takes for the beginning of a formula.

Source: OWASP, CSV Injection, owasp.org/www-community/attacks/CSV_Injection.
"""


def bill(job: Job) -> str:
    """Return the bill of materials of a job as CSV, one thing a line.

    What no slicer was asked about stands in it as refused, gauges as `gauge`; screws and bearings
    are counted from the seats of what is printed.
    """
    rows = [
        *_parts(job.parts, job, folder="parts"),
        *_parts(job.refused, job, folder="refused", kind="refused"),
        *_parts(job.gauges, job, folder="gauges", kind="gauge"),
        *(
            ["", each.name, each.kind, "", each.count, "", "", " ".join(each.links), "", ""]
            for each in fasteners(job.parts)
        ),
    ]
    text = io.StringIO(newline="")
    # Lines end as RFC 4180 says; only then is a lone carriage return in a cell quoted.
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows([harmless(cell) for cell in row] for row in rows)
    return text.getvalue()


def harmless(cell: object) -> str:
    """Return a cell that no spreadsheet runs: an apostrophe before what would be a formula."""
    text = str(cell)
    return f"'{text}" if text.startswith(DANGEROUS) else text


def _parts(
    parts: Sequence[Part], job: Job, *, folder: str, kind: str = ""
) -> Iterable[Sequence[object]]:
    for part in parts:
        made = part.kind != "bought"
        lies = folder if made else "bought"
        file = f"{lies}/{part.name}.stl" if part.mesh is not None else ""
        yield (
            part.number,
            part.name,
            kind or part.kind,
            part.hand,
            part.count,
            job.profile.material.name if made else "",
            "" if part.weight is None else f"{1e3 * part.weight.mass:.2f}",
            " ".join(dict.fromkeys(place.link for place in part.placements)),
            file,
            _note(part),
        )


def _note(part: Part) -> str:
    if part.piece_of:
        return f"piece of {part.piece_of}"
    return f"in one with {part.into}" if part.into else ""
