"""The report of a transfer along a chain: one page without scripts, the verdict in words first."""

from __future__ import annotations

import math
from pathlib import Path

from markupsafe import Markup

from morph.app.report.align import arrows
from morph.app.report.align.page import style, tables
from morph.app.report.align.words import VERDICTS, lost_said, quality_rows, sure
from morph.app.report.learn.page import POLICY
from morph.app.report.templates import environment
from morph.app.report.transfer import drawn, words
from morph.arrays import JSON
from morph.policy_transfer.hop_result import Crossing
from morph.policy_transfer.relay_record import RelayRecord

FOLDER = Path(__file__).parent


def transfer_page(record: RelayRecord, trials: int) -> str:
    """Return the report as one HTML page.

    Args:
        record: What was found.
        trials: Runs over which each policy was judged.
    """
    templates = environment(FOLDER, FOLDER.parent / "align")
    return templates.get_template("page.html.j2").render(
        o=record,
        policy=POLICY,
        style=Markup(style(FOLDER / "page.css")),
        chain=words.chain_said(record),
        headline=words.headline(record),
        done=words.done(record),
        summary=words.summary(record),
        kept=drawn.kept(record),
        rows=chain_rows(record),
        hops=[_hop(number, hop) for number, hop in enumerate(record.hops, 1)],
        looks=drawn.key(record),
        trials=trials,
        last=record.hops[-1].target,
        provenance=_provenance(record),
    )


def chain_rows(record: RelayRecord) -> list[dict[str, str]]:
    """Return each hop in a row: what it took, its scores, and the guard's verdict."""
    rows = []
    for hop in record.hops:
        scores = {name: "" if x is None else f"{x:.2f}" for name, x in hop.scores.items()}
        name = f"{hop.source} to {hop.target}"
        rows.append(
            {"name": name, "samples": str(hop.samples), "guard": hop.guard.verdict, **scores}
        )
    return rows


def _hop(number: int, hop: Crossing) -> JSON:
    guard = hop.guard
    return {
        "title": f"Hop {number}: {hop.source} to {hop.target}",
        "verdict": guard.verdict,
        "probability": guard.probability,
        "guard": f"The guard, before a trial: {VERDICTS[guard.verdict]}; {sure(guard)}.",
        "saved": words.saved(hop),
        "credit": words.credit(hop),
        "drawn": arrows.drawn(hop.parts, hop.source, hop.target),
        "tables": tables(hop.parts, hop.source, hop.target),
        "lost": lost_said(hop.parts, hop.target),
        "quality": quality_rows(hop.quality),
        "scores": [_bar(hop, name) for name in words.ORDER if name in hop.measured],
        "curves": drawn.curves(hop),
        "repeats": max((len(each.scores) for each in drawn.shown_of(hop)), default=0),
        "long": max((c.samples[-1] for c in hop.curves if c.name == "scratch"), default=0),
        "notes": hop.notes,
    }


def _bar(hop: Crossing, name: str) -> JSON:
    value = hop.measured[name]
    width = 100.0 * min(max(value, 0.0), 1.0) if math.isfinite(value) else 0.0
    return {"name": words.NAMED[name], "text": f"{value:.3f}", "width": round(width, 2)}


def _provenance(record: RelayRecord) -> list[tuple[str, str]]:
    made = record.said()["provenance"]
    return [("morph", made["morph"]), ("mujoco", made["mujoco"]), *sorted(made["inputs"].items())]
