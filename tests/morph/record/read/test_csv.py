"""CSV files against Python's own `csv` and `float`."""

from __future__ import annotations

import csv
import io
import math
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from morph.errors import RecordingError
from morph.record.read import csv as reader
from morph.record.read.csv import read_csv
from morph.record.read.table import Table, Text

NUMBERS = [
    "0",
    "1",
    "-2.5",
    "+1.5",
    ".5",
    "5.",
    "1e5",
    "1E-3",
    "-1e+300",
    "1e999",
    "-1e-999",
    "007",
]
NUMBERS += ["inf", "-INF", "Infinity", "nan", "NaN", "-nan", "+nan", "4.9e-324", "0.1"]
NUMBERS += [
    "\u0661",
    "9007199254740993",
    "123456789.123456789",
    " 1 ",
    "\t1",
    "1\n",
    "\xa01",
    "1\u2003",
]
MISSING = ["", " ", "\t ", "\n"]
TEXTS = [
    "x",
    "1_0",
    "0x10",
    "0x1p3",
    "nan(1)",
    "NAN(ind)",
    "nan()",
    "1e",
    "e5",
    "1e+",
    "-",
    "+",
    ".",
]
TEXTS += ["1,5", "1;5", "1 2", "1 000", "infi", "in", "1f", "1d5", "True", "'1'", '"1"', "1\0"]
TEXTS += ["½", "(1)", "--1", "+-1", "1.2.3", "²", "NA", "null", "None"]


def read(content: bytes | str) -> Table:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_csv(path)


def value(cell: str) -> float | None:
    """The number of a cell, None for text: Python's, but without underscores."""
    try:
        return None if "_" in cell else float(cell) if cell.strip() else math.nan
    except ValueError:
        return None


def expected(cells: list[str]) -> np.ndarray | Text:
    values = [value(cell) for cell in cells]
    if None in values:
        row = values.index(None)
        return Text(cell=cells[row].strip()[:60], row=row)
    return np.array(values)


def same(found: object, wanted: np.ndarray | Text) -> bool:
    if isinstance(found, Text) or isinstance(wanted, Text):
        return found == wanted
    return np.array_equal(found, wanted, equal_nan=True) and np.array_equal(
        np.signbit(found), np.signbit(wanted)
    )


@pytest.mark.parametrize("cell", [*NUMBERS, *MISSING, *TEXTS])
def test_a_cell_is_a_number_if_it_is_one_to_python(cell: str) -> None:
    quoted = '"' + cell.replace('"', '""') + '"'
    # In front, in the middle and behind; a cell that Arrow cannot cast must not change the others.
    for row in range(3):
        cells = ["0.25"] * 3
        cells[row] = cell
        lines = [f"{at},{quoted if at == row else '0.25'}" for at in range(3)]
        table = read("time,a\n" + "\n".join(lines))
        assert same(table.columns[1], expected(cells)), cells


