from __future__ import annotations

import io
import re
import sys

import pytest

from morph.study import live as module
from morph.study.cell import Cell
from morph.study.live import duration, in_words, live
from morph.study.progress import Progress
from morph.study.store import Result

CELL = Cell(function="toy_cells:square", case={"x": 3, "name": "a\x1b[31mred"})
FAILED = Result(cell=CELL, status="failed", error={"what": "KeyError:\n 'three'"})
DONE = Result(cell=CELL, status="done", row={"x": 3})


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def half_way() -> Progress:
    """Ten cells, of which two were there and four ended in 8 s: four are left, 2 s each."""
    progress = Progress(total=10, reused=2, done=4, failed=1, running=2, worker_deaths=1)
    progress.start -= 8.0
    return progress


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_a_scheduler_that_does_not_answer_is_named_until_it_does(
    monkeypatch: pytest.MonkeyPatch, stream: type[io.StringIO]
) -> None:
    told = stream()
    monkeypatch.setattr(sys, "stderr", told)
    progress = half_way()
    with live() as watch:
        watch(progress, None)
        assert "not answered" not in told.getvalue()
        progress.silent = 12.3
        watch(progress, None)
    # A terminal breaks the line where its table ends.
    assert "the scheduler has not answered for 12 s" in re.sub(r"\s+", " ", told.getvalue())


def test_the_time_left_is_what_the_rest_takes_at_the_rate_so_far() -> None:
    # The clock runs on while the test looks: a rate of 0.5 a second at most.
    progress = half_way()
    assert progress.rate <= 0.5
    left = progress.left
    assert left is not None
    assert 8.0 <= left < 80.0
    assert Progress(total=10, reused=2).left is None


def test_nothing_is_left_of_a_study_whose_results_are_all_there() -> None:
    assert Progress(total=10, reused=10).left == 0.0


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(None, "?"), (0.4, "0 min 00 s"), (119.6, "2 min 00 s"), (3661.0, "1 h 01 min")],
)
def test_durations_read_as_people_say_them(seconds: float | None, words: str) -> None:
    assert duration(seconds) == words


def test_a_failed_cell_is_one_line_without_what_moves_a_cursor() -> None:
    assert in_words(FAILED) == r"failed: x=3, name=a\x1b[31mred: KeyError: 'three'"


def test_a_terminal_gets_a_table_and_the_cells_that_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("COLUMNS", "100")
    with live() as watch:
        watch(half_way(), FAILED)
        watch(half_way(), DONE)
    shown = screen.getvalue()
    assert "6 of 10" in shown
    assert "workers lost" in shown
    assert shown.count("KeyError") == 1
    assert "\x1b[31mred" not in shown


def test_a_pipe_gets_a_line_now_and_then_and_one_in_the_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told = io.StringIO()
    monkeypatch.setattr(sys, "stderr", told)
    monkeypatch.setattr(module, "PAUSE", 1e9)
    with live() as watch:
        for done in range(1, 5):
            watch(Progress(total=4, done=done), DONE)
    lines = told.getvalue().splitlines()
    assert [line.partition(",")[0] for line in lines] == ["1 of 4 done", "4 of 4 done"]


def test_quiet_shows_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    told = io.StringIO()
    monkeypatch.setattr(sys, "stderr", told)
    with live(quiet=True) as watch:
        watch(half_way(), FAILED)
    assert told.getvalue() == ""
