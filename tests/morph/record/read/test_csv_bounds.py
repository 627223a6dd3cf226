"""CSV files that unpack to far more than they are, or are written for another country."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from morph.errors import RecordingError
from morph.record import limits
from morph.record.read.csv import read_csv


def test_a_packed_file_of_a_ten_million_lines_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.csv.gz"
    with gzip.open(path, "wb", compresslevel=1) as file:
        file.write(b"time,a\n")
        for _ in range(100):
            file.write(b"1,2\n" * 100_000)
    with pytest.raises(RecordingError, match=r"10000001 lines of 2 columns take 160000016 bytes"):
        read_csv(path)


def test_lists_count_by_their_elements(tmp_path: Path) -> None:
    path = tmp_path / "lists.csv.gz"
    path.write_bytes(gzip.compress((b'"[0' + b",0" * 999 + b']"\n') * 10_000, 1))
    with pytest.raises(RecordingError, match=r"the 10000000 numbers .* take 80000000 bytes"):
        read_csv(path)


def test_text_beyond_the_bound_is_not_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "MOST_TEXT", 1000)
    path = tmp_path / "long.csv.gz"
    path.write_bytes(gzip.compress(b"time,a\n" + b"1,2\n" * 1000))
    with pytest.raises(RecordingError, match="more than 1000 bytes"):
        read_csv(path)
    path.write_bytes(gzip.compress(b"time,a\n" + b"1,2\n" * 10))
    assert len(read_csv(path).columns[0]) == 10


def test_a_row_of_blanks_is_no_sample(tmp_path: Path) -> None:
    path = tmp_path / "blank.csv"
    path.write_text("time,a\n,")
    with pytest.raises(RecordingError, match="a header and no samples"):
        read_csv(path)


def test_a_decimal_comma_is_named_as_what_it_is(tmp_path: Path) -> None:
    path = tmp_path / "german.csv"
    path.write_text("time;hinge.position\n0,0;0,1\n0,1;0,2\n")
    with pytest.raises(RecordingError, match="write decimals with a point"):
        read_csv(path).column("time")
