"""The sealed truth of a case: written apart from it, opened only to score."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.concealed.case import Case
from experiments.concealed.errors import BenchmarkError
from experiments.concealed.plant import Array
from experiments.concealed.simulate import GRID
from experiments.concealed.ties import ties_of
from experiments.concealed.truth import Effect
from morph.files import sha256

SCHEMA = "concealed.truth/2"
CASES, TRUTHS = "cases", "truth"
"""Folders of what solvers may read, and of what only the scorer reads."""


@dataclass(frozen=True, kw_only=True)
class Sealed:
    """What a scorer knows of a case."""

    about: Mapping[str, Any]
    """The JSON of `truth_of`."""
    held_out: Array
    """Readings of the held-out run without noise, shape (rows, joints)."""
    oracle: Array
    """The true plant's predictions of them, NaN outside of windows, same shape."""


def truth_of(
    case: Case, arrays: bytes, nominal_error: float, oracle_error: float
) -> dict[str, Any]:
    """Return what is true of a case, as JSON.

    Args:
        case: The case.
        arrays: The file of its arrays.
        nominal_error: RMS error of the description's predictions of the held-out run, in units of
            the readings' error.
        oracle_error: The same for the true plant.
    """
    truth, mechanism = case.truth, case.mechanism
    outside = any(effect.law.why for effect in truth.effects)
    effects = [
        {
            "effect": effect.law.name,
            "where": {"kind": effect.law.kind, "name": effect.where(mechanism)},
            "figures": {
                name: float(x)
                for name, x in effect.law.beside(
                    effect.figures, mechanism.plant, truth.base, effect.place
                ).items()
            },
            "scored": [name for name in effect.figures if name not in effect.law.given],
            "effect_to_noise": float(f"{ratio:.4g}"),
            "after_refit": float(f"{left:.4g}"),
            "run": effect.run,
            "since": _since(effect),
            "anywhere": effect.law.name == "voltage_sag",
            "ties": [
                {"effect": tie.effect, "where": tie.where, "reason": tie.reason}
                for tie in ties_of(truth, effect)
            ],
            "why": effect.law.why,
        }
        for effect, ratio, left in zip(truth.effects, case.strengths, case.left, strict=True)
    ]
    parts = {"world": -1}
    for i, (joint, link) in enumerate(zip(mechanism.joints, mechanism.links, strict=True)):
        names = (joint, link, mechanism.actuator(i), f"{joint}.position", f"{joint}.velocity")
        parts |= dict.fromkeys(names, i)
    return {
        "schema": SCHEMA,
        "case": case.name,
        "suite": case.suite,
        "family": mechanism.family,
        "way": case.way,
        "answer": "unknown" if outside else "effects" if effects else "none",
        "effects": effects,
        "parts": parts,
        "factors": {kind: list(each) for kind, each in case.factors.items()},
        "arrays_sha256": sha256(arrays),
        "reading_error": [float(x) for x in truth.error],
        "nominal_error": float(f"{nominal_error:.6g}"),
        "oracle_error": float(f"{oracle_error:.6g}"),
    }


def _since(effect: Effect) -> dict[str, Any] | None:
    """Return the run, as its recording is called, and the second from which an effect acts."""
    if effect.since is None:
        return None
    run, grids = effect.since
    return {"run": f"run_{run + 1}", "time": float(f"{grids * GRID:.6g}")}


def open_seal(case: Path) -> Sealed:
    """Return the truth of the case in a folder.

    Raises:
        BenchmarkError: There is no truth of that name, it is damaged, or it is not that of which
            the case has the hash.
    """
    path = case.parents[1] / TRUTHS / f"{case.name}.json"
    try:
        text = path.read_text()
        arrays = path.with_suffix(".npz").read_bytes()
        about, known = json.loads(text), json.loads((case / "case.json").read_text())
        if (known["truth_sha256"], about["arrays_sha256"]) != (sha256(text), sha256(arrays)):
            raise ValueError("its SHA-256 is not the one that the case was sealed with")
        with np.load(io.BytesIO(arrays)) as data:
            return Sealed(about=about, held_out=data["position"], oracle=data["oracle"])
    except (OSError, ValueError, KeyError) as error:
        raise BenchmarkError(
            f"cannot open the truth: {error}",
            where=str(path),
            fix="make the cases again by python -m experiments.concealed",
        ) from error
