"""Reading what `morph align`, `morph transfer` or `morph loop` left in a folder, with distrust."""

from __future__ import annotations

import itertools
import json
import math
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np

from morph.app.viewer.align.transfer_record import Story, Told
from morph.app.viewer.align.values import RecordValues
from morph.errors import ViewError
from morph.policy_transfer.hop_result import Crossing, Curve
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.transfer_record import GuardRecord
from morph.regular_file import read_regular

RECORDS = {"transfer.json": "morph.transfer/1", "align.json": "morph.align/1"}
"""What a folder may hold, and by which schema."""

MOST_BYTES = 20_000_000
"""Largest record that is read; one of eight hops has some 100 kB."""

MOST_HOPS = 99
"""Most hops: their files are numbered by two digits."""

MOST_PARTS = 2000
"""Most arrows, or names, of one hop."""

SENTENCE, MOST_NOTES = 2000, 100
"""Letters of a sentence, and how many of them."""

MAP = re.compile(r"maps/[0-9]{2}_body_map\.npz")
"""Where a map may stand beside its record."""

NO_PARTS = Parts(states=(), commands=(), lost=())


def story(folder: Path) -> Story:
    """Return what a folder tells.

    Raises:
        ViewError: It holds no record, or one that nobody of ours wrote.
    """
    if folder.name in RECORDS and folder.is_file():
        folder = folder.parent
    name = next((each for each in RECORDS if _there(folder / each)), None)
    if name is None:
        raise _none(folder)
    path = folder / name
    record = RecordValues(_said(folder, path), str(path))
    schema = record.text("schema")
    if schema != RECORDS[name]:
        raise record.refused(f"it is of the schema {schema!r}, not {RECORDS[name]}")
    return _aligned(folder, record) if name == "align.json" else _transfer(folder, record)


def inside(folder: Path, name: str) -> Path | None:
    """Return a file or folder beside a record, None if it is gone.

    Raises:
        ViewError: A link leads out of the folder.
    """
    path = folder / name
    try:
        if not path.exists():
            return None
        out = not path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:
        raise ViewError(
            f"it cannot be looked for: {error}", where=str(path), fix="copy the folder again"
        ) from error
    if out:
        raise ViewError(
            "it is a link that leads out of the folder",
            where=str(path),
            fix="copy what it leads to into the folder, if you trust it",
        )
    return path


