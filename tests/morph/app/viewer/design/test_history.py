"""Undo and redo."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.design.history import MOST, TOGETHER, History


def test_what_was_done_is_undone_and_done_again() -> None:
    history: History[int] = History(now=0)
    history.change(1, "a", 0.0)
    history.change(2, "b", 0.1)
    assert history.steps == (2, 0)
    assert history.undo()
    assert history.now == 1
    assert history.undo()
    assert history.now == 0
    assert not history.undo()
    assert history.now == 0
    assert history.redo()
    assert history.redo()
    assert history.now == 2
    assert not history.redo()


def test_a_drag_is_one_step() -> None:
    history: History[int] = History(now=0)
    for at in range(1, 50):
        history.change(at, "slider", 0.1 * at)
    assert history.steps == (1, 0)
    assert history.undo()
    assert history.now == 0
    assert history.redo()
    assert history.now == 49


def test_two_drags_of_one_slider_are_two_steps() -> None:
    history: History[int] = History(now=0)
    history.change(1, "slider", 0.0)
    history.change(2, "slider", 1.01 * TOGETHER)
    assert history.steps == (2, 0)


def test_a_drag_right_after_an_undo_is_a_step_of_its_own() -> None:
    history: History[int] = History(now=0)
    history.change(1, "slider", 0.0)
    history.change(2, "other", 0.1)
    assert history.undo()
    history.change(3, "slider", 0.2)
    assert history.undo()
    assert history.now == 1


def test_a_change_forgets_what_was_undone() -> None:
    history: History[int] = History(now=0)
    history.change(1, "a", 0.0)
    assert history.undo()
    history.change(2, "b", 5.0)
    assert not history.redo()
    assert history.now == 2


def test_nothing_is_no_step() -> None:
    history: History[int] = History(now=7)
    history.change(7, "a", 0.0)
    assert history.steps == (0, 0)


def test_old_steps_are_forgotten() -> None:
    history: History[int] = History(now=0)
    for at in range(MOST + 10):
        history.change(at + 1, str(at), 0.0)
    assert history.steps == (MOST, 0)


@given(st.lists(st.integers(0, 5), max_size=30))
def test_undoing_all_and_redoing_all_changes_nothing(states: list[int]) -> None:
    history: History[int] = History(now=-1)
    for at, state in enumerate(states):
        history.change(state, str(at), 0.0)
    last = history.now
    while history.undo():
        pass
    assert history.now == -1
    while history.redo():
        pass
    assert history.now == last
