"""No recording may be counted twice."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import replace

from morph.errors import RecordingError
from morph.record.recording import Note, Recording


def distinct(recordings: Iterable[Recording]) -> tuple[Recording, ...]:
    """Return recordings without copies, each of which is noted at the one that it repeats.

    Two are the same as `check_distinct` says.
    """
    kept: list[Recording] = []
    seen: dict[str, int] = {}
    for recording in recordings:
        marks = {recording.sha256, contents(recording)} - {""}
        at = next((seen[mark] for mark in marks if mark in seen), None)
        if at is None:
            seen |= dict.fromkeys(marks, len(kept))
            kept.append(recording)
        else:
            copy = Note(
                what=f"recording {recording.name!r} is identical to {kept[at].name!r} in all "
                "its values, and was left out",
                where=", ".join(map(str, recording.sources)) or recording.name,
            )
            kept[at] = replace(kept[at], notes=(*kept[at].notes, copy))
    return tuple(kept)


def check_distinct(recordings: Iterable[Recording]) -> None:
    """Refuse recordings with the same bytes, over one load or several.

    Two are the same if their files are, byte by byte, or if all their channels
    hold the same values: a copy that was compressed, renamed or put on another clock is a copy.

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
    """Return a hash of a recording's values, whatever file they came from and clock they are on."""
    digest = hashlib.sha256()
    for name in sorted(recording.channels):
        channel = recording.channels[name]
        digest.update(name.encode())
        digest.update(channel.value.tobytes())
    return digest.hexdigest()


def _identical(one: Recording, other: Recording) -> RecordingError:
    files = [", ".join(map(str, each.sources)) or each.name for each in (one, other)]
    return RecordingError(
        f"the recordings {one.name!r} and {other.name!r} are identical in all their values",
        where=f"{files[1]} and {files[0]}",
        fix="leave one of the two out; a copy makes a result look surer than it is",
    )
