from __future__ import annotations

import gc
import logging
import os
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from morph.app.viewer import server
from morph.app.viewer.content import Content
from morph.app.viewer.server import Viewer
from morph.app.viewer.session import Session
from morph.app.viewer.view import View
from morph.errors import ViewError

People = Callable[..., Any]
Waits = Callable[[Callable[[], Any]], Any]


def port_of(viewer: Viewer) -> int:
    return int(viewer.door.server.get_port())


def test_two_people_share_neither_clock_nor_speed_nor_view(
    viewer: Viewer, people: People, waits: Waits
) -> None:
    for _ in range(2):
        people(port_of(viewer)).enters()
    one, other = waits(lambda: len(viewer.sessions) == 2 and viewer.sessions)
    waits(lambda: one.clock.time > 0.0 and other.clock.time > 0.0)
    one.do(lambda: one.jump(0.5))
    one.do(lambda: setattr(one.clock, "speed", 0.1))
    waits(lambda: one.clock.speed == 0.1)
    assert (one.clock.time, one.clock.playing) == (0.5, False)
    assert (other.clock.speed, other.clock.playing) == (1.0, True)
    at = other.clock.time
    waits(lambda: other.clock.time != at)
    assert one.clock.time == 0.5
    assert one.view is not other.view
    assert one.stage is not other.stage


def test_who_leaves_leaves_nothing_behind(viewer: Viewer, people: People, waits: Waits) -> None:
    threads = threading.active_count()
    person = people(port_of(viewer)).enters()
    waits(lambda: viewer.sessions and viewer.sessions[0].clock.time > 0.0)
    held = [
        weakref.ref(each)
        for session in viewer.sessions
        for each in (session, session.client, session.view, session.stage)
    ]
    person.leaves()
    waits(lambda: not viewer.sessions)

    def all_gone() -> bool:
        gc.collect()
        return all(each() is None for each in held)

    waits(all_gone)
    # The pool that viser answers from keeps its threads for the next; the session's has ended.
    assert "morph-session" not in {thread.name for thread in threading.enumerate()}
    assert threading.active_count() <= threads + 32


def test_who_is_gone_before_the_page_is_made_is_not_kept(
    still: type[View], people: People, waits: Waits
) -> None:
    made, gone = threading.Event(), threading.Event()

    def slowly() -> list[View]:
        made.set()
        assert gone.wait(60.0)
        return [still()]

    viewer = Viewer(slowly, port=0)
    person = people(port_of(viewer)).enters()
    assert made.wait(60.0)
    person.leaves()
    waits(lambda: not viewer.door.server.get_clients())
    gone.set()
    waits(lambda: not viewer.sessions)
    waits(lambda: "morph-session" not in {thread.name for thread in threading.enumerate()})
    viewer.close()


def test_a_fault_of_the_viewers_own_is_told_on_that_page_and_ends_nothing(
    viewer: Viewer, people: People, waits: Waits, caplog: pytest.LogCaptureFixture
) -> None:
    one, other = (people(port_of(viewer)).enters() for _ in range(2))
    sessions = waits(lambda: len(viewer.sessions) == 2 and viewer.sessions)
    waits(lambda: all(session.clock.time > 0.0 for session in sessions))
    hit = next(each for each in sessions if each.client.client_id == 0)

    def fault() -> None:
        raise ZeroDivisionError("by <b>nothing</b>")

    def ours() -> None:
        raise ViewError("it is empty", where="there", fix="fill it")

    hit.do(fault)
    told = one.hears("NotificationShowMessage", "The viewer itself failed")
    assert "ZeroDivisionError: by <b>nothing</b>" in str(told)
    assert "a page could not be shown as asked" in caplog.text
    hit.do(ours)
    one.hears("NotificationShowMessage", "there: it is empty. fill it")
    hit.later(lambda: {}["work"], lambda found: None)
    one.hears("NotificationShowMessage", "The viewer itself failed at this (KeyError: 'work')")
    for session in sessions:
        at = session.clock.time
        waits(lambda session=session, at=at: session.clock.time != at)
    other.hears("GuiUpdateMessage")


