"""What `morph align` says at the terminal: the parts with arrows, the quality, the verdict."""

from __future__ import annotations

from collections.abc import Iterator

from morph.app.cli.align_arguments import Align
from morph.app.cli.console import harmless, paragraph, table, width
from morph.app.report.align.outcome import Aligned
from morph.app.report.align.words import headline, lost_said, quality_rows, summary
from morph.policy_transfer.parts import Arrow, Parts

BAR = 10
"""Letters of an arrow whose share is one."""


def lines(options: Align, result: Aligned) -> Iterator[tuple[str, str]]:
    """Yield each line of the answer and its style."""
    columns = width()
    yield harmless(headline(result)), "bold"
    for sentence in summary(result):
        for line in paragraph(f"  {harmless(sentence)}", 4, columns):
            yield line, "yellow" if result.guard.verdict == "unsafe" else ""
    yield from arrows(result.parts, result.source.body, result.target.body, columns)
    yield "how good the map is:", "bold"
    rows = [(harmless(name), value) for name, value in quality_rows(result.quality)]
    for line in table(("what", "figure"), rows, columns=columns, right=("figure",))[1:]:
        yield f"  {line}", ""
    for note in result.notes:
        for line in paragraph(f"  {harmless(note)}", 4, columns):
            yield line, "yellow"
    if options.out is not None:
        wrote = f"wrote align.json, report.html and the map into {options.out}"
        for line in paragraph(harmless(wrote), 4, columns):
            yield line, ""


def arrows(
    parts: Parts, source: str, target: str, columns: int | None
) -> Iterator[tuple[str, str]]:
    """Yield the arrows of a map as lines with their styles."""
    titles = (
        (f"states of {target} as those of {source}:", parts.states),
        (f"commands of {target} as those of {source}:", parts.commands),
    )
    for title, each in titles:
        if each:
            yield harmless(title), "bold"
            head = ("from", "arrow", "to", "share")
            for line in table(head, [_row(a) for a in each], columns=columns)[1:]:
                yield f"  {line}", ""
    if lost := lost_said(parts, target):
        for line in paragraph(f"  {harmless(lost)}", 4, columns):
            yield line, ""


def _row(arrow: Arrow) -> tuple[str, str, str, str]:
    """Return an arrow from what is looked at to what is made of it, as long as it is strong."""
    long = max(1, round(BAR * abs(arrow.weight)))
    stroke = "=" if arrow.weight > 0.0 else "-"
    sign = "+" if arrow.weight > 0.0 else "-"
    share = f"{sign}{100.0 * abs(arrow.weight):.0f} %"
    return harmless(arrow.begin), f"{stroke * long}>", harmless(arrow.end), share
