"""The report of an alignment: one page without scripts, the parts with arrows first."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from morph.app.report.align import arrows, words
from morph.app.report.align.outcome import Aligned
from morph.app.report.learn.page import POLICY
from morph.app.report.templates import environment
from morph.policy_transfer.parts import Parts

FOLDER = Path(__file__).parent

Table = tuple[str, tuple[str, str], list[tuple[str, str]]]
"""Title, heads and rows of a table of arrows."""


def align_page(result: Aligned) -> str:
    """Return the report as one HTML page."""
    source, target = result.source.body, result.target.body
    return environment(FOLDER).get_template("page.html.j2").render(
        o=result,
        policy=POLICY,
        style=Markup(style()),
        headline=words.headline(result),
        summary=words.summary(result),
        drawn=arrows.drawn(result.parts, source, target),
        tables=tables(result.parts, source, target),
        lost=words.lost_said(result.parts, target),
        quality=words.quality_rows(result.quality),
        provenance=_provenance(result),
    )  # fmt: skip


def style(*more: Path) -> str:
    """Return the style sheets of reports, those of arrows and any more."""
    report = FOLDER.parent
    sheets = (
        report / "page.css", report / "learn" / "page.css", report / "loop" / "page.css",
        FOLDER / "page.css", *more,
    )  # fmt: skip
    return "".join(sheet.read_text(encoding="utf-8") for sheet in sheets)


def tables(parts: Parts, source: str, target: str) -> list[Table]:
    """Return the arrows of the states and of the commands in figures."""
    return [
        ("States", (f"of {source}", f"made of {target}'s"), list(words.made_of(parts.states))),
        ("Commands", (f"of {target}", f"made of {source}'s"), list(words.made_of(parts.commands))),
    ]


def _provenance(result: Aligned) -> list[tuple[str, str]]:
    made = result.said()["provenance"]
    return [("morph", made["morph"]), ("mujoco", made["mujoco"]), *sorted(made["inputs"].items())]
