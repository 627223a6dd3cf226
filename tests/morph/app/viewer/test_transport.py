"""The clock's knobs, pressed by a person without a browser."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from morph.app.viewer.camera import Camera
from morph.app.viewer.content import Content, Moment
from morph.app.viewer.motion import RATE
from morph.app.viewer.opening import Opening
from morph.app.viewer.server import Viewer
from morph.app.viewer.session import Session
from morph.app.viewer.state import Saved, Sources, saved
from morph.app.viewer.transport import HAND, NOWHERE, ClockControls
from morph.app.viewer.view import View


@pytest.fixture
def session(viewer: Viewer, people: Callable[..., Any], waits: Callable[..., Any]) -> Session:
    """One who looks at a pendulum that swings for a second; the clock stands."""
    people(viewer.door.server.get_port()).enters()
    return looked(viewer, waits)


@contextmanager
def served(view: type[View], saw: Saved) -> Iterator[Viewer]:
    """A viewer that begins with what was saved."""
    viewer = Viewer(lambda: [view()], port=0, opening=Opening(saved=saw))
    yield viewer
    viewer.close()


def looked(viewer: Viewer, waits: Callable[..., Any]) -> Session:
    waits(lambda: viewer.sessions and viewer.sessions[0].content.actors)
    session = viewer.sessions[0]
    within(session, lambda: None)
    return session


def within(session: Session, what: Callable[[], Any]) -> Any:
    """Do something in the session's thread, and return what comes of it."""
    found: list[Any] = []
    session.do(lambda: found.append(what()))
    end = time.monotonic() + 60.0
    while not found:
        assert time.monotonic() < end
        time.sleep(0.005)
    return found[0]


def transport(session: Session) -> ClockControls:
    knobs = session._controls._transport
    assert isinstance(knobs, ClockControls)
    return knobs


def test_steps_are_a_picture_or_a_second_and_pause(session: Session) -> None:
    press, clock = transport(session).press, session.clock
    within(session, lambda: (press("start"), press("+1"), press("+1")))
    assert clock.time == pytest.approx(2.0 / RATE)
    assert not clock.playing
    within(session, lambda: press("+1 s"))
    assert clock.time == clock.seconds
    within(session, lambda: press("-1 s"))
    assert clock.time == pytest.approx(clock.seconds - 1.0, abs=1e-9)
    within(session, lambda: press("end"))
    assert clock.time == clock.seconds


def test_speed_goes_from_one_to_the_next_and_no_farther(session: Session) -> None:
    knobs, clock = transport(session), session.clock
    within(session, lambda: [knobs.press("faster") for _ in range(9)])
    assert (clock.speed, knobs._speed.value) == (4.0, "4")
    within(session, lambda: [knobs.press("slower") for _ in range(9)])
    assert (clock.speed, knobs._speed.value) == (0.1, "0.1")


def test_the_slider_is_left_to_the_hand_that_moves_it(session: Session) -> None:
    knobs = transport(session)

    def drag() -> list[float]:
        # The hand is at 0.3 when what it did at 0.2 is heard of.
        knobs._slider.value = 0.2
        knobs._scrub(0.2)
        session.clock.seek(0.9)
        knobs.tell()
        during = float(knobs._slider.value)
        knobs._touched -= HAND
        knobs.tell()
        return [during, float(knobs._slider.value)]

    assert within(session, drag) == [0.2, pytest.approx(0.9)]


def test_moments_are_marked_and_jumped_to(session: Session) -> None:
    knobs = transport(session)
    moments = (
        Moment(time=0.25, title="worst <b>" + "x" * 100),
        Moment(time=0.75, title="worst"),
        Moment(time=0.75, title="worst"),
    )

    def go() -> Any:
        session.show(Content(actors=session.content.actors, moments=moments))
        knobs._goal.value = knobs._goal.options[2]
        knobs._go(knobs._goal.value)
        return knobs._goal.options, [mark.value for mark in knobs._slider._marks]

    options, marks = within(session, go)
    assert session.clock.time == 0.75
    # A choice needs a name for each, and a short one.
    assert len(set(options)) == len(options) == 4
    assert options[0] == NOWHERE
    assert max(map(len, options)) < 80
    assert marks == [0.0, session.clock.seconds, 0.25, 0.75]


def test_what_stands_still_has_no_clock(session: Session) -> None:
    knobs = transport(session)
    within(session, lambda: session.show(Content(actors=())))
    assert not any(each.visible for each in (knobs._play, knobs._steps, knobs._slider))


def test_what_is_saved_is_shown_again(
    still: type[View], people: Callable[..., Any], waits: Callable[..., Any]
) -> None:
    saw = Saved(
        given=Sources(),
        view="still",
        time=0.5,
        speed=0.25,
        playing=False,
        repeat=False,
        camera=Camera(position=(4.0, -3.0, 2.0), look_at=(0.5, 0.0, 0.25)),
        hidden=("torque",),
        follow=False,
    )
    with served(still, saw) as viewer:
        people(viewer.door.server.get_port()).enters()
        session = looked(viewer, waits)
        again = within(session, lambda: saved(session))
        assert again == saw
        assert session._controls._loop.value is False
        assert transport(session)._speed.value == "0.25"


def test_saving_sends_a_file(
    viewer: Viewer, people: Callable[..., Any], waits: Callable[..., Any]
) -> None:
    from morph.app.viewer.downloads import keep_page, keep_view

    person = people(viewer.door.server.get_port()).enters()
    session = looked(viewer, waits)
    session.do(lambda: keep_view(session))
    assert person.hears("FileTransferStartDownload")["filename"] == "morph-view.json"
    session.do(lambda: keep_page(session))
    assert person.hears("FileTransferStartDownload")["filename"] == "morph-still.html"
