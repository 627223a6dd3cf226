"""Checkpoint of the hops of a chain, for resuming."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.alignment.maps.body_map import BodyMap
from morph.alignment.maps.files import read
from morph.arrays import JSON, Array
from morph.errors import OutputError
from morph.files import sha256, write_whole
from morph.npz import load_npz
from morph.policy_transfer.hop_result import Crossing, Curve, parts_said
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.transfer_record import GuardRecord
from morph.regular_file import read_regular

STATE, HOPS, LAW, TOLD = "relay.json", "hops", "law.npz", "hop.json"
"""Whose hops a folder holds; and of each hop its law, and what is told of it."""

SCHEMA = "morph.relay/1"
"""Of `relay.json`."""

MOST_BYTES = 20_000_000
"""Largest file of a hop that is read."""

NUMBERS = ("gain", "shift", "step")
"""What `law.npz` holds."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Kept:
    """A hop that has ended."""

    crossing: Crossing
    """What is told of it."""
    map: BodyMap
    """Its map."""
    gain: Array
    """Of the target's law about rest, shape (nu, n)."""
    shift: Array
    """Shape (nu,)."""
    step: Array
    """(A, B) as believed of the target, shape (n, n + nu): what the next hop begins from."""


class HopsKept:
    """The hops of one relay in one folder.

    Args:
        out: The folder.
        key: What must be the same for a relay to go on: bodies, policy, samples, seed.

    Raises:
        OutputError: The folder holds another relay, or cannot be written to.
    """

    def __init__(self, out: Path, key: Mapping[str, str]) -> None:
        self.out = out
        state, record = out / STATE, {"schema": SCHEMA, **key}
        if state.is_file():
            _check(state, record)
        else:
            write_whole(state, json.dumps(record, indent=1) + "\n")

    def write(self, number: int, done: Kept) -> None:
        """Keep a hop; its `hop.json` makes it a finished one."""
        folder, held = self._folder(number), io.BytesIO()
        np.savez(held, gain=done.gain, shift=done.shift, step=done.step)
        write_map(self.out / done.crossing.map, done.map)
        write_whole(folder / LAW, held.getvalue())
        record = _told(done.crossing)
        record["map_sha256"] = sha256(self.out / done.crossing.map)
        record["law_sha256"] = sha256(held.getvalue())
        write_whole(folder / TOLD, json.dumps(record) + "\n")

    def read(self, number: int) -> Kept | None:
        """Return a finished hop, or None if it is yet to be made, or was spoilt."""
        folder = self._folder(number)
        try:
            document = json.loads(read_regular(folder / TOLD, MOST_BYTES))
            crossing = _crossing(document)
            mine = crossing.map == map_name(number)
            if not mine or sha256(self.out / crossing.map) != document["map_sha256"]:
                return None
            data = read_regular(folder / LAW, MOST_BYTES)
            if sha256(data) != document["law_sha256"]:
                return None
            # What is lacking of it fails here, where the hop can still be made anew.
            crossing.said()
            held = load_npz(data, MOST_BYTES)
            law = {name: np.asarray(held[name], dtype=float) for name in NUMBERS}
            gain, step = law["gain"], law["step"]
            fits = gain.shape[:1] == law["shift"].shape and step.shape == (
                gain.shape[1],
                sum(gain.shape),
            )
            if not (fits and all(np.isfinite(each).all() for each in law.values())):
                return None
            return Kept(crossing=crossing, map=read(self.out / crossing.map), **law)
        # numpy, zipfile and json raise a dozen unrelated errors on damaged bytes.
        except Exception:
            return None

    def _folder(self, number: int) -> Path:
        return self.out / HOPS / f"{number:02d}"


def map_name(number: int) -> str:
    """Return the name of a hop's map beside the record."""
    return f"maps/{number:02d}_body_map.npz"


def write_map(path: Path, body_map: BodyMap) -> None:
    """Write a map whole or not at all, as `morph.alignment.maps.files` reads it.

    Raises:
        OutputError: The folder cannot be written to.
    """
    held = io.BytesIO()
    arrays: dict[str, Any] = {"kind": np.array(body_map.kind), **body_map.weights()}
    np.savez(held, **arrays)
    write_whole(path, held.getvalue())


def _check(state: Path, message: Mapping[str, str]) -> None:
    try:
        before = json.loads(read_regular(state, MOST_BYTES))
        other = [name for name, value in message.items() if before[name] != value]
    except (ValueError, KeyError, TypeError, OSError, RecursionError) as error:
        raise OutputError(
            f"it is no state of a transfer: {error}", where=str(state), fix="name a new folder"
        ) from error
    if other:
        raise OutputError(
            f"the folder holds a transfer with other {' and other '.join(other)}",
            where=str(state.parent),
            fix="name a new folder, or begin anew in this one by --fresh",
        )


def _told(crossing: Crossing) -> JSON:
    plain = {name: getattr(crossing, name) for name in ("source", "target", "map", "kind")}
    return {
        **plain,
        "samples": crossing.samples,
        "quality": dict(crossing.quality),
        "measured": dict(crossing.measured),
        "guard": vars(crossing.guard),
        "parts": parts_said(crossing.parts),
        "notes": list(crossing.notes),
        "curves": [
            {"name": each.name, "samples": list(each.samples), "scores": each.scores.tolist()}
            for each in crossing.curves
        ],
    }


def _crossing(document: Any) -> Crossing:
    arrows = {
        name: tuple(
            Arrow(begin=str(a["from"]), end=str(a["to"]), weight=float(a["weight"]))
            for a in document["parts"][name]
        )
        for name in ("states", "commands")
    }
    return Crossing(
        **{name: str(document[name]) for name in ("source", "target", "map", "kind")},
        samples=int(document["samples"]),
        quality={str(name): float(value) for name, value in document["quality"].items()},
        measured={str(name): float(value) for name, value in document["measured"].items()},
        guard=GuardRecord(**document["guard"]),
        parts=Parts(**arrows, lost=tuple(map(str, document["parts"]["lost"]))),
        notes=tuple(map(str, document["notes"])),
        curves=tuple(
            Curve(
                name=str(each["name"]),
                samples=tuple(map(int, each["samples"])),
                scores=np.array(each["scores"], dtype=float),
            )
            for each in document["curves"]
        ),
    )
