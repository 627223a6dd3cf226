"""The report of a search: one page without scripts that says the verdict in words first."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup

from morph.app.report.learn import drawn, words
from morph.app.report.learn.outcome import LearnOutcome, as_json, robot_hash, settings
from morph.app.report.learn.strip import Still
from morph.app.report.learn.words import number
from morph.app.report.templates import environment
from morph.app.report.words import percent
from morph.arrays import JSON, Array
from morph.search.search import Trial

FOLDER = Path(__file__).parent

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'none'; "
    "base-uri 'none'; form-action 'none'"
)
"""What the page forbids browsers to do: it loads nothing and runs nothing."""

MOST_TRIALS = 200
"""Trials in the table."""

MOST_EFFECTS = 12
"""Effects that are named before the rest is counted: a swimmer has one for each link."""


def learned_page(outcome: LearnOutcome, stills: Sequence[Still], see: str) -> str:
    """Return the report as one HTML page.

    Args:
        outcome: What was found.
        stills: Pictures of the typical run; none if this machine cannot draw.
        see: The command that shows the policy.
    """
    return environment(FOLDER).get_template("page.html.j2").render(
        o=outcome,
        judged=outcome.judged,
        policy=POLICY,
        style=Markup(_read(FOLDER.parent / "page.css") + _read(FOLDER / "page.css")),
        headline=words.headline(outcome),
        summary=words.summary(outcome),
        why=f"{outcome.why[:1].upper()}{outcome.why[1:].rstrip('.')}." if outcome.why else "",
        stills=stills,
        see=see,
        learning=drawn.learning(outcome),
        joints=drawn.joints(outcome),
        commands=drawn.commands(outcome),
        many=drawn.MOST_PLOTS,
        trials=_some(outcome.trials),
        scores=_scores(outcome),
        terms=_terms(outcome),
        effects=_effects(outcome),
        settings=[f"{name} {value}" for name, value in settings(outcome.search).items()],
        provenance=_provenance(outcome),
        number=number,
        percent=percent,
    )  # fmt: skip


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _some(trials: Sequence[Trial]) -> list[Trial]:
    if len(trials) <= MOST_TRIALS:
        return list(trials)
    return [trials[at] for at in np.linspace(0, len(trials) - 1, MOST_TRIALS).round().astype(int)]


def _scores(outcome: LearnOutcome) -> list[JSON]:
    rows: list[tuple[str, Array, float]] = [
        ("learned", outcome.judged.loss, outcome.judged.share),
        *(
            (words.NAMED.get(name, name), score.loss, score.share)
            for name, score in outcome.judged.controls.items()
        ),
    ]
    taken = (np.mean, np.median, np.min, np.max)
    return [
        {"name": name, "figures": [*(number(float(of(loss))) for of in taken), percent(share)]}
        for name, loss, share in rows
    ]


def _terms(outcome: LearnOutcome) -> list[JSON]:
    """Return what each term costs, the dearest first."""
    costs = sorted(outcome.judged.terms.items(), key=lambda each: -each[1])
    total = sum(cost for _, cost in costs)
    return [
        {
            "name": name,
            "share": cost / total if total > 0.0 else 0.0,
            "text": number(cost) + (f" ({percent(cost / total)})" if total > 0.0 else ""),
        }
        for name, cost in costs
    ]


def _effects(outcome: LearnOutcome) -> str:
    labels = [effect.label for effect in outcome.task.effects]
    more = len(labels) - MOST_EFFECTS
    return ", ".join(labels[:MOST_EFFECTS]) + (f" and {more} more" if more > 0 else "")


def _provenance(outcome: LearnOutcome) -> list[tuple[str, str]]:
    versions = as_json(outcome)["provenance"]
    return [
        ("morph", versions["morph"]),
        ("mujoco", versions["mujoco"]),
        ("task", outcome.task.sha256),
        ("robot", robot_hash(outcome.task)),
    ]
