"""No recording may be counted twice."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from morph.errors import RecordingError
from morph.record.recording import Recording


def check_distinct(recordings: Iterable[Recording]) -> None:
    """Refuse recordings with the same bytes, over one load or several.

    Two are the same if their files are, byte by byte, or if all their channels
    are: a copy that was only compressed or renamed is still a copy.

    Raises:
        RecordingError: Two recordings are identical.
    """
    seen: dict[str, Recording] = {}
    for recording in recordings:
        for mark in {recording.sha256, contents(recording)} - {""}:
            if mark in seen:
                raise _identical(seen[mark], recording)
        seen.update({recording.sha256: recording, contents(recording): recording})


def contents(recording: Recording) -> str:
    """Return a hash of a recording's channels, whatever file they came from."""
    digest = hashlib.sha256()
    for name in sorted(recording.channels):
        channel = recording.channels[name]
        digest.update(name.encode())
        digest.update(channel.time.tobytes())
        digest.update(channel.value.tobytes())
    return digest.hexdigest()


def _identical(one: Recording, other: Recording) -> RecordingError:
    files = [", ".join(map(str, each.sources)) or each.name for each in (one, other)]
    return RecordingError(
        f"the recordings {one.name!r} and {other.name!r} are identical, byte by byte",
        where=f"{files[1]} and {files[0]}",
        fix="leave one of the two out; a copy makes a result look surer than it is",
    )
