"""The gate's figures in words and tables, and as a page."""

from __future__ import annotations

from html import escape

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.gate.measures import calibration, reliability, wilson
from morph.arrays import JSON


def costs(rows: list[JSON]) -> JSON:
    """Return what the foretold costs amount to."""
    probability = np.array([row["probability"] for row in rows])
    true = np.array([row["within"] for row in rows], dtype=float)
    wrong_yes = [row for row in rows if row["answer"] == "good" and not row["within"]]
    wrong_no = [row for row in rows if row["answer"] == "not good" and row["within"]]
    outside = int(len(rows) - true.sum())
    low, high = wilson(len(wrong_yes), outside)
    spared = [r for r in rows if not r["good"] and r["within"]]
    return {
        "cases": len(rows),
        "within": int(true.sum()),
        "said_within": sum(row["answer"] == "good" for row in rows),
        "wrongly_within": len(wrong_yes),
        "wrongly_within_of": outside,
        "wrongly_within_low": low,
        "wrongly_within_high": high,
        "wrongly_outside": len(wrong_no),
        "cannot_say": sum(row["answer"] == "cannot say" for row in rows),
        "calibration": calibration(probability, true),
        "reliability": reliability(probability, true),
        "model_bad_yet_cost_within": len(spared),
        "of_these_said_within": sum(row["answer"] == "good" for row in spared),
    }


def headline(gate: JSON) -> str:
    """Return both errors in one sentence: what accepts nothing is never wrong either."""
    wrong, withheld, missed = (
        gate[key] for key in ("false_accepts", "good_withheld", "bad_not_rejected")
    )
    return (
        f"wrongly accepted at the worst moment {wrong['count']} of {wrong['of']}; good, and not "
        f"accepted after one run {withheld['count']} of {withheld['of']}; bad, and not rejected "
        f"after one run {missed['count']} of {missed['of']}"
    )


def told(found: JSON) -> None:
    """Print the figures."""
    console = Console()
    gate = found["gate"]
    console.print(headline(gate), style="bold")
    console.print(_families(gate["families"]))
    for title, key in (
        ("false accepts at the worst moment", "false_accepts"),
        ("false rejects at the worst moment", "false_rejects"),
        ("good models accepted after one run", "accepted"),
        ("good models not accepted after one run", "good_withheld"),
        ("bad models rejected after one run", "rejected"),
    ):
        console.print(f"{title}: {_share(gate[key])}")
    alone = gate["by_probability"]
    console.print(
        f"by the probability alone: false accepts at the worst moment "
        f"{_share(alone['false_accepts'])}, accepted {_share(alone['accepted'])}"
    )
    console.print(
        f"calibration error {gate['calibration']:.3f} ({gate['cases']} cases), of single "
        f"transitions {gate['calibration_of_transitions']:.3f}; accuracy {gate['accuracy']:.3f}"
    )
    for title in ("reliability", "reliability_of_transitions"):
        console.print(_reliability(title.replace("_", " "), gate[title]))
    for name, each in found.get("controls", {}).items():
        console.print(
            f"{name}: accepts {_share(each['false_accepts'])} of the bad, "
            f"{_share(each['accepted'])} of the good, rejects {_share(each['rejected'])} of the "
            f"bad; calibration {each['calibration']:.3f}, of transitions "
            f"{each['calibration_of_transitions']:.3f}"
        )
    if "cost" in found:
        cost = found["cost"]
        console.print(
            f"cost within 10 %: {cost['cases']} cases, {cost['within']} truly within; said within "
            f"{cost['said_within']}, wrongly {cost['wrongly_within']} of "
            f"{cost['wrongly_within_of']} outside; wrongly outside {cost['wrongly_outside']}; "
            f"cannot say {cost['cannot_say']}; calibration {cost['calibration']:.3f}; a bad model "
            f"whose cost holds: {cost['model_bad_yet_cost_within']}, of these said within "
            f"{cost['of_these_said_within']}"
        )


def _share(each: JSON) -> str:
    return f"{each['count']} of {each['of']} ({each['low']:.1%} to {each['high']:.1%})"


def _families(rows: list[JSON]) -> Table:
    table = Table(title="Answers after one run of 3 s")
    for title in ("target", "truly", "cases", "good", "not good", "cannot say", "right"):
        table.add_column(title, justify="left" if title in {"target", "truly"} else "right")
    for row in rows:
        truly = "good" if row["truly_good"] else "not good"
        right = f"{row['right'] / row['cases']:.0%} ({row['low']:.0%} to {row['high']:.0%})"
        numbers = [str(row[key]) for key in ("cases", "good", "not good", "cannot say")]
        table.add_row(row["family"], truly, *numbers, right)
    return table


def _reliability(title: str, rows: list[JSON]) -> Table:
    table = Table(title=title)
    for name in ("said", "came true", "95 %", "cases"):
        table.add_column(name, justify="right")
    for row in rows:
        between = f"{row['low']:.2f} to {row['high']:.2f}"
        table.add_row(f"{row['said']:.3f}", f"{row['true']:.3f}", between, str(row["cases"]))
    return table


def page(found: JSON) -> str:
    """Return a page with the reliability of verdicts and transitions, drawn."""
    parts = []
    for title in ("reliability", "reliability_of_transitions"):
        marks = []
        for row in found["gate"][title]:
            x, y = 20 + 260 * row["said"], 280 - 260 * row["true"]
            top, low = 280 - 260 * row["high"], 280 - 260 * row["low"]
            marks.append(
                f'<line x1="{x:.1f}" y1="{top:.1f}" x2="{x:.1f}" y2="{low:.1f}" stroke="#888"/>'
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="#294a75">'
                f"<title>{row['cases']} cases</title></circle>"
            )
        parts.append(
            f"<h2>{escape(title.replace('_', ' '))}</h2>"
            '<svg width="320" height="300" viewBox="0 0 320 300">'
            '<rect x="20" y="20" width="260" height="260" fill="none" stroke="#333"/>'
            '<line x1="20" y1="280" x2="280" y2="20" stroke="#c60"/>' + "".join(marks) + "</svg>"
            "<p>Across: what the gate said; up: how often it came true, with 95 % intervals.</p>"
        )
    style = "<style>body{font-family:sans-serif;margin:2em}</style>"
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><title>The gate</title>'
        f"{style}<h1>Is the model good enough?</h1>{''.join(parts)}</html>"
    )
