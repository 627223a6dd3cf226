"""Sentences whose figures come from result files."""

from __future__ import annotations

import pytest

from experiments.figures.templates import literal_figures, names_in, render
from morph.errors import StudyError

RESULTS = {
    "one": {
        "figures": {"loss": 1.23456, "count": 7, "found": "dry friction"},
        "controls": {"always accept": {"loss": 9.5}},
        "settings": {"seeds": 20, "list": [1, 2]},
    }
}


def test_a_placeholder_is_written_as_its_format_says() -> None:
    text = "{one.loss:.2f} of {one.count}, {one.found}"
    assert render(text, RESULTS) == "1.23 of 7, dry friction"


def test_controls_and_settings_are_reached_by_their_paths() -> None:
    text = "{one.controls.always accept.loss} in {one.settings.seeds} seeds"
    assert render(text, RESULTS) == "9.5 in 20 seeds"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{two.loss}", "there is no result 'two'"),
        ("{one.lost}", "result 'one' has no 'lost'; its figures are count, found, loss"),
        ("{one.controls.never.loss}", "has no 'never'"),
        ("{one.settings.list}", "is no single value"),
        ("{one}", "is no single value"),
        ("{one.found:.2f}", "cannot be written as '.2f'"),
    ],
)
def test_a_placeholder_without_its_figure_is_refused(text: str, said: str) -> None:
    with pytest.raises(StudyError, match=said):
        render(text, RESULTS)


@pytest.mark.parametrize(
    ("text", "loose"),
    [
        ("off by {one.loss:.2f} rad", []),
        ("off by 0.03 rad", ["0.03"]),
        ("98% of {one.count}", ["98%"]),
        ("three of {one.count}", ["three"]),
        ("Half of them, none lost", ["Half", "none"]),
        ("{one.count} of 7", ["7"]),
        ("x2 as long", ["x2"]),
        ("SO-101 by its R2", []),
        ("SO-1012", ["SO-1012"]),
        ("R2 of 2", ["2"]),
        ("sixteen, seventy, twice", ["sixteen", "seventy", "twice"]),
        ("one of them", []),
        ("tone, often, weighty, attend", []),
    ],
)
def test_a_figure_outside_a_placeholder_is_named(text: str, loose: list[str]) -> None:
    assert literal_figures(text, frozenset({"SO-101", "R2"})) == loose


def test_the_results_of_a_template_are_known_without_them() -> None:
    assert names_in("{one.loss:.2f}, {two.controls.a b.c} and no other") == {"one", "two"}


def test_an_open_brace_is_refused() -> None:
    with pytest.raises(StudyError, match="is no template"):
        literal_figures("{one.loss", frozenset())
