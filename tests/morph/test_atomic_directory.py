from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from morph import atomic_directory as atomic
from morph.atomic_directory import atomic_directory
from morph.errors import OutputError
from morph.fabrication.package_folder import package_folder
from morph.fabrication.packed import FILE, SCHEMA

HELD = """
import sys, time
from pathlib import Path
from morph.fabrication.package_folder import package_folder
with package_folder(Path(sys.argv[1])) as made:
    (made / "half").write_text("half")
    print(made.name, flush=True)
    time.sleep(60)
"""


def package(folder: Path, said: str = "") -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(f'{{"schema": "{SCHEMA}", "name": "{said}"}}')


def test_what_a_killed_program_left_says_what_it_is_and_the_next_sweeps_it(tmp_path: Path) -> None:
    place = tmp_path / "package"
    with subprocess.Popen(
        [sys.executable, "-c", HELD, str(place)], stdout=subprocess.PIPE, text=True
    ) as killed:
        assert killed.stdout is not None
        left = killed.stdout.readline().strip()
        assert left.startswith(".package.unfinished-")
        # While it is written, another program leaves it alone.
        with package_folder(place) as made:
            package(made, "first")
        assert (tmp_path / left / "half").is_file()
        killed.send_signal(signal.SIGKILL)
    assert sorted(each.name for each in tmp_path.iterdir()) == [left, "package"]
    with package_folder(place) as made:
        package(made, "second")
    assert [each.name for each in tmp_path.iterdir()] == ["package"]
    assert "second" in (place / FILE).read_text()


def test_of_two_at_once_the_last_is_there_and_whole(tmp_path: Path) -> None:
    place = tmp_path / "package"
    with package_folder(place) as one:
        package(one, "one")
        with package_folder(place) as other:
            package(other, "other")
    assert "one" in (place / FILE).read_text()
    assert [each.name for each in tmp_path.iterdir()] == ["package"]


def test_what_came_to_stand_there_meanwhile_is_left_alone(tmp_path: Path) -> None:
    place = tmp_path / "package"
    with (  # noqa: PT012 -- what is refused is the end of what stands here
        pytest.raises(OutputError, match=r"holds no earlier package"),
        package_folder(place) as made,
    ):
        package(made)
        place.mkdir()
        (place / "letter.txt").write_text("dear")
    assert (place / "letter.txt").read_text() == "dear"
    assert [each.name for each in tmp_path.iterdir()] == ["package"]


def test_a_file_system_without_locks_will_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(fcntl, "flock", none)
    with package_folder(tmp_path / "package") as made:
        package(made)
    assert [each.name for each in tmp_path.iterdir()] == ["package"]


@pytest.mark.parametrize("name", ["a" * 255, "[x]*", "ä" * 100, " "])
def test_a_strange_name_is_a_name(tmp_path: Path, name: str) -> None:
    for said in ("one", "two"):
        with package_folder(tmp_path / name) as made:
            package(made, said)
    assert os.listdir(tmp_path) == [name]
    assert "two" in (tmp_path / name / FILE).read_text()


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    package(tmp_path / "real")
    (tmp_path / "link").symlink_to("real")
    with pytest.raises(OutputError, match=r"this is no folder"), package_folder(tmp_path / "link"):
        pass


WRITE = """
import sys
from pathlib import Path
from morph.atomic_directory import atomic_directory
place, said = Path(sys.argv[1]), sys.argv[2]
for turn in range(100000):
    with atomic_directory(place, lambda _: None, ("a", "b")) as made:
        for name in ("a", "b"):
            (made / name).write_text(f"{said} {turn}")
    print(turn, flush=True)
"""


