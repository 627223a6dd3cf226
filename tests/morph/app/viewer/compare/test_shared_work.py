"""Long work beside the pages: done once, told, stopped, and no hindrance to quick work."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from morph.app.viewer.compare.shared_work import Crew, Longer, Work
from morph.errors import TaskError, ViewError

LONG = 10.0
"""s; nothing here takes that long unless it is broken."""


@pytest.fixture
def crew() -> Iterator[Crew]:
    crew = Crew()
    yield crew
    crew.close()


def test_what_is_found_is_there_when_it_is_done(crew: Crew) -> None:
    work = crew.ask(lambda work: 42)
    assert work.wait(LONG)
    assert (work.done, work.found, work.error) == (True, 42, None)


def test_an_error_of_ours_is_kept_and_the_next_work_is_done(crew: Crew) -> None:
    def fails(work: Work[int]) -> int:
        raise TaskError("it cannot", where="here", fix="leave it")

    failed, next_one = crew.ask(fails), crew.ask(lambda work: 1)
    assert next_one.wait(LONG)
    assert failed.found is None
    assert isinstance(failed.error, TaskError)


def test_what_takes_long_does_not_hold_up_what_is_quick(crew: Crew) -> None:
    go_on, begun = threading.Event(), threading.Event()

    def waits(work: Work[str]) -> str:
        begun.set()
        go_on.wait(LONG)
        return "long"

    def begins(work: Work[str]) -> str | Longer[str]:
        return Longer(job=waits)

    long = crew.ask(begins)
    assert begun.wait(LONG)
    quick = crew.ask(lambda work: "quick")
    assert quick.wait(LONG)
    assert not long.done
    go_on.set()
    assert long.wait(LONG)
    assert long.found == "long"


def test_who_listens_hears_how_far_it_is_and_that_it_is_done(crew: Crew) -> None:
    go_on, heard = threading.Event(), list[tuple[str, bool]]()

    def tells(work: Work[None]) -> None:
        go_on.wait(LONG)
        work.tell("halfway")

    work = crew.ask(tells)
    work.listen(lambda: heard.append((work.told, work.done)))
    go_on.set()
    assert work.wait(LONG)
    # A work that ends is done before those who listen are told: wait for its thread.
    crew.close()
    assert heard == [("halfway", False), ("halfway", True)]


def test_who_listens_too_late_is_not_called(crew: Crew) -> None:
    work = crew.ask(lambda work: 1)
    assert work.wait(LONG)
    work.listen(lambda: pytest.fail("it was done before"))
    crew.close()


def test_when_the_viewer_ends_long_work_is_told_so_and_none_begins(crew: Crew) -> None:
    begun = threading.Event()

    def searches(work: Work[None]) -> None:
        begun.set()
        while True:
            crew.check()

    def begins(work: Work[None]) -> Longer[None] | None:
        return Longer(job=searches)

    work = crew.ask(begins)
    assert begun.wait(LONG)
    crew.close()
    assert work.wait(LONG)
    assert isinstance(work.error, ViewError)
    assert not crew.ask(lambda work: 1).wait(0.05)
