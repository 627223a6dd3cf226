"""Score of one answer against the sealed truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.generate import prediction_error
from experiments.concealed.outside import OUTSIDE_LAWS
from experiments.concealed.seal import Sealed
from experiments.concealed.suites import LAWS

JSON = dict[str, Any]
SURE = 0.5
"""Probability of `unknown` above which it is part of the answer."""
LOAD = "payload"
"""The law of a load that is carried."""
PUSH, NEAR = "external_push", 0.25
"""The law that acts in one run alone, and the most seconds by which an event's time is off."""


def score(answer: JSON, sealed: Sealed) -> JSON:
    """Return one row of the table: what was asked and what was answered.

    A finding matches an effect that was left out if it names it, or one of its ties, at its place.
    `first` and `first_three` ask for the name alone, `place` for the place of the first finding.

    Raises:
        BenchmarkError: The answer is to another case, or its predictions do not fit.
    """
    truth = sealed.about
    if answer["case"] != truth["case"]:
        raise BenchmarkError(
            f"the answer is to {answer['case']}", where=truth["case"], fix="name each by its case"
        )
    findings = answer["findings"]
    left = list(range(len(truth["effects"])))
    matched: list[int | None] = []
    for finding in findings:
        fits = [i for i in left if _fits(finding, truth["effects"][i], truth["parts"])]
        matched.append(fits[0] if fits else None)
        if fits:
            left.remove(fits[0])
    unknown = answer["unknown"] > SURE
    names = [(f["effect"], f["where"]) for f in [*findings, *answer.get("rivals", [])]]
    right = [_right_names(effect) for effect in truth["effects"]]
    first = names[:1] if findings else []
    row: JSON = {
        "case": truth["case"],
        "family": truth["family"],
        "way": truth.get("way", "read"),
        "answer": truth["answer"],
        "truth": [f"{e['effect']}@{e['where']['name']}" for e in truth["effects"]],
        "effect_to_noise": [e["effect_to_noise"] for e in truth["effects"]],
        "after_refit": [e["after_refit"] for e in truth["effects"]],
        "found": [f"{f['effect']}@{f['where']}" for f in findings],
        "unknown": unknown,
        "first": any(name in each for name, _ in first for each in right),
        "first_three": any(name in each for name, _ in names[:3] for each in right),
        "place": any(_at_one(where, truth) for _, where in first),
        "exact": not left and None not in matched and not unknown,
        "extra": matched.count(None),
        "seconds": answer["seconds"],
        "claims": _claims(answer, matched, truth),
        "intervals": _intervals(answer, matched, truth),
        "load": _load(answer, matched, truth),
        **_events(answer, truth),
        "E": _share(answer, sealed),
    }
    return row


def unheard(answer: JSON, sealed: Sealed) -> list[str]:
    """Return findings whose law no case has, or whose place this one has not: misspelt names."""
    laws, parts = {law.name for law in (*LAWS, *OUTSIDE_LAWS)}, sealed.about["parts"]
    return [
        f"{each['effect']}@{each['where']}"
        for each in answer["findings"]
        if each["effect"] not in laws or each["where"] not in parts
    ]


def _load(answer: JSON, matched: list[int | None], truth: Mapping[str, Any]) -> float | None:
    """Return the relative error of a load's mass, None where none was left out or named."""
    for finding, at in zip(answer["findings"], matched, strict=True):
        if at is not None and finding["effect"] == truth["effects"][at]["effect"] == LOAD:
            stated = finding.get("parameters", {}).get("m")
            true = truth["effects"][at]["figures"]["m"]
            return abs(stated["value"] / true - 1.0) if stated else None
    return None


def _events(answer: JSON, truth: Mapping[str, Any]) -> JSON:
    """Return how many pushes there are, are claimed and are found, and what is said of changes.

    A push is found if one is claimed in its run that begins less than `NEAR` from it; so is a
    change in its run and at its time, and named if its law and place are right too.
    """
    pushed = {f"run_{e['run'] + 1}": e for e in truth["effects"] if e["run"] is not None}
    claimed = [f for f in answer["findings"] if f["effect"] == PUSH]
    late = [
        abs(f["parameters"]["start"]["value"] - pushed[f["run"]]["figures"]["start"])
        for f in claimed
        if f.get("run") in pushed
    ]
    begun = [e for e in truth["effects"] if e.get("since")]
    told = answer.get("changes", [])
    right = [
        (change, effect)
        for change in told
        for effect in begun
        if change["run"] == effect["since"]["run"]
        and abs(change["time"] - effect["since"]["time"]) <= NEAR
    ]
    return {
        "pushes": len(pushed),
        "pushes_claimed": len(claimed),
        "pushes_found": sum(each <= NEAR for each in late),
        "push_late": min(late, default=None),
        "begun": len(begun),
        "changes": len(told),
        "change_found": bool(right),
        "change_named": any(_fits(change, effect, truth["parts"]) for change, effect in right),
    }


