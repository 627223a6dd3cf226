from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from morph.errors import OutputError
from morph.make.aside import aside
from morph.make.packed import FILE, SCHEMA

HELD = """
import sys, time
from pathlib import Path
from morph.make.aside import aside
with aside(Path(sys.argv[1])) as made:
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
        with aside(place) as made:
            package(made, "first")
        assert (tmp_path / left / "half").is_file()
        killed.send_signal(signal.SIGKILL)
    assert sorted(each.name for each in tmp_path.iterdir()) == [left, "package"]
    with aside(place) as made:
        package(made, "second")
    assert [each.name for each in tmp_path.iterdir()] == ["package"]
    assert "second" in (place / FILE).read_text()


def test_of_two_at_once_the_last_is_there_and_whole(tmp_path: Path) -> None:
    place = tmp_path / "package"
    with aside(place) as one:
        package(one, "one")
        with aside(place) as other:
            package(other, "other")
    assert "one" in (place / FILE).read_text()
    assert [each.name for each in tmp_path.iterdir()] == ["package"]


def test_what_came_to_stand_there_meanwhile_is_left_alone(tmp_path: Path) -> None:
    place = tmp_path / "package"
    with (  # noqa: PT012 -- what is refused is the end of what stands here
        pytest.raises(OutputError, match=r"holds no earlier package"),
        aside(place) as made,
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
    with aside(tmp_path / "package") as made:
        package(made)
    assert [each.name for each in tmp_path.iterdir()] == ["package"]


@pytest.mark.parametrize("name", ["a" * 255, "[x]*", "ä" * 100, " "])
def test_a_strange_name_is_a_name(tmp_path: Path, name: str) -> None:
    for said in ("one", "two"):
        with aside(tmp_path / name) as made:
            package(made, said)
    assert os.listdir(tmp_path) == [name]
    assert "two" in (tmp_path / name / FILE).read_text()


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    package(tmp_path / "real")
    (tmp_path / "link").symlink_to("real")
    with pytest.raises(OutputError, match=r"this is no folder"), aside(tmp_path / "link"):
        pass
