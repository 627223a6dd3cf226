"""Cards name the licence of public files, and NOTICE attributes what asks for it."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from pathlib import Path

import pytest

from morph.body import shelf
from morph.body.card import Citation, load_card

ROOT = Path(__file__).parents[2]
NOTICE = " ".join((ROOT / "NOTICE").read_text().split())
CARDS = tuple(sorted(shelf.builtin_shelf().glob("*/card.toml")))
SOURCES = [(path.parent.name, source) for path in CARDS for source in load_card(path).source]

PUBLIC = (
    r"\bat ([0-9a-f]{7,40})\b",
    r"(?<![\w./])(?:github\.com/)?([A-Za-z][\w.-]*/[A-Za-z0-9][\w.-]*)(?= at [0-9a-f]{7}|, \w+/)",
    r"\bgithub\.com/([\w.-]+/[\w.-]+)",
    r"\b(\w+\.wikipedia\.org/[\w.-]+/[\w.-]+)",
)
"""How a source names a file of someone's repository or wiki."""

OPEN = {"Apache-2.0", "BSD-3-Clause", "CC-BY-SA-3.0", "CC-BY-SA-4.0", "LicenseRef-BSD", "MIT"}
HEADINGS = {
    "CC-BY-SA-3.0": "CC BY-SA 3.0 (https://creativecommons.org/licenses/by-sa/3.0/)",
    "CC-BY-SA-4.0": "CC BY-SA 4.0 (https://creativecommons.org/licenses/by-sa/4.0/)",
    "LicenseRef-BSD": "LicenseRef-BSD",
    "NOASSERTION": "No licence stated (NOASSERTION",
}


def places(source: Citation) -> set[str]:
    """Return the repositories, pages and commits that a source names."""
    return {place for shape in PUBLIC for place in re.findall(shape, source.from_)}


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("owner/robot at f21ff7e, joint origins", {"owner/robot", "f21ff7e"}),
        ("The same robot.xml at f21ff7e", {"f21ff7e"}),
        ("as measured in github.com/owner/robot, whose", {"owner/robot"}),
        ("Owner/Robot, assets/robot.xml", {"Owner/Robot"}),
        ("en.wikipedia.org/wiki/Board", {"en.wikipedia.org/wiki/Board"}),
        ("Winter 2009, figure 4.1; sealed at 0.7 bar", set()),
        ("Chosen for morph, as on robots/so101, whose card has them", set()),
        ("maker.com/robots/servo, page 3", set()),
    ],
)
def test_a_public_file_is_told_from_a_publication(words: str, named: set[str]) -> None:
    assert places(Citation(what="numbers", from_=words)) == named


def test_every_number_from_a_public_file_names_its_licence() -> None:
    silent = [(name, one.what) for name, one in SOURCES if places(one) and not one.licence]
    assert silent == []
    # And the rule sees the shelf: nine repositories and a page of Wikipedia.
    repositories = {place for _, one in SOURCES for place in places(one) if "/" in place}
    assert len(repositories) >= 10


def test_notice_names_every_public_file_under_its_licence() -> None:
    sections = re.split(r"\n(?=\S[^\n]*\n\n  )", (ROOT / "NOTICE").read_text())
    for name, source in SOURCES:
        if not source.licence:
            continue
        assert source.licence in OPEN | {"NOASSERTION"}, (name, source.licence)
        heading = HEADINGS.get(source.licence, source.licence)
        (section,) = (each for each in sections if heading in each.split("\n\n")[0])
        named = [place for place in places(source) if place in section]
        assert named, (name, source.from_, section)
        takers = re.findall(r"robots/([\w*]+)", section)
        assert any(fnmatch(name, taker) for taker in takers), (name, section)


def test_a_card_whose_numbers_are_share_alike_says_so_of_its_folder() -> None:
    for path in CARDS:
        card = load_card(path)
        asked = any(one.licence.startswith("CC-BY-SA-") for one in card.source)
        # Version 3.0 lets what is adapted be shared under a later version.
        due = {"Apache-2.0", "CC-BY-SA-4.0"} if asked else {"Apache-2.0"}
        assert set(card.licence.split(" AND ")) == due, path.parent.name


def test_no_number_comes_from_a_file_under_the_gpl_or_without_commercial_use() -> None:
    assert {one.licence for _, one in SOURCES} <= OPEN | {"", "NOASSERTION"}


def test_the_attribution_of_poppy_has_what_its_licence_asks_for() -> None:
    # Section 3(a) of the licence: creators, a link to the material, the licence, and changes.
    for asked in (
        "Matthieu Lapeyre",
        "https://github.com/poppy-project/poppy-humanoid at d66c8fb",
        "https://creativecommons.org/licenses/by-sa/4.0/",
        "Changed: ",
    ):
        assert asked in NOTICE
