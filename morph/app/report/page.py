"""The report: one page that needs no network and says the finding in words first."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import partial
from pathlib import Path
from typing import Any

from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

from morph.app.report import tracks, words
from morph.app.report.curves import curves, episodes_drawn
from morph.app.report.templates import environment
from morph.arrays import JSON
from morph.inference.findings import SURE
from morph.model.diagnosis import Diagnosis
from morph.model.finding import Finding

FOLDER = Path(__file__).parent
MANY = 8
"""Names in a list before it is folded."""


def report_page(diagnosis: Diagnosis) -> str:
    """Return the report as one HTML page.

    The page loads nothing, and its own policy forbids browsers to do so: only
    the scripts whose hashes it names may run. Names from files are escaped
    wherever they stand.
    """
    scripts = _scripts(diagnosis)
    hashes = " ".join(f"'sha256-{_hash(script)}'" for script in scripts)
    return environment(FOLDER).get_template("page.html.j2").render(
        d=diagnosis,
        style=Markup(_read("page.css")),
        plots=htmlsafe_json_dumps(curves(diagnosis), dumps=_dumps),
        scripts=[Markup(script) for script in scripts],
        policy=f"default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; "
        f"script-src {hashes or chr(39) + 'none' + chr(39)}; base-uri 'none'; form-action 'none'",
        findings=[_finding(finding) for finding in diagnosis.findings],
        table=_table(diagnosis),
        episodes=episodes_drawn(diagnosis),
        channels=[
            {"name": name, "unit": unit} for name, unit in words.units(diagnosis).items()
        ],
        left_out=len({t.episode for t in diagnosis.traces}) - len(episodes_drawn(diagnosis)),
        models=_models(diagnosis),
        provenance=list(_flat(diagnosis.provenance)),
        **_functions(diagnosis),
    )  # fmt: skip


def _functions(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return what the template calls by name."""
    return {
        "headline": words.headline(diagnosis),
        "improvement": words.improvement(diagnosis),
        "remains": words.remains(diagnosis),
        "rollouts": words.rollouts(diagnosis.horizon),
        "refit": tracks.refit_intervals(diagnosis),
        "strips": tracks.strips(diagnosis),
        "number": words.number,
        "percent": words.percent,
        "surest": SURE,
        "plain": words.plain,
        "answer": words.answer,
        "counted": words.counted,
        "many": MANY,
    }


_dumps = partial(json.dumps, allow_nan=False, separators=(",", ":"))


def _read(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def _hash(script: str) -> str:
    """Return a script's SHA-256 as a content security policy spells it."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _scripts(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the scripts of a page with plots; a page without has none."""
    if not diagnosis.traces:
        return ()
    from plotly.offline import get_plotlyjs  # Only a page with plots waits for it.

    return get_plotlyjs(), _read("page.js")


def _finding(finding: Finding) -> JSON:
    effect = finding.effect
    return {
        "title": _place(effect.name, effect.kind, effect.where),
        "statement": finding.said,
        "probability": finding.probability,
        "gain": finding.gain,
        "intervals": tracks.parameter_intervals(finding),
        "episodes": finding.episodes,
        "rivals": finding.rivals,
        "twins": effect.twins,
        "separate_by": finding.separate_by,
    }


def _place(effect: str, kind: str, where: str) -> str:
    name = words.plain(effect)
    return f"{name[:1].upper()}{name[1:]} at {kind} {where}"


def _models(diagnosis: Diagnosis) -> list[JSON]:
    """Return the models that are plotted, by the names and styles that the page gives them."""
    drawn = dict.fromkeys(model for trace in diagnosis.traces for model in trace.models)
    return [{"key": key, "name": words.MODELS.get(key, words.plain(key))} for key in drawn]


def _table(diagnosis: Diagnosis) -> JSON:
    """Return the held-out errors, a row a channel and a column a model."""
    errors = diagnosis.held_out_rmse
    models = [model for model in words.MODELS if model in errors]
    units = words.units(diagnosis)
    return {
        "models": [words.MODELS[model] for model in models],
        "rows": [
            {
                "channel": channel,
                "unit": units.get(channel, ""),
                "errors": [
                    words.number(errors[m][channel]) if channel in errors[m] else "–"
                    for m in models
                ],
                "smaller": _times_smaller(diagnosis, channel),
            }
            for channel in words.channels(diagnosis)
        ],
    }


def _times_smaller(diagnosis: Diagnosis, channel: str) -> str:
    """Return how many times smaller the corrected model's error is."""
    nominal = diagnosis.held_out_rmse.get("nominal", {}).get(channel)
    corrected = diagnosis.held_out_rmse.get("corrected", {}).get(channel)
    if diagnosis.verdict != "mismatch" or not nominal or not corrected:
        return ""
    return f"{nominal / corrected:.1f} times" if nominal < float("inf") else ""


def _flat(values: JSON, above: str = "") -> list[tuple[str, str]]:
    """Return nested names and values as rows; commands have places of their own."""
    rows: list[tuple[str, str]] = []
    for key, value in values.items():
        name = f"{above}{words.plain(str(key))}"
        if isinstance(value, dict):
            rows += _flat(value, f"{name}: ")
        elif above or key not in {"command", "plan"}:
            joined = ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
            rows.append((name, joined))
    return rows