def kill_while_it_replaces(place: Path, said: str, turns: int) -> None:
    """Kill a process that replaces a folder over and over, in the midst of some later turn."""
    with subprocess.Popen(
        [sys.executable, "-c", WRITE, str(place), said], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        for _ in range(turns):
            process.stdout.readline()
        process.kill()


def test_a_kill_at_any_moment_leaves_one_whole_folder_and_what_others_put_there(
    tmp_path: Path,
) -> None:
    place = tmp_path / "out"
    place.mkdir()
    (place / "a").write_text("before 0")
    (place / "b").write_text("before 0")
    (place / "my notes.txt").write_text("precious")
    rng = np.random.default_rng(1)
    for _ in range(10):
        kill_while_it_replaces(place, "new", int(rng.integers(1, 9)))
        assert (place / "a").read_text() == (place / "b").read_text()
        # It may have been killed before they were taken over; the next to write does that.
        with atomic_directory(place, lambda _: None, ("a", "b")) as made:
            (made / "a").write_text("next")
            (made / "b").write_text("next")
        assert {each.name for each in place.iterdir()} == {"a", "b", "my notes.txt"}
        assert (place / "my notes.txt").read_text() == "precious"
        assert [each.name for each in tmp_path.iterdir()] == ["out"]


def test_without_an_exchange_in_one_step_a_folder_is_replaced_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(atomic, "_exchanged", lambda *_: False)
    place = tmp_path / "out"
    place.mkdir()
    for name in ("a", "b", "my notes.txt"):
        (place / name).write_text("old")
    with atomic_directory(place, lambda _: None, ("a", "b")) as made:
        (made / "a").write_text("new")
    assert {each.name: each.read_text() for each in place.iterdir()} == {
        "a": "new",
        "my notes.txt": "old",
    }
    assert [each.name for each in tmp_path.iterdir()] == ["out"]


def test_a_folder_that_a_kill_left_between_two_renames_is_put_back(tmp_path: Path) -> None:
    left = tmp_path / ".out.replaced-x1y2"
    (left / "old").mkdir(parents=True)
    (left / "old" / "a").write_text("old")
    place = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt), atomic_directory(place, lambda _: None, ("a",)):
        raise KeyboardInterrupt
    assert (place / "a").read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["out"]


def test_what_a_kill_left_of_a_long_name_is_not_taken_for_another_that_begins_alike(
    tmp_path: Path,
) -> None:
    names = [f"diagnosis_of_the_left_front_leg_of_the_robot_{each}" for each in "AB"]
    for name in names:
        with atomic_directory(tmp_path / name, lambda _: None, ("a",)) as made:
            (made / "a").write_text(name)
            # As a kill leaves it: a folder beside, with what a user had put into the one before.
            left = tmp_path / made.name.rpartition("-")[0]
    left = left.with_name(f"{left.name}-x1y2")
    left.mkdir()
    (left / "notes.txt").write_text("of B")
    with atomic_directory(tmp_path / names[0], lambda _: None, ("a",)) as made:
        (made / "a").write_text("anew")
    assert not (tmp_path / names[0] / "notes.txt").exists()
    with atomic_directory(tmp_path / names[1], lambda _: None, ("a",)) as made:
        (made / "a").write_text("anew")
    assert (tmp_path / names[1] / "notes.txt").read_text() == "of B"


FULL = """
import resource, signal, sys
from pathlib import Path
from morph.atomic_directory import atomic_directory
from morph.errors import OutputError
# What is written beyond this ends in an error, as on a full disk.
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    with atomic_directory(Path(sys.argv[1]), lambda _: None, ("a",)) as made:
        (made / "a").write_bytes(bytes(5000))
except OutputError as error:
    print(error.what)
"""


def test_a_full_disk_leaves_the_old_folder_and_nothing_beside_it(tmp_path: Path) -> None:
    place = tmp_path / "out"
    place.mkdir()
    (place / "a").write_text("old")
    ran = subprocess.run(
        [sys.executable, "-c", FULL, str(place)], capture_output=True, text=True, check=True
    )
    assert "cannot be written: File too large" in ran.stdout
    assert (place / "a").read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["out"]
