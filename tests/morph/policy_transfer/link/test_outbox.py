from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from morph.errors import LinkDropped
from morph.policy_transfer.link import outbox as outbox_module
from morph.policy_transfer.link.fault_injection import Rough, Weather, pair
from morph.policy_transfer.link.folder import FolderLink
from morph.policy_transfer.link.link import MessageLink
from morph.policy_transfer.link.outbox import Post

STORM = Weather(down=0.3, lost=0.3, late=0.4, twice=0.3, spoilt=0.2)


Posting = Callable[[MessageLink, Path, str], Post]


def taken(post: Post) -> list[int]:
    """Take what waits, and return what it says."""
    found = []
    for message in post.waiting():
        found.append(message.content["n"])
        post.handled(message)
    return found


@pytest.mark.parametrize("seed", range(100, 105))
def test_in_any_weather_nothing_is_lost_and_nothing_comes_twice(
    posted: Posting, tmp_path: Path, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    here, there = (Rough(end, STORM, rng) for end in pair())
    robot, service = posted(here, tmp_path / "a", "robot"), posted(there, tmp_path / "b", "service")
    sent, got, back = 0, [], []
    for _ in range(600):
        if sent < 20 and rng.random() < 0.3:
            robot.put("experience", {"n": sent})
            service.put("policy", {"n": sent})
            sent += 1
        robot.exchange()
        service.exchange()
        # Either side may be killed, and come back with what is on its disk.
        if rng.random() < 0.1:
            robot.close()
            robot = posted(here, tmp_path / "a", "robot")
        if rng.random() < 0.1:
            service.close()
            service = posted(there, tmp_path / "b", "service")
        got += taken(service)
        back += taken(robot)
        if sent == 20 and robot.pending == service.pending == 0:
            break
    assert sorted(got) == list(range(20))
    assert sorted(back) == list(range(20))
    assert robot.pending == service.pending == 0


def test_without_numbers_and_hashes_the_same_weather_loses_and_repeats() -> None:
    # The control: bare messages over the same kind of link.
    rng = np.random.default_rng(100)
    here, there = pair()
    rough = Rough(here, STORM, rng)
    for number in range(100):
        try:
            rough.send(str(number).encode())
        except LinkDropped:
            continue
    arrived = there.receive()
    assert len(set(arrived)) < 100
    assert len(set(arrived)) < len(arrived)


def test_what_was_put_while_the_link_was_down_is_sent_later(
    posted: Posting, tmp_path: Path
) -> None:
    rng = np.random.default_rng(100)
    here, there = pair()
    rough = Rough(here, Weather(down=1.0), rng)
    robot = posted(rough, tmp_path / "a", "robot")
    robot.put("experience", {"n": 0})
    assert not robot.exchange()
    robot.close()
    robot = posted(here, tmp_path / "a", "robot")
    assert robot.exchange()
    service = posted(there, tmp_path / "b", "service")
    service.exchange()
    assert taken(service) == [0]


def test_a_message_that_was_not_handled_waits_after_a_kill(posted: Posting, tmp_path: Path) -> None:
    here, there = pair()
    robot, service = posted(here, tmp_path / "a", "robot"), posted(there, tmp_path / "b", "service")
    for n in (0, 1):
        robot.put("experience", {"n": n})
    robot.exchange()
    service.exchange()
    service.handled(service.waiting()[0])
    service.close()
    assert taken(posted(there, tmp_path / "b", "service")) == [1]


def test_a_folder_that_was_deleted_does_not_pass_for_its_old_self(
    posted: Posting, tmp_path: Path
) -> None:
    here, there = pair()
    service = posted(there, tmp_path / "b", "service")
    for folder in ("a", "c"):
        robot = posted(here, tmp_path / folder, "robot")
        robot.put("experience", {"n": 5})
        robot.exchange()
        service.exchange()
    # Both are number 1 of a robot, and both count.
    assert taken(service) == [5, 5]


def test_a_journal_that_is_written_anew_forgets_nothing(
    posted: Posting, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(outbox_module, "MOST_ENTRIES", 4)
    here, there = pair()
    got = []
    robot, service = posted(here, tmp_path / "a", "robot"), posted(there, tmp_path / "b", "service")
    for n in range(30):
        robot.put("experience", {"n": n})
        for _ in range(3):
            robot.exchange()
            service.exchange()
        got += taken(service)
    size = (tmp_path / "a" / "outbox.journal").stat().st_size
    # Thirty messages of some 300 bytes were put; a handful is left.
    assert size < 3000
    robot.close()
    robot = posted(here, tmp_path / "a", "robot")
    assert robot.put("experience", {"n": 30}) == 31
    # An old message once more: it is known, and nothing waits.
    robot.exchange()
    service.exchange()
    assert got + taken(service) == list(range(31))


def test_messages_travel_over_folders(posted: Posting, tmp_path: Path) -> None:
    up, down = tmp_path / "up", tmp_path / "down"
    robot = posted(FolderLink(up, down), tmp_path / "a", "robot")
    robot.put("experience", {"n": 0})
    # The disk is not there yet.
    assert not robot.exchange()
    up.mkdir()
    down.mkdir()
    # Something else lies there too, and half a message.
    (up / "readme.txt").write_text("x")
    (up / "0.message").write_text('{"schema": "morph.link/1", "sha')
    service = posted(FolderLink(down, up), tmp_path / "b", "service")
    for _ in range(4):
        robot.exchange()
        service.exchange()
    assert taken(service) == [0]
    assert service.spoilt == 1
    assert robot.pending == 0
    assert [file.name for file in up.iterdir()] == ["readme.txt"]
