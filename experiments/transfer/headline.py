"""The headline of many cases of transfer: goals reached, harm, and what the oracle alone solves."""

from __future__ import annotations

from collections.abc import Sequence

from experiments.transfer.tables import (
    SURE,
    compared,
    gains_of,
    grouped,
    iqm,
    missed,
    solvable,
)
from morph.arrays import JSON

BEYOND = 3.0
"""Standard errors beyond which a policy is better or worse than the one that it came from."""


def headline(lines: Sequence[JSON]) -> JSON:
    """Return what a result file holds.

    Goals reached in the second trial and by sure policies are counted over the cases in which any
    policy reaches them at all; `missed` are those in which a plan on the true body works and the
    loop's policy does not.
    """
    rows = [_row(case, arms) for case, arms in grouped(lines).items()]
    total = {
        f"{key}": sum(row.get(key, 0) for row in rows if row["solvable"])
        for key in ("seeds", "second_trial_reached", "loop_sure", "unadjusted_sure")
    }
    gains = [each for _, each in gains_of(lines, "loop")]
    harm = {
        "judged": len(gains),
        "better": sum(each < -BEYOND for each in gains),
        "worse": sum(each > BEYOND for each in gains),
    }
    failed = missed(lines)
    figures = total | harm | {"missed": len(failed), "compared": compared(lines)}
    controls = {
        row["case"]: {key: row[key] for key in row if key.startswith(("unadjusted", "own_plan"))}
        for row in rows
    }
    return {"figures": figures, "controls": controls, "rows": [*rows, *failed]}


def _row(case: str, arms: dict[str, list[JSON]]) -> JSON:
    second = [line["lines"][1] for line in arms.get("loop", ()) if len(line["lines"]) > 1]
    row: JSON = {
        "case": case,
        "solvable": solvable(arms),
        "seeds": len(arms.get("loop", ())),
        "second_trial_reached": sum(bool(each.get("reached")) for each in second),
    }
    for arm, tried in arms.items():
        last = [line["lines"][-1] for line in tried]
        name = arm.replace(" ", "_")
        row[f"{name}_sure"] = sum(each["success"] >= SURE for each in last)
        row[f"{name}_loss"] = iqm([each["loss"] for each in last])[0]
    return row
