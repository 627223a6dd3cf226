"""What a recording may hold: limits that are checked before memory is taken."""

from __future__ import annotations

import math
import os

from morph.errors import RecordingError

MEMORY = "MORPH_RECORDING_GIB"
"""Environment variable: GiB that the numbers of a recording may take, however well it is packed."""

MOST_BYTES = 2 * 1024**3
"""Most memory of the numbers of a file, or its messages: 10 million samples of 20 channels take
1.6 GB."""

FREE_BYTES = 64 * 1024**2
"""A file of any size may unpack to this: 20 channels at 1 kHz for 7 minutes."""

MOST_RATIO = 100
"""How many times its own size a file may unpack to beyond that. Noise of sensors packs to a tenth
at best; only a bomb packs to a thousandth."""

MOST_COLUMNS = 10_000
"""Most columns or topics of a file, or data sets of an episode; a humanoid with tactile skin has
some thousand."""

MOST_TEXT = 512 * 1024**2
"""Most bytes of a CSV file's text, unpacked; half a minute is parsed by then."""

MOST_LINE = 4 * 1024**2
"""Longest line of text, bytes: that of 10,000 columns has 0.25 MB."""

MOST_BREAKS = 1000
"""Most newlines in a cell of text; a quote that does not end takes in all lines behind it."""

MOST_ENTRIES = 100_000
"""Most groups and data sets in the episodes of an HDF5 file; 3000 demonstrations have 50,000."""

MOST_CHUNK = 256 * 1024**2
"""Greatest chunk, message or page that is unpacked as a whole, bytes; writers' own have some MB."""

MOST_FOOTER = 4 * 1024**2
"""Longest footer of a Parquet file, bytes; that of 10,000 columns has about 1.5 MB."""

MOST_PAGES = 200_000
"""Most pages of a Parquet file; 1.6 GB in pages of the usual megabyte are 1600."""

MOST_BINDING = 2**18
"""Longest `recording.toml`, bytes; a thousand episodes take half of it."""


def most_unpacked(size: int) -> int:
    """Return how many bytes may come out of so many packed ones.

    Raises:
        RecordingError: The environment variable is no number of GiB.
    """
    requested = _asked()
    return min(MOST_BYTES, FREE_BYTES + MOST_RATIO * size) if requested is None else requested


def most_text() -> int:
    """Return the most bytes of a CSV file's text.

    Raises:
        RecordingError: The environment variable is no number of GiB.
    """
    return max(MOST_TEXT, _asked() or 0)


def too_much(what: str, where: str) -> RecordingError:
    """Return the refusal of a file that takes more memory than was allowed."""
    return RecordingError(
        what,
        where=where,
        fix="cut the recording into episodes; or, if you trust the file and have the memory, allow "
        f"more: {MEMORY}=8 in the environment allows 8 GiB, however well it is packed",
    )


def _asked() -> int | None:
    """Return the bytes that the user allows, or None if nothing is said."""
    text = os.environ.get(MEMORY, "").strip()
    if not text:
        return None
    try:
        gib = float(text)
    except ValueError:
        gib = math.nan
    if not 0.0 < gib < 1e6:
        raise RecordingError(
            f"{text!r} is no amount of memory",
            where=f"the environment variable {MEMORY}",
            fix="give GiB, such as 8, or unset it",
        )
    return int(gib * 1024**3)
