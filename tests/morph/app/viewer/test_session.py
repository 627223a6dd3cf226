from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from morph.app.viewer.downloads import keep_page
from morph.app.viewer.opening import Opening
from morph.app.viewer.server import Viewer
from morph.app.viewer.state import Saved, Sources
from morph.app.viewer.view import View
from morph.errors import ViewError

People = Callable[..., Any]
Waits = Callable[[Callable[[], Any]], Any]


def port_of(viewer: Viewer) -> int:
    return int(viewer.door.server.get_port())


@pytest.mark.parametrize(("bad", "colour"), [(False, "blue"), (True, "red")])
def test_a_message_goes_away_by_itself_and_a_longer_one_later(
    viewer: Viewer, people: People, waits: Waits, bad: bool, colour: str
) -> None:
    person = people(port_of(viewer)).enters()
    (session,) = waits(lambda: viewer.sessions)
    stays = []
    for text in ("short", "long " * 60):
        session.do(lambda text=text: session.say(text, bad=bad))
        props = person.hears("NotificationShowMessage", text.strip())["props"]
        assert props["color"] == colour
        stays.append(props["auto_close_seconds"])
    # Nobody notices within a second; nothing that was read an hour ago hides the bodies.
    assert 1.0 < stays[0] < stays[1] < 60.0


def test_a_view_that_was_saved_otherwise_keeps_no_other_from_what_was_saved(
    still: type[View], people: People, waits: Waits
) -> None:
    restored: list[Any] = []

    class Other(still):  # type: ignore[misc,valid-type]
        name, title = "design", "Other"

        def restore(self, state: Any) -> None:
            raise ViewError("it is of other bodies", where="design", fix="save it again")

    class Kept(still):  # type: ignore[misc,valid-type]
        name, title = "compare", "Kept"

        def restore(self, state: Any) -> None:
            restored.append(state)

    saved = Saved(given=Sources(), view="compare", views={"design": {}, "compare": {"task": "hop"}})
    viewer = Viewer(lambda: [Other(), Kept()], port=0, opening=Opening(saved=saved))
    person = people(port_of(viewer)).enters()
    person.hears("NotificationShowMessage", "it is of other bodies")
    waits(lambda: restored == [{"task": "hop"}])
    viewer.close()


def test_who_asks_for_a_page_twice_is_made_one(
    viewer: Viewer, people: People, waits: Waits, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, go_on = [], threading.Event()

    def slowly(*_: Any, **__: Any) -> str:
        made.append(1)
        go_on.wait(10.0)
        return "a page"

    monkeypatch.setattr("morph.app.viewer.export.page.exported_page", slowly)
    person = people(port_of(viewer)).enters()
    (session,) = waits(lambda: viewer.sessions)
    for _ in range(3):
        session.do(lambda: keep_page(session))
    waits(lambda: made)
    session.do(lambda: session.say("all were heard"))
    person.hears("NotificationShowMessage", "all were heard")
    assert len(made) == 1
    go_on.set()
    person.hears("NotificationShowMessage", "is saved")
    # And another one may be made then.
    session.do(lambda: keep_page(session))
    waits(lambda: len(made) == 2)