def _right_names(effect: JSON) -> set[str]:
    return {effect["effect"], *(tie["effect"] for tie in effect["ties"])}


def _fits(finding: JSON, effect: JSON, parts: Mapping[str, int]) -> bool:
    """Return whether a finding names an effect or one of its ties at the right place."""
    here = parts.get(finding["where"])
    if here is None:
        return False
    if finding["effect"] == effect["effect"]:
        return effect["anywhere"] or here == parts[effect["where"]["name"]]
    return any(
        finding["effect"] == tie["effect"] and here == parts[tie["where"]] for tie in effect["ties"]
    )


def _at_one(where: str, truth: Mapping[str, Any]) -> bool:
    """Return whether a part is where one of the effects acts, or one of its ties."""
    parts, here = truth["parts"], truth["parts"].get(where)
    return here is not None and any(
        effect["anywhere"]
        or here in {parts[effect["where"]["name"]], *(parts[t["where"]] for t in effect["ties"])}
        for effect in truth["effects"]
    )


def _claims(
    answer: JSON, matched: list[int | None], truth: Mapping[str, Any]
) -> list[tuple[float, bool]]:
    """Return each stated probability, and whether what it is of was so."""
    claims = [
        (finding["probability"], at is not None)
        for finding, at in zip(answer["findings"], matched, strict=True)
    ]
    return [
        *claims,
        (answer["none"], truth["answer"] == "none"),
        (answer["unknown"], truth["answer"] == "unknown"),
    ]


def _intervals(answer: JSON, matched: list[int | None], truth: Mapping[str, Any]) -> list[bool]:
    """Return for each 90 % interval of a right finding whether it holds the truth."""
    held = []
    for finding, at in zip(answer["findings"], matched, strict=True):
        if at is None or finding["effect"] != truth["effects"][at]["effect"]:
            continue
        effect = truth["effects"][at]
        for name, stated in finding.get("parameters", {}).items():
            if name in effect["scored"] and "low90" in stated and "high90" in stated:
                low, high, true = stated["low90"], stated["high90"], effect["figures"][name]
                if name == "phase":
                    # The same angle, in the turn that is nearest to the interval.
                    true += 2.0 * np.pi * np.round((0.5 * (low + high) - true) / (2.0 * np.pi))
                held.append(bool(low <= true <= high))
    return held


def _share(answer: JSON, sealed: Sealed) -> float | None:
    """Return E = (e_nominal - e) / (e_nominal - e_oracle) on the held-out run, None without.

    What is not predicted counts as the description's mean squared error.
    """
    truth = sealed.about
    if not answer.get("predicted"):
        return None
    joints = [
        name for name in truth["parts"] if name.endswith(".position")
    ]  # In the order of the joints.
    try:
        columns = [np.array(answer["predicted"][name], dtype=float) for name in joints]
        predicted = np.column_stack(columns)
        if predicted.shape != sealed.held_out.shape:
            raise ValueError(f"{predicted.shape} readings, not {sealed.held_out.shape}")
    except (KeyError, ValueError) as error:
        raise BenchmarkError(
            f"the predictions do not fit: {error}",
            where=truth["case"],
            fix="predict every position channel at every time of held_out/commands.csv.gz",
        ) from error
    # Outside of windows nothing is asked for.
    asked = np.isfinite(sealed.oracle).all(axis=1)
    missing = ~np.isfinite(predicted[asked]).all(axis=1)
    found = truth["nominal_error"]
    if not missing.all():
        told = np.where(asked[:, None], predicted, np.nan)
        rms = prediction_error(told, sealed.held_out, np.array(truth["reading_error"]))
        share = float(missing.mean())
        found = np.sqrt((1.0 - share) * rms**2 + share * truth["nominal_error"] ** 2)
    room = truth["nominal_error"] - truth["oracle_error"]
    # Without room there is nothing to gain, and only harm to measure.
    return float((truth["nominal_error"] - found) / max(room, 1.0))
