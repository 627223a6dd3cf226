"""The numbers of an MJCF, before MuJoCo sees them: none is infinite, NaN or absurd."""

from __future__ import annotations

import math

from morph.body.finding import DescriptionFinding, Where
from morph.body.mjcf_draft import ElementLines
from morph.body.refusal import refusal
from morph.body.xml import Element

LARGEST = 1e30
"""Greatest number: its fifth power, of which inertias are made, is still a number."""

LONGEST_NAME = 1000
"""Letters beyond which a text is not looked for among the names."""

LETTERS = frozenset("eEnNiI")
"""A word that holds none of these has no exponent, and is no `nan` and no `inf`."""

RANGES = {
    "range": "limited",
    "ctrlrange": "ctrllimited",
    "forcerange": "forcelimited",
    "actfrcrange": "actfrclimited",
    "actuatorfrcrange": "actuatorfrclimited",
}
"""Attributes that may say that there is no limit, and those by which MJCF itself says so."""


def check_numbers(tree: Element, lines: ElementLines) -> list[DescriptionFinding]:
    """Take limits that are infinite out of an MJCF; return what was found.

    Raises:
        DescriptionRefused: Another number is not finite, or larger than any number of
            a robot.
    """
    names = {element.get("name", "") for element in tree.everything()}
    findings: list[DescriptionFinding] = []
    for element in tree.everything():
        for key, text in list(element.attrib.items()):
            if len(text) < LONGEST_NAME and text in names:
                continue
            absurd = [word for word in text.split() if _is_absurd(word)]
            if not absurd:
                continue
            if key not in RANGES or any(math.isnan(float(word)) for word in absurd):
                raise refusal([*findings, _refused(element, key, absurd[0], lines)])
            del element.attrib[key]
            element.set(RANGES[key], "false")
            findings.append(_unlimited(element, key, text, lines))
    return findings


def _is_absurd(word: str) -> bool:
    if len(word) < 25 and not LETTERS.intersection(word):
        return False
    try:
        return not abs(float(word)) <= LARGEST
    except ValueError:
        return False  # No number at all: MuJoCo says where one is due.


def _where(element: Element, lines: ElementLines) -> Where:
    tag = {"body": "link", "freejoint": "joint"}.get(element.tag, element.tag)
    file = element.file or lines.file
    return Where(kind=tag, name=element.get("name", ""), file=file, line=element.line)


def _refused(element: Element, key: str, word: str, lines: ElementLines) -> DescriptionFinding:
    return DescriptionFinding(
        code="ill-typed",
        severity="refused",
        where=_where(element, lines),
        what=f"<{element.tag}> has {word[:40]} in its {key}, which is no number of a robot's",
        fix=f"write {key} in finite numbers",
    )


def _unlimited(element: Element, key: str, text: str, lines: ElementLines) -> DescriptionFinding:
    return DescriptionFinding(
        code="limit-absurd",
        severity="repaired",
        where=_where(element, lines),
        what=f"its {key} is {text[:80]}",
        done="it was taken as having none",
        fix=f"write {key} in finite numbers, or leave it out",
    )
