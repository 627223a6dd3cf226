"""The tables of README and experiments/README, rendered from the catalogue and the result files."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.figures.catalogue import CATALOGUE, PYTHON, Study, load_catalogue
from experiments.figures.result_file import RESULTS, ROOT, is_stale, load_result, result_path
from experiments.figures.templates import FIX, literal_figures, names_in, render
from morph.arrays import JSON
from morph.errors import StudyError

DAGGER = "\N{DAGGER}"
FOOTNOTE = (
    f"{DAGGER} measured by earlier code; `make results` prints the command that measures it anew."
)
BEGIN, END = "<!-- figures: begin {} -->", "<!-- figures: end {} -->"
README = f"| | morph | baseline | command (`{PYTHON} ...`) |\n|---|---|---|---|"
STUDIES = "| study | what it answers | headline | command | measured |\n|---|---|---|---|---|"
WAITING = "| study | what it answers | command | minutes, in an earlier run |\n|---|---|---|---|"


def load_results(studies: Sequence[Study], folder: Path = RESULTS) -> dict[str, JSON]:
    """Return the results that exist, by name.

    Raises:
        StudyError: A file is damaged, or its command is not that of the catalogue.
    """
    results = {}
    for study in studies:
        path = result_path(study.name, folder)
        if not path.exists():
            continue
        results[study.name] = result = load_result(path)
        if result["command"] != study.command:
            raise StudyError(
                f"was made by {result['command']!r}, while the catalogue has {study.command!r}",
                where=str(path),
                fix=f"run {PYTHON} {study.command} --save",
            )
    return results


def check_templates(studies: Sequence[Study], words: frozenset[str]) -> None:
    """Check that no template states a figure outside a placeholder, or names an unknown study.

    Raises:
        StudyError: A template does, or one of `words` does not begin with a letter.
    """
    names = {study.name for study in studies}
    for word in words:
        if not word[:1].isalpha():
            raise StudyError(
                f"{word!r} is a figure, not a name",
                where="figures.toml: words",
                fix="words begin with a letter",
            )
    for study in studies:
        rows = [text for row in study.readme for text in (row.question, row.figure, row.baseline)]
        for text in (study.answers, study.headline, *rows):
            where = f"figures.toml: {study.name}: {text!r}"
            if literal := literal_figures(text, words):
                raise StudyError(
                    f"{literal[0]!r} stands outside a placeholder", where=where, fix=FIX
                )
            if unknown := names_in(text) - names:
                raise StudyError(
                    f"{min(unknown)!r} is no study", where=where, fix="name one of figures.toml"
                )


def provenance(result: JSON, *, stale: bool = False) -> str:
    """Return the date and commit of a result, with a dagger if it is stale."""
    commit = (result["commit"] or "no commit")[:7]
    changed = ", tree changed" if result["dirty"] else ""
    return f"{result['date']}, {commit}{changed}{f' {DAGGER}' if stale else ''}"


def readme_table(studies: Sequence[Study], results: Mapping[str, JSON]) -> str:
    """Return README's table: the rows whose every figure has a result file."""
    old = {name for name, result in results.items() if is_stale(result)}
    lines = [README]
    for study in studies:
        for row in study.readme:
            texts = (row.question, row.figure, row.baseline)
            names = names_in("".join(texts)) | {study.name}
            if names <= results.keys():
                cells = [render(text, results) for text in texts]
                mark = f" {DAGGER}" if names & old else ""
                lines.append(_row(*cells, f"`{study.command}`{mark}"))
    return _with_footnote(lines)


def studies_table(studies: Sequence[Study], results: Mapping[str, JSON]) -> str:
    """Return the table of all studies: those with a result, then those without."""
    old = {name for name, result in results.items() if is_stale(result)}
    lines, waiting = [STUDIES], [WAITING]
    for study in studies:
        link = f"[`{study.name}`](notes/{study.notes}.md)"
        command = f"`{PYTHON} {study.command}`"
        names = names_in(study.answers + study.headline) | {study.name}
        if names <= results.keys():
            source = provenance(results[study.name], stale=bool(names & old))
            cells = (render(study.answers, results), render(study.headline, results))
            lines.append(_row(link, *cells, command, source))
        else:
            # Without a result the sentence stands without its figures.
            sentence = re.sub(r"\{[^}]*\}", "…", study.answers)
            minutes = "unknown" if study.minutes is None else f"{study.minutes:g}"
            waiting.append(_row(link, sentence, command, minutes))
    table = _with_footnote(lines)
    if len(waiting) == 1:
        return table
    return "\n".join([table, "", "No result file yet:", "", *waiting])


def _with_footnote(lines: Sequence[str]) -> str:
    marked = any(DAGGER in line for line in lines)
    return "\n".join([*lines, "", FOOTNOTE] if marked else lines)


def replace_between(text: str, name: str, table: str, where: str) -> str:
    """Return a page with the text between its markers replaced by a table.

    Args:
        text: The page.
        name: Name in the markers.
        table: The new text.
        where: Path of the page, for the message.

    Raises:
        StudyError: A marker is missing or stands twice.
    """
    begin, end = BEGIN.format(name), END.format(name)
    if text.count(begin) != 1 or text.count(end) != 1 or text.index(begin) > text.index(end):
        raise StudyError(
            f"needs {begin} and {end}, once each", where=where, fix="put them back around the table"
        )
    head, _, rest = text.partition(begin)
    return f"{head}{begin}\n{table}\n{end}{rest.partition(end)[2]}"


def pages(
    root: Path = ROOT, *, catalogue: Path = CATALOGUE, folder: Path = RESULTS
) -> dict[Path, str]:
    """Return the text of every page as `make figures` writes it, by its path.

    Raises:
        StudyError: A template, a result or a page cannot be used.
    """
    studies, words = load_catalogue(catalogue)
    check_templates(studies, words)
    results = load_results(studies, folder)
    tables = {
        root / "README.md": readme_table(studies, results),
        root / "experiments" / "README.md": studies_table(studies, results),
    }
    return {
        path: replace_between(path.read_text(encoding="utf-8"), "table", table, str(path))
        for path, table in tables.items()
    }


def why_run(study: Study, folder: Path = RESULTS) -> str:
    """Return why a study must be run: its result is `missing`, `damaged` or `stale`; else ""."""
    try:
        results = load_results([study], folder)
    except StudyError:
        return "damaged"
    if study.name not in results:
        return "missing"
    return "stale" if is_stale(results[study.name]) else ""


def stale_results(catalogue: Path = CATALOGUE, folder: Path = RESULTS) -> list[str]:
    """Return the names of the results whose code has changed since."""
    results = load_results(load_catalogue(catalogue)[0], folder)
    return [name for name, result in results.items() if is_stale(result)]


def _row(*cells: str) -> str:
    return "| " + " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in cells) + " |"
