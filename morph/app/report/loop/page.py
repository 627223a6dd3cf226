"""The report of a loop: one page without scripts that says the verdict in words first."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from markupsafe import Markup

from morph.app.report.learn.page import POLICY
from morph.app.report.learn.words import number
from morph.app.report.loop import drawn, words
from morph.app.report.loop.outcome import LoopOutcome
from morph.app.report.loop.verdict import beyond, headline, sealed_rows, summary
from morph.app.report.templates import environment
from morph.app.report.words import counted, percent
from morph.arrays import JSON
from morph.search.evaluate import Score

FOLDER = Path(__file__).parent


def loop_page(outcome: LoopOutcome) -> str:
    """Return the report as one HTML page."""
    robot, record = outcome.task.robot, outcome.record().said()
    return environment(FOLDER).get_template("page.html.j2").render(
        o=outcome,
        policy=POLICY,
        style=Markup(_style()),
        headline=headline(outcome),
        failed=outcome.transferred is not None and not outcome.succeeded,
        why=_sentence(outcome.why),
        summary=summary(outcome),
        lacked=words.differences(outcome.differences, robot),
        runs=_runs(outcome),
        sealed=sealed_rows(outcome),
        more=", ".join(beyond(outcome)),
        rivals=_rivals(outcome),
        losses=drawn.losses(outcome),
        trials=trial_rows(outcome),
        scores=_scores(outcome),
        judged_rows=0 if outcome.judged is None else len(outcome.judged.still.loss),
        foretold=_foretold(outcome),
        window=drawn.WINDOW,
        provenance=_provenance(record),
        number=number,
        percent=percent,
    )  # fmt: skip


def _style() -> str:
    report = FOLDER.parent
    sheets = (report / "page.css", report / "learn" / "page.css", FOLDER / "page.css")
    return "".join(sheet.read_text(encoding="utf-8") for sheet in sheets)


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}." if text else ""


def _runs(outcome: LoopOutcome) -> str:
    named = ("trial", "trials") if outcome.rounds else ("recording", "recordings")
    together = " together" if len(outcome.runs) > 1 else ""
    return f"{counted(len(outcome.runs), *named)} of {number(outcome.experience)} s{together}"


def _rivals(outcome: LoopOutcome) -> list[JSON]:
    if outcome.repair is None:
        return []
    return [
        {"what": what, "share": share, "text": percent(share)}
        for what, share in outcome.repair.explained.rivals
    ]


def trial_rows(outcome: LoopOutcome) -> list[JSON]:
    """Return each trial in words: its policy, what came of it, and what was learned from it."""
    rows = []
    for at, done in enumerate(outcome.rounds, 1):
        advice, tried = done.advice, done.tried
        gate, lacked, following = "", "", ""
        if advice is not None:
            gate = words.gate(advice.verdict)
            lacked = words.listed(
                words.differences(advice.repair.explained.differences, outcome.task.robot)
            )
            same = any(advice.policy is each.tried.policy for each in outcome.rounds[:at])
            following = "" if same else words.promised(advice.foreseen)
        rows.append(
            {
                "number": at,
                "origin": words.ORIGINS.get(tried.origin, tried.origin),
                "loss": number(tried.experience.loss),
                "outcome": words.outcome_of(done),
                "gate": gate,
                "lacked": lacked,
                "next": following,
                "seconds": number(done.seconds),
            }
        )
    return rows


def _scores(outcome: LoopOutcome) -> list[JSON]:
    judged = outcome.judged
    if judged is None:
        return []
    scores = judged.scores()
    named: list[tuple[str, Score | None, str]] = [
        ("to keep", judged.final, "final"),
        ("the source's", judged.source, "zero_shot"),
        ("holding still", judged.still, "hold_still"),
        ("oracle", judged.oracle, "oracle"),
    ]
    return [
        {
            "name": name,
            "loss": number(each.mean),
            "success": percent(each.share),
            "score": "" if (mark := scores[score]) is None else f"{mark:.2f}",
        }
        for name, each, score in named
        if each is not None
    ]


def _foretold(outcome: LoopOutcome) -> list[JSON]:
    named = "Trial" if outcome.rounds else "Recording"
    return [
        {
            "title": f"{named} {at + 1}",
            "joints": [
                {"plot": each.plot, "text": _error(each)} for each in drawn.foretold(outcome, at)
            ],
        }
        for at in range(len(outcome.runs))
    ]


def _error(each: drawn.TrialPrediction) -> str:
    pairs = (("as described", each.described), ("repaired", each.repaired))
    lines = [
        f"{number(value) if np.isfinite(value) else 'without bound'} {each.unit} {name}"
        for name, value in pairs
        if value is not None
    ]
    return f"Error: {', '.join(lines)}." if lines else "No model can run here."


def _provenance(record: JSON) -> list[tuple[str, str]]:
    made = record["provenance"]
    return [
        ("morph", made["morph"]),
        ("mujoco", made["mujoco"]),
        ("task", record["task"]["sha256"]),
        ("robot", record["robot"]["sha256"]),
    ]
