"""Transitions that `morph align` learns from: simulated, or read from files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from morph.alignment.errors import SamplesError
from morph.alignment.samples import Pairs, Transitions
from morph.app.cli.console import harmless
from morph.errors import TransferError
from morph.files import sha256
from morph.npz import load_npz
from morph.policy_transfer.body import Body
from morph.policy_transfer.parts import BodyNames, Spreads, names_of
from morph.policy_transfer.relay import tried

ARRAYS = ("state", "command", "after")
"""What a file of transitions must hold."""

TOLD = ("turns", "state_names", "command_names")
"""What it may hold beside them."""

MOST_BYTES = 200_000_000
"""Most bytes of a file, unpacked."""

LARGEST = 1e30
"""Largest number of a file: its square and the sums of those must be numbers too."""

FEWEST = 10
"""Transitions of which a map can be learned at all, beside those that are held out."""

MOST = 100_000
"""Transitions that are made of a body, at most."""

HELD_OUT = 0.2
"""Share of the transitions on which a map is judged and from which it is not learned."""

JUDGED = 100
"""Transitions on which the map of simulated bodies is judged."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Side:
    """One of the two bodies."""

    names: BodyNames
    """What its numbers are called."""
    seen: Transitions
    """What it did, to learn from."""
    held: Transitions
    """What it did, to judge by."""
    body: Body | None
    """Its simulation; None if what it did was read."""
    sha256: str
    """Hash of what was given."""

    @property
    def spreads(self) -> Spreads:
        """How far its numbers usually are from their middle."""
        return Spreads(state=self.seen.state.std(axis=0), command=self.seen.command.std(axis=0))


def made(body: Body, samples: int, rng: np.random.Generator) -> Side:
    """Return what a body does under random commands, in its simulation."""
    robot = body.task.robot
    return Side(
        names=names_of(body),
        seen=tried(body, samples, rng),
        held=tried(body, JUDGED, rng),
        body=body,
        sha256=robot.sha256 or sha256(robot.mjcf),
    )


def read(path: Path, option: str) -> Side:
    """Return what a file says that a body did; its last fifth is held out.

    Raises:
        TransferError: It cannot be read, holds something else, or its arrays do not fit together.
    """
    held = _arrays(path, option)
    lacking = [name for name in ARRAYS if name not in held]
    unknown = sorted(held.keys() - {*ARRAYS, *TOLD})
    if lacking or unknown:
        raise _refused(
            path, option,
            f"it lacks {', '.join(lacking)}" if lacking else
            f"it holds {unknown[0]!r}, which says nothing here",
            "" if lacking else f"give the arrays {', '.join((*ARRAYS, *TOLD))} alone",
        )  # fmt: skip
    state, command, after = (_numbers(path, option, name, held[name]) for name in ARRAYS)
    columns = state.shape[1]
    try:
        turns = _turns(path, option, held.get("turns", np.zeros(columns)))
        whole = Transitions(state=state, command=command, after=after, turns=turns)
    except SamplesError as error:
        raise _refused(path, option, error.what, error.fix) from error
    out = max(1, round(HELD_OUT * len(state)))
    if len(state) - out < FEWEST:
        raise _refused(
            path, option, f"it holds {len(state)} transitions", f"give {FEWEST + out} or more"
        )
    names = BodyNames(
        body=harmless(path.stem),
        state=_named(path, option, held, "state", columns),
        command=_named(path, option, held, "command", command.shape[1]),
        shown=columns,
    )
    seen, later = (_some(whole, each) for each in (slice(None, -out), slice(-out, None)))
    return Side(names=names, seen=seen, held=later, body=None, sha256=sha256(path))


def pairs(path: Path) -> Pairs:
    """Return the pairs of states that a file holds.

    Raises:
        TransferError: It cannot be read, holds something else, or there are not as many states of
            one body as of the other.
    """
    held = _arrays(path, "--pairs")
    if held.keys() != {"source", "target"}:
        raise _refused(path, "--pairs", f"it holds {', '.join(sorted(held)) or 'nothing'}")
    both = {name: _numbers(path, "--pairs", name, held[name]) for name in ("source", "target")}
    try:
        return Pairs(**both)
    except SamplesError as error:
        raise _refused(path, "--pairs", error.what, error.fix) from error


def _some(whole: Transitions, which: slice) -> Transitions:
    return Transitions(
        state=whole.state[which],
        command=whole.command[which],
        after=whole.after[which],
        turns=whole.turns,
    )


def _arrays(path: Path, option: str) -> dict[str, Any]:
    try:
        return load_npz(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        given = getattr(error, "strerror", None) or str(error)
        raise _refused(path, option, f"it cannot be read: {given}") from error


def _numbers(path: Path, option: str, name: str, value: Any) -> Any:
    if value.dtype.kind not in "fiu" or value.ndim != 2 or not value.shape[1]:
        raise _refused(
            path, option, f"{name} is of type {value.dtype} and shape {value.shape}",
            "give numbers, one row for each transition and one column or more",
        )  # fmt: skip
    numbers = np.asarray(value, dtype=float)
    if not (np.abs(numbers) <= LARGEST).all():
        raise _refused(
            path, option, f"{name} holds numbers that are not finite, or larger than {LARGEST:g}",
            "leave out what a sensor failed to see, and give other units",
        )  # fmt: skip
    return numbers


def _turns(path: Path, option: str, value: Any) -> Any:
    if value.dtype.kind not in "fiub" or not np.isin(value, (0, 1)).all():
        raise _refused(
            path, option, f"turns is of type {value.dtype} and says more than yes or no",
            "give True or 1 for each number of the state that is an angle which may go round",
        )  # fmt: skip
    return np.asarray(value, dtype=bool)


def _named(
    path: Path, option: str, held: Mapping[str, Any], what: str, count: int
) -> tuple[str, ...]:
    key = f"{what}_names"
    if key not in held:
        return tuple(f"{what} {at + 1}" for at in range(count))
    names = tuple(str(each) for each in np.ravel(held[key]))
    if held[key].dtype.kind != "U" or len(names) != count or len(set(names)) != count:
        raise _refused(
            path, option, f"{key} holds {len(names)} texts for {count} columns of {what}",
            "give each column one name, no two the same",
        )  # fmt: skip
    # Reports are UTF-8, which has no such letters, and a name that nobody sees names nothing.
    if not all(name.isprintable() and name.strip() for name in names):
        raise _refused(
            path, option, f"{key} holds a name with letters that cannot be shown, or without any",
            "name the columns by letters, digits and signs",
        )  # fmt: skip
    return names


def _refused(path: Path, option: str, what: str, fix: str = "") -> TransferError:
    holds = "source and target" if option == "--pairs" else ", ".join(ARRAYS)
    return TransferError(
        what, where=f"{option} {path}", fix=fix or f"give an NPZ file with the arrays {holds}"
    )
