"""Long work of which only the latest counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from morph.app.viewer.design.latest_work import Latest
from morph.errors import RobotError


class Page:
    """A session that does later what a test tells it to."""

    def __init__(self) -> None:
        self.jobs: list[tuple[Callable[[], Any], Callable[[Any], None]]] = []

    def later(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        self.jobs.append((work, then))

    def work(self) -> None:
        while self.jobs:
            work, then = self.jobs.pop(0)
            then(work())


def test_what_cannot_be_built_is_told_and_what_is_built_stays() -> None:
    latest, page = Latest(), Page()
    undone: list[str] = []

    def bad() -> None:
        raise RobotError("it cannot be so", where="here", fix="choose less")

    latest.ask(page, bad, lambda _: None, lambda: undone.append("back"))  # type: ignore[arg-type]
    with pytest.raises(RobotError, match=r"it cannot be so"):
        page.work()
    assert undone == ["back"]
    assert not latest.busy


def test_of_what_is_asked_meanwhile_only_the_last_is_done() -> None:
    latest, page = Latest(), Page()
    done: list[int] = []
    for at in range(5):
        latest.ask(page, lambda at=at: at, done.append)  # type: ignore[misc]
    page.work()
    assert done == [0, 4]
    assert latest.done == 2
