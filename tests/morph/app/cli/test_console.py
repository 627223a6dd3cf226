from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from morph.app.cli.console import TIE, broken, cells, harmless, paragraph, say, table, width

TEXTS = st.text(max_size=60)
NAMES = st.text("abc_-/ 関é", min_size=1, max_size=40)


@given(text=TEXTS)
def test_cells_are_counted_as_a_terminal_does(text: str) -> None:
    shown = harmless(text)
    assert cells(shown) == cell_len(shown)


@given(text=TEXTS)
def test_what_is_harmless_is_printable_and_stays_so(text: str) -> None:
    shown = harmless(text)
    assert shown.replace(TIE, " ").isprintable()
    assert harmless(shown) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain", "plain"),
        ("Größe", "Größe"),
        ("\x1b[31m", "\\x1b[31m"),
        ("a\nb", "a\\nb"),
        ("\u202e", "\\u202e"),
        ("\ud800", "\\ud800"),
    ],
)
def test_what_a_terminal_obeys_is_escaped(text: str, shown: str) -> None:
    assert harmless(text) == shown


def test_what_nobody_reads_to_its_end_is_cut_and_says_so() -> None:
    assert harmless("x" * 5000, 10) == "xxxxxxxxxx... (5000 letters)"


@given(text=NAMES, size=st.integers(4, 30))
def test_pieces_fit_and_lose_nothing_but_spaces(text: str, size: int) -> None:
    pieces = list(broken(text, size))
    assert max(map(cells, pieces)) <= size
    assert "".join(pieces).replace(" ", "") == text.replace(" ", "")


def test_a_name_is_broken_where_it_has_a_joint() -> None:
    assert list(broken("left_roll_to_pitch_assembly", 20)) == ["left_roll_to_pitch_", "assembly"]
    assert list(broken("package://meshes/left_arm.stl", 20)) == [
        "package://meshes/",
        "left_arm.stl",
    ]
    assert list(broken("a sentence of words", 11)) == ["a sentence", "of words"]
    assert list(broken("x" * 25, 10)) == ["x" * 10, "x" * 10, "x" * 5]


def test_a_paragraph_hangs_and_ties_hold() -> None:
    text = f"  joint one{TIE}(line{TIE}3), two{TIE}(line{TIE}4)"
    assert paragraph(text, 6, 24) == ["  joint one (line 3),", "      two (line 4)"]
    assert paragraph(text, 6, None) == ["  joint one (line 3), two (line 4)"]


def test_a_table_folds_its_widest_column_and_drops_what_is_empty() -> None:
    rows = [("left_roll_to_pitch_assembly", "", "1"), ("b", "", "22")]
    assert table(("link", "nothing", "kg"), rows, columns=None) == [
        "link                         kg",
        "left_roll_to_pitch_assembly  1",
        "b                            22",
    ]
    assert table(("link", "nothing", "kg"), rows, columns=24) == [
        "link                  kg",
        "left_roll_to_pitch_   1",
        "assembly",
        "b                     22",
    ]


@given(rows=st.lists(st.tuples(NAMES, NAMES), min_size=1, max_size=5), columns=st.integers(40, 90))
def test_a_table_fits_its_terminal(rows: list[tuple[str, str]], columns: int) -> None:
    lines = table(("one", "other"), rows, columns=columns)
    assert max(map(cells, lines)) <= columns
    assert all(line == line.rstrip() for line in lines)


@pytest.mark.parametrize("variable", ["COLUMNS", "LINES"])
@pytest.mark.parametrize("told", ["0", "-1", "", "wide", "\u00b2", "9" * 30])
def test_a_terminal_that_tells_no_sensible_size_shows_all_lines(
    variable: str, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setenv(variable, told)
    long = "word " * 100 + "end"
    say([("head", "bold"), (long, ""), ("", "")])
    assert capsys.readouterr().out == f"head\n{long}\n\n"
    # Nothing but a terminal has a width, and the test has none.
    assert width() is None