def _there(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:
        return False


def _none(folder: Path) -> ViewError:
    if not _there(folder):
        what, fix = "there is no such folder", "name a folder that was written by --out"
    elif _there(folder / "relay.json"):
        what = "the transfer in it has not ended"
        fix = "run the same `morph transfer` again: it goes on where it was"
    else:
        what = f"it holds neither {' nor '.join(RECORDS)}"
        fix = "give a folder that `morph align` or `morph transfer` wrote by --out"
    return ViewError(what, where=f"--transfer {folder}", fix=fix)


def _said(folder: Path, path: Path) -> Any:
    try:
        inside(folder, path.name)
        content = read_regular(path, MOST_BYTES)
    except OSError as error:
        raise ViewError(
            f"it cannot be read: {error.strerror or error}",
            where=str(path),
            fix="give a file that can be read",
        ) from error
    try:
        return json.loads(content)
    # Brackets in their thousands exceed Python's own depth.
    except (ValueError, RecursionError) as error:
        raise ViewError(
            f"it is not JSON, or only a part of it: {error}",
            where=str(path),
            fix="run the command that wrote it again",
        ) from error


def _aligned(folder: Path, record: RecordValues) -> Story:
    source, target = record.inside("source"), record.inside("target")
    guard = record.inside("guard")
    hop = Told(
        source=source.text("name"),
        target=target.text("name"),
        map=_map(folder, record),
        mapper=record.text("mapper"),
        parts=_parts(record.inside("parts")),
        quality=record.numbers("quality"),
        guard=_guard(guard),
        why=guard.text("why", SENTENCE),
        samples=int(record.inside("samples").number("target", 0.0)),
    )
    made = record.inside("provenance")
    return Story(
        folder=folder,
        command="align",
        hops=(hop,),
        asked=_asked(made.text("command", SENTENCE), "align"),
        hashes=_hashes(made),
        notes=record.texts("notes", MOST_NOTES, SENTENCE),
    )


def _transfer(folder: Path, record: RecordValues) -> Story:
    hops = record.each("hops", lambda each: _hop(folder, each), MOST_HOPS)
    broken = any(a.target != b.source for a, b in itertools.pairwise(hops))
    if not hops or broken:
        raise record.refused("its hops make no chain: each must begin where the one before ended")
    made = record.inside("provenance")
    relay = all(hop.crossing is not None for hop in hops)
    named = record.inside("robot")
    return Story(
        folder=folder,
        command="transfer" if relay else "loop",
        hops=hops,
        asked=_asked(made.text("command", SENTENCE), "transfer") if relay else (),
        hashes={named.text("name"): named.text("sha256"), **_hashes(made)},
        policy=inside(folder, "policy") if record.has("policy") else None,
        notes=record.texts("notes", MOST_NOTES, SENTENCE),
    )


def _hop(folder: Path, record: RecordValues) -> Told:
    relay = record.inside("relay") if record.has("relay") else None
    parts = NO_PARTS if relay is None else _parts(relay.inside("parts"))
    guard = _guard(record.inside("guard"))
    quality = record.numbers("quality") if relay is not None else {}
    return Told(
        source=record.text("source"),
        target=record.text("target"),
        map=None if relay is None else _map(folder, record),
        mapper="same joints" if relay is None else relay.text("kind"),
        parts=parts,
        quality=quality,
        guard=guard,
        samples=int(record.number("samples", 0.0)),
        scores={
            name: None if math.isnan(value) else value
            for name, value in record.numbers("score").items()
        },
        crossing=None if relay is None else _crossing(record, relay, parts, guard, quality),
        notes=() if relay is None else relay.texts("notes", MOST_NOTES, SENTENCE),
    )


def _crossing(
    record: RecordValues,
    relay: RecordValues,
    parts: Parts,
    guard: GuardRecord,
    quality: dict[str, float],
) -> Crossing:
    measured = relay.numbers("measured")
    for name in ("hold_still", "oracle"):
        # A share of what the oracle gains cannot be told without them.
        measured.setdefault(name, math.nan)
    return Crossing(
        source=record.text("source"),
        target=record.text("target"),
        map=record.text("map"),
        kind=relay.text("kind"),
        parts=parts,
        quality=quality,
        guard=guard,
        samples=int(record.number("samples", 0.0)),
        measured=measured,
        curves=relay.each("curves", _curve, 20),
    )


def _curve(record: RecordValues) -> Curve:
    samples = tuple(int(each) for each in record.list_of_numbers("samples", MOST_PARTS))
    mean = record.list_of_numbers("mean", MOST_PARTS)
    if len(samples) != len(mean) or not samples:
        raise record.refused(f"{len(samples)} counts of transitions have {len(mean)} means")
    return Curve(name=record.text("name"), samples=samples, scores=np.array([mean]))


def _guard(record: RecordValues) -> GuardRecord:
    verdict = record.text("verdict")
    probability = record.number("probability", 0.0, 1.0) if record.has("probability") else None
    if verdict == "safe":
        return GuardRecord(verdict="safe", probability=probability)
    if verdict == "unsafe":
        return GuardRecord(verdict="unsafe", probability=probability)
    if verdict == "unsure":
        return GuardRecord(verdict="unsure", probability=probability)
    raise record.refused(f"the verdict is {verdict!r}, not safe, unsafe or unsure")


def _parts(record: RecordValues) -> Parts:
    return Parts(
        states=record.each("states", _arrow, MOST_PARTS),
        commands=record.each("commands", _arrow, MOST_PARTS),
        lost=record.texts("lost", MOST_PARTS),
    )


def _arrow(record: RecordValues) -> Arrow:
    return Arrow(
        begin=record.text("from"), end=record.text("to"), weight=record.number("weight", -1.0, 1.0)
    )


def _map(folder: Path, record: RecordValues) -> Path | None:
    name = record.text("map")
    if not MAP.fullmatch(name):
        raise record.refused(f"its map is {name!r}, not a file such as maps/01_body_map.npz")
    return inside(folder, name)


def _hashes(made: RecordValues) -> dict[str, str]:
    return made.texts_by_name("inputs") if made.has("inputs") else {}


def _asked(command: str, what: str) -> tuple[str | None, ...]:
    """Return what the bodies were asked for by, out of the command; None for a recording."""
    try:
        words = shlex.split(command)
    except ValueError:
        return ()
    if words[:2] != ["morph", what]:
        return ()
    if what == "align":
        bodies: list[str | None] = [*_until_option(words[2:])]
        bodies[:0] = [None] if "--source" in words else []
        return (*bodies, None) if "--target" in words else tuple(bodies)
    return _until_option(words[words.index("--chain") + 1 :]) if "--chain" in words else ()


def _until_option(words: list[str]) -> tuple[str, ...]:
    end = next((at for at, word in enumerate(words) if word.startswith("--")), len(words))
    return tuple(words[:end])
