from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas
import pytest

import morph
from morph.arrays import JSON
from morph.record.recording import Channel, Recording
from morph.tabular import MOST_SHOWN, Tabular


@dataclass(frozen=True)
class Squares(Tabular):
    axes: ClassVar[tuple[str, ...]] = ("number", "square")
    count: int

    def rows(self) -> list[JSON]:
        return [{"number": n, "square": float(n * n)} for n in range(self.count)]


@dataclass(frozen=True)
class Named(Tabular):
    name: str

    def rows(self) -> list[JSON]:
        return [{"name": self.name, "value": 1.0}]


def test_a_frame_has_all_rows() -> None:
    frame = Squares(count=100).to_pandas()
    assert frame["square"].tolist() == [float(n * n) for n in range(100)]


def test_a_table_is_cut_and_says_so() -> None:
    page = Squares(count=MOST_SHOWN + 3)._repr_html_()
    assert page.count("<tr>") == MOST_SHOWN + 1
    assert "and 3 more rows" in page
    assert "more rows" not in Squares(count=MOST_SHOWN)._repr_html_()


def test_what_a_file_says_is_text_in_a_table() -> None:
    page = Named(name="<script>alert(1)</script>")._repr_html_()
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


def test_a_plot_has_lines_over_numbers_and_bars_over_names() -> None:
    (line,) = Squares(count=4).plot().data
    assert (line.type, list(line.x)) == ("scatter", [0, 1, 2, 3])
    assert list(line.y) == [0.0, 1.0, 4.0, 9.0]
    (bar,) = Named(name="a").plot().data
    assert (bar.type, list(bar.x), list(bar.y)) == ("bar", ["a"], [1.0])
    assert len(Squares(count=0).plot().data) == 0


def test_a_recording_is_a_frame_over_all_clocks_and_a_file_again(tmp_path: object) -> None:
    slow, fast = np.array([0.0, 0.2, 0.4]), np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    recording = Recording(
        name="two clocks",
        channels={
            "a.position": Channel(time=fast, value=np.sin(fast)),
            "a.command": Channel(time=slow, value=slow, hold=True),
        },
    )
    frame = recording.to_pandas()
    assert frame.index.tolist() == fast.tolist()
    assert frame["a.position"].tolist() == np.sin(fast).tolist()
    assert frame["a.command"].isna().tolist() == [False, True, False, True, False]
    position, command = recording.plot().data
    assert (position.line.shape, command.line.shape) == ("linear", "hv")
    rates = {row["channel"]: row["rate"] for row in recording.rows()}
    assert rates == pytest.approx({"a.position": 10.0, "a.command": 5.0})


def test_a_comparison_and_a_diagnosis_are_read_as_rows() -> None:
    robot = morph.load("pendulum")
    law = morph.EFFECTS[0](joint="hinge", b=0.05)  # type: ignore[call-arg]
    run = morph.simulate(robot, [law], seconds=12.0, start={"hinge": 1.0})
    comparison = morph.compare(robot, [run])
    assert isinstance(comparison.to_pandas(), pandas.DataFrame)
    assert [row["channel"] for row in comparison.rows()] == ["hinge.position"]
    diagnosis = morph.diagnose(robot, [run])
    (row,) = diagnosis.rows()
    assert row["low90"] < 0.05 < row["high90"]
    drawn = {trace.name: trace.y[0] for trace in diagnosis.plot().data}
    assert drawn["corrected"] < 0.1 * drawn["nominal"]