@pytest.fixture(params=["at once", "in pieces"])
def pieces(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The text is split in blocks of some rows, and cast one row after the other; or at once."""
    if request.param == "in pieces":
        for name, least in (("MOST_LINE", 60), ("COLUMN_BYTES", 0), ("CELLS", 1), ("ROWS", 1)):
            monkeypatch.setattr(reader, name, least)


@pytest.mark.usefixtures("pieces")
def test_one_odd_cell_behind_many_plain_ones_is_found() -> None:
    for odd in ("x", "nan(1)", "1_0", "\u0661"):
        cells = [str(at) for at in range(100)] + [odd] + ["1"] * 20
        table = read("time,a\n" + "".join(f"0,{cell}\n" for cell in cells))
        assert same(table.columns[1], expected(cells))
        assert same(table.columns[0], np.zeros(121))


grids = st.integers(1, 4).flatmap(
    lambda width: st.lists(
        st.lists(st.sampled_from([*NUMBERS * 3, *MISSING, *TEXTS]), min_size=width, max_size=width),
        min_size=1,
        max_size=12,
    )
)


@settings(max_examples=150, deadline=None, database=None)
@given(
    grid=grids,
    delimiter=st.sampled_from(",;\t"),
    ending=st.sampled_from(["\n", "\r\n", "\r"]),
    quoting=st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL]),
    mark=st.booleans(),
)
@example(grid=[["1"], ["x"]], delimiter=",", ending="\r\n", quoting=csv.QUOTE_ALL, mark=True)
def test_what_python_writes_is_read_as_it_was(
    grid: list[list[str]], delimiter: str, ending: str, quoting: int, mark: bool
) -> None:
    # A file of one column has no delimiter that could be seen.
    delimiter = delimiter if len(grid[0]) > 1 else ","
    sink = io.StringIO()
    writer = csv.writer(sink, delimiter=delimiter, lineterminator="\n", quoting=quoting)
    names = [f"c{at}" for at in range(len(grid[0]))]
    writer.writerows([names, *grid])
    kept = [row for row in grid if any(cell.strip() for cell in row)]
    content = sink.getvalue().replace("\n", ending).encode("utf-8-sig" if mark else "utf-8")
    if not kept:
        with pytest.raises(RecordingError, match="a header and no samples"):
            read(content)
        return
    table = read(content)
    assert table.names == tuple(names)
    for column, cells in zip(table.columns, zip(*kept, strict=True), strict=True):
        assert same(column, expected(list(cells)))


def numbered(table: Table) -> list[int]:
    assert table.lines is not None
    return [int(line) for line in table.lines]


@pytest.mark.usefixtures("pieces")
@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("t,a\n1,2\n3,4", [2, 3]),
        ("1,2\n3,4\n\n \n", [1, 2]),
        ("t,a\n\n1,2\n  \n,\n , \n3,4\n\t\n5,6", [3, 7, 9]),
        ("\n\n;\nt;a\n\n1;2\n", [6]),
        ("\nt,a\n1,2\n", [3]),
        (";;\nt,a\n1,2\n", [3]),
        (' "1", "2"\n', [1]),
        ('t,a\n"1\n","2"\n\n"",""\n" ",\n3,4', [3, 7]),
        ('t,a\n1,"2\n\n\n"\n3,4\n"5\n",6\n7,8', [5, 6, 8, 9]),
        ('t,"a\nb"\n1,2\n3,"\n4"', [3, 5]),
        ('\n\n"t\n\n","a"\n1,2\n', [6]),
        ('t,a\r\n1,2\r\n\r\n3, "4"\r\n', [2, 4]),
    ],
)
def test_rows_keep_the_numbers_of_their_lines(text: str, lines: list[int]) -> None:
    table = read(text)
    assert numbered(table) == lines
    rows = np.stack(table.columns, axis=1)
    assert np.array_equal(rows, np.arange(1.0, 2.0 * len(lines) + 1.0).reshape(-1, 2))


@pytest.mark.usefixtures("pieces")
def test_cells_may_have_spaces_before_their_quotes() -> None:
    table = read(' "time", "a"  ,   "b, c"\n  "1",  "2","[3, 4]"\n5, "6" ,  "[7,8 ]"\n')
    assert table.names == ("time", "a", "b, c")
    assert [column.tolist() for column in table.columns] == [[1, 5], [2, 6], [[3, 4], [7, 8]]]


@pytest.mark.usefixtures("pieces")
@pytest.mark.parametrize(
    ("cells", "found"),
    [
        (["[1, 2]", "[ 3 ,+4e0]", "[nan,\n6]"], [[1, 2], [3, 4], [math.nan, 6]]),
        (["[1]", " [2] ", "[\u0663]"], [[1], [2], [3]]),
        (["[1, 2]", "[3, x]"], 1),
        (["[1, 2]", "[3, 4]", "[5, 6, 7]"], 2),
        (["[1, 2]", "[3, ]"], 1),
        (["[1, 2]", "[ , 3]", "x"], 1),
        (["[1, 2]", "[3, 4_0]", "[5]"], 1),
        (["[1, 2]", "", "[3, 4]"], 1),
        (["[1]", "2"], 1),
        (["[1]", "(2)"], 1),
        (["[1]", "[2"], 1),
        (["[1]", "2]"], 1),
        (["[]", "[]"], 0),
        (["[[1, 2]]"], 0),
        (["1", "[2]"], 1),
        (["", "[2]"], 1),
    ],
)
def test_lists_are_equally_long_or_text(cells: list[str], found: object) -> None:
    table = read("time,a\n" + "".join(f'{at},"{cell}"\n' for at, cell in enumerate(cells)))
    column = table.columns[1]
    if isinstance(found, int):
        assert column == Text(cell=cells[found].strip(), row=found)
    else:
        assert not isinstance(column, Text)
        assert np.array_equal(column, np.array(found, dtype=np.float64), equal_nan=True)


@pytest.mark.usefixtures("pieces")
@pytest.mark.parametrize(
    ("text", "what", "line"),
    [
        ("t,a\n1,2\n3\n4,5", "the line has 1 fields, the first has 2", 3),
        ("t,a\n1,2\n\n \n3\n4,5", "the line has 1 fields, the first has 2", 5),
        ('t,a\n"1\n",2\n3,4,5\n6,7\n', "the line has 3 fields, the first has 2", 4),
        ("t,a\n1,2\n3,4,5", "the line has 3 fields, the first has 2", 3),
        ("1,2\n13\n3\n", "the line has 1 fields, the first has 2", 2),
    ],
)
def test_a_line_with_other_fields_than_the_first_is_named(text: str, what: str, line: int) -> None:
    with pytest.raises(RecordingError, match=what) as caught:
        read(text)
    assert caught.value.where.endswith(f", line {line}")


@pytest.mark.parametrize("behind", [2000, 1_000_000])
def test_a_quote_that_does_not_end_is_refused(behind: int) -> None:
    with pytest.raises(RecordingError, match=r"cannot be split .* quotes do not end") as caught:
        read(b't,a\n\n1,2\n3,"4\n' + b"5555555555\n" * behind)
    # The row begins in line 4, behind line 3.
    assert caught.value.where.endswith("behind line 3")


def test_a_letter_that_is_cut_in_two_is_refused() -> None:
    with pytest.raises(RecordingError, match="not text: byte 8 is 0xc3"):
        read(b"t,a\n1,2\n\xc3")


def test_a_header_that_takes_in_all_lines_has_no_samples() -> None:
    with pytest.raises(RecordingError, match="a header and no samples"):
        read('"t,a\n\n1,2\n')


def test_a_header_that_does_not_end_is_refused() -> None:
    with pytest.raises(RecordingError, match="quotes do not end"):
        read('"t,a\n' + "1,2\n" * 100_000)


@pytest.mark.parametrize(
    ("first", "names"),
    [("1,2", 0), ("1,", 0), ("nan,1", 0), ("nan,inf", 2), (",x", 2), ("1,x", 2), ("1_0,2", 2)],
)
def test_a_first_line_of_numbers_is_data(first: str, names: int) -> None:
    table = read(f"{first}\n3,4\n")
    assert len(table.names) == names
    assert len(table.columns[1]) == (1 if names else 2)


def test_tall_and_wide_files_are_read_fast(
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    tall, wide = b"0,1.5\n" * 300_000, (b"0.5," * 9_999 + b"1\n") * 20
    read("1")  # Arrow is loaded.
    with processor(0.3):
        assert read(tall).columns[1].sum() == 450_000
    with processor(1.5):
        assert len(read(wide).columns) == 10_000
    with processor(0.3):
        table = read(b'0,"x"\n' * 300_000)
    assert table.columns[1] == Text(cell="x", row=0)