def test_what_fails_with_every_picture_is_not_told_with_every_picture(
    viewer: Viewer,
    people: People,
    waits: Waits,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("morph.app.viewer.session.AGAIN", 1e9)
    people(port_of(viewer)).enters()
    (session,) = waits(lambda: viewer.sessions)
    failed: list[int] = []

    def fails(camera: Any) -> None:
        failed.append(len(failed))
        raise OSError("no picture")

    def told() -> int:
        return sum("could not be shown" in each.message for each in caplog.records)

    session.stage.refit = fails
    waits(lambda: len(failed) > 20)
    assert told() == 1
    # Once it is long ago, it is told again.
    monkeypatch.setattr("morph.app.viewer.session.AGAIN", 0.0)
    waits(lambda: told() > 1)


@pytest.mark.parametrize("where", ["content", "panel", "picture"])
def test_a_view_that_fails_leaves_a_page_that_can_be_turned_to_another(
    still: type[View], people: People, waits: Waits, caplog: pytest.LogCaptureFixture, where: str
) -> None:
    caplog.set_level(logging.CRITICAL + 1)

    class Bad(still):  # type: ignore[misc,valid-type]
        name, title = "bad", "Bad"
        asked = 0

        def content(self) -> Content:
            if where == "content":
                raise KeyError("content")
            found: Content = super().content()
            return found

        def panel(self, gui: Any, session: Session) -> None:
            if where == "panel":
                raise KeyError("panel")

        def picture(self, time: float) -> None:
            Bad.asked += 1
            if where == "picture":
                raise KeyError("picture")

    viewer = Viewer(lambda: [Bad(), still()], port=0)
    person = people(port_of(viewer)).enters()
    person.hears("NotificationShowMessage", f"KeyError: '{where}'")
    (session,) = viewer.sessions
    if where == "picture":
        # It is told once, not with every picture: the clock stands.
        waits(lambda: not session.clock.playing)
        before, passed, refit = Bad.asked, [0], session.stage.refit
        session.stage.refit = lambda camera: (passed.append(0), refit(camera))
        waits(lambda: len(passed) > 10)
        assert Bad.asked == before
    session.do(lambda: session.turn_to(session.views[1]))
    session.do(lambda: setattr(session.clock, "playing", True))
    waits(lambda: session.view.name == "still" and 0.0 < session.clock.time < 0.5)
    viewer.close()


def test_views_that_cannot_be_made_are_told_of_and_the_next_page_may_be_luckier(
    still: type[View], people: People, waits: Waits, caplog: pytest.LogCaptureFixture
) -> None:
    tries = iter((KeyError("<i>no</i>"), None))

    def made() -> Sequence[View]:
        if (error := next(tries)) is not None:
            raise error
        return [still()]

    viewer = Viewer(made, port=0)
    told = people(port_of(viewer)).enters().hears("GuiHtmlMessage")
    assert "&lt;i&gt;no&lt;/i&gt;" in told["props"]["content"]
    people(port_of(viewer)).enters()
    waits(lambda: len(viewer.sessions) == 1)
    viewer.close()


def test_rubbish_ends_the_page_that_sends_it_and_no_other(
    viewer: Viewer, people: People, waits: Waits
) -> None:
    good = people(port_of(viewer)).enters()
    (session,) = waits(lambda: viewer.sessions)
    for rubbish in (b"", b"\xff\x00rubbish", "text", b"\x81\xa4type\xa4None", bytes(5 * 2**20)):
        bad = people(port_of(viewer)).enters()
        waits(lambda: len(viewer.sessions) == 2)
        bad.socket.send(rubbish)
        waits(lambda: len(viewer.sessions) == 1)
    assert viewer.sessions == (session,)
    good.hears("GuiUpdateMessage")


def test_one_more_than_there_is_room_for_is_told_so_and_the_rest_look_on(
    viewer: Viewer, people: People, waits: Waits, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "MOST_PEOPLE", 2)
    inside = [people(port_of(viewer)).enters() for _ in range(2)]
    waits(lambda: len(viewer.sessions) == 2)
    told = people(port_of(viewer)).enters().hears("GuiHtmlMessage", "2 people look already")
    assert "load the page again later" in told["props"]["content"]
    assert len(viewer.sessions) == 2
    # Where one leaves, there is room for another.
    inside[0].leaves()
    waits(lambda: len(viewer.sessions) == 1)
    people(port_of(viewer)).enters()
    waits(lambda: len(viewer.sessions) == 2)


def test_closing_ends_all_pages_at_once(still: type[View], people: People, waits: Waits) -> None:
    viewer = Viewer(lambda: [still()], port=0)
    for _ in range(3):
        people(port_of(viewer)).enters()
    sessions = waits(lambda: len(viewer.sessions) == 3 and viewer.sessions)
    over: list[int] = []
    for session in sessions:
        session.join = lambda seconds: over.append(sum(each.over for each in sessions))
    viewer.close()
    # All are told before the first is waited for.
    assert over == [3, 3, 3]
    waits(lambda: "morph-session" not in {thread.name for thread in threading.enumerate()})


# What a shell starts in its background ignores interrupts, and so would what it starts.
WAITS = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from morph.app.viewer.server import Viewer
Viewer(lambda: [], port=0).wait()
sys.stdout.write("ended well")
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.skipif(os.name != "posix", reason="other systems have other signals")
def test_looking_ends_well_by_an_interrupt_and_by_the_systems_wish(number: int) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", WAITS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    assert "see http://localhost:" in process.stderr.readline()
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err.strip()) == (0, "ended well", "")


def test_fifteen_who_came_and_left_leave_no_objects_behind(
    viewer: Viewer, people: People, waits: Waits
) -> None:
    def objects_after(times: int) -> int:
        for _ in range(times):
            person = people(port_of(viewer)).enters()
            waits(lambda: viewer.sessions and viewer.sessions[0].clock.time > 0.0)
            person.leaves()
            people.forget()  # type: ignore[attr-defined]
            waits(lambda: not viewer.sessions)
        waits(lambda: "morph-session" not in {thread.name for thread in threading.enumerate()})
        gc.collect()
        return len(gc.get_objects())

    # The first ones find pools and caches empty.
    before = objects_after(5)
    after = objects_after(15)
    # A page that looks holds about 700 objects that the collector knows (2149 for three, with
    # the sockets that look), so not even one of the fifteen is kept.
    assert after - before < 600
