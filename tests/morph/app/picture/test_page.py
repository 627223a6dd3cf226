from __future__ import annotations

import http.client
from typing import Any

import pytest

from morph.app.picture.page import view
from morph.body.load import load
from morph.errors import OutputError
from morph.sim.simulator import Simulator


def test_the_page_is_served_until_one_has_seen_enough(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load("pendulum")
    moved = Simulator(robot).trajectory(seconds=0.2, start={"hinge": 1.0})
    seen: list[bytes] = []

    def look(server: Any) -> bool:
        connection = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10)
        connection.request("GET", "/")
        seen.append(connection.getresponse().read())
        connection.close()
        return len(seen) < 3

    view(robot, (), moved.time, moved.position, ready=look)
    assert len(seen) == 3
    assert b"<html" in seen[0]
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("see http://localhost:")


def test_an_interrupt_ends_the_looking_and_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load("pendulum")
    moved = Simulator(robot).trajectory(seconds=0.2)

    def interrupt(server: Any) -> bool:
        raise KeyboardInterrupt

    view(robot, (), moved.time, moved.position, ready=interrupt)
    assert "end with Ctrl-C" in capsys.readouterr().err


def test_the_page_is_for_this_machine_alone_and_by_its_own_name() -> None:
    robot = load("pendulum")
    moved = Simulator(robot).trajectory(seconds=0.2)
    seen: list[int] = []

    def look(server: Any) -> bool:
        connection = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10)
        connection.request("GET", "/", headers={"Host": "evil.example"})
        seen.append(connection.getresponse().status)
        connection.close()
        return False

    view(robot, (), moved.time, moved.position, ready=look)
    assert seen == [403]


def test_where_nothing_can_be_served_the_option_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = load("pendulum")
    moved = Simulator(robot).trajectory(seconds=0.2)

    def refuses(*given: Any, **named: Any) -> Any:
        raise OutputError("all ports are taken", where="http://127.0.0.1:8080", fix="name another")

    monkeypatch.setattr("morph.app.viewer.server.open_door", refuses)
    with pytest.raises(
        OutputError, match=r"--view, http://127\.0\.0\.1:8080: .*taken[\s\S]*--video"
    ):
        view(robot, (), moved.time, moved.position)
