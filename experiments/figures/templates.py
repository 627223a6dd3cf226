"""Templates of sentences: figures come from result files by placeholders, and from nowhere else."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from string import Formatter
from typing import Any

from morph.arrays import JSON
from morph.errors import StudyError

NUMERALS = re.compile(
    r"\b(two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|\w+teen|twenty|thirty|forty|"
    r"fifty|sixty|seventy|eighty|ninety|hundred|thousand|million|dozen|none|zero|half|twice|"
    r"third|quarter)\b",
    re.IGNORECASE,
)
"""Numbers spelled out."""
FIX = "take the figure from a result file: {result.figure:.3f}"


def literal_figures(template: str, words: frozenset[str]) -> list[str]:
    """Return every figure of a template that stands outside a placeholder.

    A word with a digit in it, and a number spelled out, is a figure unless it is one of
    `words`: names such as SO-101, which begin with a letter.

    Raises:
        StudyError: The template is malformed.
    """
    literal = " \N{OBJECT REPLACEMENT CHARACTER} ".join(text for text, _ in _pieces(template))
    for word in sorted(words, key=len, reverse=True):
        # Longer names first, so that a short one does not leave half of a long one.
        literal = re.sub(rf"(?<![\w.]){re.escape(word)}(?!\w)(?!\.\d)", "", literal)
    digits = re.findall(r"\S*\d\S*", literal)
    return digits + [match.group() for match in NUMERALS.finditer(literal)]


def names_in(template: str) -> set[str]:
    """Return the names of the results that a template states figures of."""
    return {field.partition(".")[0] for _, field in _pieces(template) if field}


def render(template: str, results: Mapping[str, JSON]) -> str:
    """Return a template with every placeholder filled from the results.

    `{name.figure:.2f}` is a headline figure, `{name.controls.shuffled.figure}` any other
    path of the file, such as `settings` and `seeds`.

    Raises:
        StudyError: A placeholder names no result or no figure, or its format does not fit.
    """
    return "".join(_filled(template, results))


def _filled(template: str, results: Mapping[str, JSON]) -> Iterator[str]:
    for text, field, form, _ in Formatter().parse(template):
        yield text
        if field is None:
            continue
        value = lookup(field, results)
        try:
            yield format(value, form or "")
        except (ValueError, TypeError) as error:
            raise StudyError(
                f"{value!r} cannot be written as {form!r}", where=f"{{{field}}}", fix=str(error)
            ) from error


def lookup(field: str, results: Mapping[str, JSON]) -> Any:
    """Return the value that a placeholder names.

    Raises:
        StudyError: There is no such result or figure, or it is not a single value.
    """
    name, *path = field.split(".")
    if name not in results:
        raise StudyError(f"there is no result {name!r}", where=f"{{{field}}}", fix=FIX)
    result = results[name]
    value: Any = result
    if len(path) == 1 and path[0] in result["figures"]:
        value = result["figures"][path[0]]
    else:
        for key in path:
            if not isinstance(value, Mapping) or key not in value:
                known = ", ".join(sorted(result["figures"]))
                raise StudyError(
                    f"result {name!r} has no {key!r}; its figures are {known}",
                    where=f"{{{field}}}",
                    fix="name one of them, or run the study again with --save",
                )
            value = value[key]
    if not isinstance(value, (str, int, float)) or not path:
        raise StudyError(f"{field!r} is no single value", where=f"{{{field}}}", fix=FIX)
    return value


def _pieces(template: str) -> Iterator[tuple[str, str | None]]:
    try:
        for text, field, _, _ in Formatter().parse(template):
            yield text, field
    except ValueError as error:
        raise StudyError(
            f"is no template: {error}", where=template, fix="close every brace; write {{ for {"
        ) from error
