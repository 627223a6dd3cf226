"""The sealed truth of a case: written once, opened only after the diagnosis."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from experiments.conceal.case import Case
from morph.errors import MorphError
from morph.files import write_whole

FILE = Path("sealed") / "truth.sealed.json"


class SealError(MorphError):
    """A seal is missing or cannot be read."""


@dataclass(frozen=True, kw_only=True)
class Sealed:
    """What is true of a case and was not told."""

    case: Case
    """Robot, effect and place."""
    parameters: dict[str, float]
    """The effect's parameters, by the symbols of `effects.md`; empty if clean."""
    strength: float
    """RMS change of 0.5 s of motion by the effect over the sensors' RMS noise."""
    true: dict[str, float]
    """True masses (kg), distances (m) and inertias (kg m2)."""
    nominal: dict[str, float]
    """The same as the description states them."""
    gains: dict[str, float]
    """True gain of each actuator, the effect apart; the description says 1."""
    noise: dict[str, float]
    """RMS noise of each channel, rad or m."""
    rate_hz: float
    """How often the logger ticks."""


def write_seal(sealed: Sealed, folder: Path) -> Path:
    """Write the seal of a case into its folder."""
    return write_whole(folder / FILE, json.dumps(asdict(sealed), indent=1) + "\n")


def open_seal(folder: Path) -> Sealed:
    """Return the truth of a case.

    Raises:
        SealError: There is no seal, or it is damaged.
    """
    path = folder / FILE
    try:
        data = json.loads(path.read_text())
        return Sealed(**{**data, "case": Case(**data["case"])})
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise SealError(
            f"cannot open the seal: {error}",
            where=str(path),
            fix="name the folder of one case, or make it again with python -m experiments.conceal",
        ) from error
