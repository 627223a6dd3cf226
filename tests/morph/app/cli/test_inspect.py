from __future__ import annotations

import json
import os
import pty
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import morph.body.inspect
from morph.app.cli.main import main
from morph.body import shelf
from morph.body.inspect import inspect_robot

BODIES = tuple(name for name in shelf.names() if shelf.find(name).parent == shelf.builtin_shelf())
SCHEMA = json.loads(
    (Path(morph.body.inspect.__file__).parent / "inspection.schema.json").read_text()
)
COMMAND = [sys.executable, "-c", "from morph.app.cli.main import entry; entry()", "inspect"]
URDF = '<robot name="r"><link name="{0}">{1}</link>{2}</robot>'
INERTIAL = (
    '<inertial><mass value="2"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def strict(text: str) -> Any:
    """Return what JSON holds; NaN and infinity are no JSON."""

    def refuse(word: str) -> None:
        raise ValueError(word)

    return json.loads(text, parse_constant=refuse)


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def said(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> tuple[int, str]:
    """Return the status and the words of a command that tells everything on one stream."""
    status = main(["inspect", *map(str, arguments)])
    told = capsys.readouterr()
    assert told.err == ""
    assert "Traceback" not in told.out
    return status, told.out


@pytest.mark.parametrize("name", BODIES)
def test_a_body_of_the_shelf_is_shown_in_eighty_columns(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status, words = said(capsys, name, "--strict")
    lines = words.splitlines()
    assert status == 0
    assert max(map(len, lines)) <= 80
    assert [line for line in lines if line != line.rstrip()] == []
    assert lines[0].startswith(f"{name}: ")
    assert lines[-1].startswith(f"{name}: ok, nothing was changed") or lines[-2].startswith(name)
    assert "\x1b" not in words


def test_the_words_say_what_the_numbers_say(capsys: pytest.CaptureFixture[str]) -> None:
    _, words = said(capsys, "cartpole")
    assert words.startswith("cartpole: 1 kg, 2 links, 2 joints, 2 degrees of freedom\n")
    # Half the mass is the pole's, whose centre hangs 0.25 m below the cart's.
    assert "centre of mass at home (0, 0, -0.125) m" in words
    assert re.search(r"^slide +slide +cart +unlimited +motor 10 N +0.1 N s/m$", words, re.MULTILINE)
    assert re.search(r"^hinge +hinge +pole +unlimited$", words, re.MULTILINE)
    assert re.search(r"^pole +cart +0.5 +1 capsule$", words, re.MULTILINE)


@pytest.mark.parametrize("name", [*BODIES[::6], "nowhere"])
def test_json_is_the_same_as_in_python_and_by_its_schema(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    _, words = said(capsys, name, "--json")
    content = strict(words)
    jsonschema.Draft202012Validator(SCHEMA).validate(content)
    assert content == strict(json.dumps(inspect_robot(name).as_json()))


def written(folder: Path, content: str | bytes, name: str = "robot.urdf") -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_strict_wants_nothing_repaired_but_lets_infos_pass(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = written(tmp_path, URDF.format("a", INERTIAL, ""))
    assert said(capsys, good, "--strict")[0] == 0
    assert "1 info" in said(capsys, good)[1]  # Nobody says whether its base floats.
    broken = written(tmp_path, URDF.format("a", INERTIAL.replace('izz="0.1"', 'izz="0.9"'), ""))
    assert said(capsys, broken)[0] == 0
    status, words = said(capsys, broken, "--strict")
    assert status == 2
    assert "repaired  inertia-broken" in words
    assert "r: repaired, it is simulated with the repairs above (1 repaired" in words


def bomb(folder: Path) -> Path:
    lines = ['<!DOCTYPE r [<!ENTITY a0 "boom">']
    lines += [f'<!ENTITY a{n + 1} "{f"&a{n};" * 10}">' for n in range(12)]
    return written(folder, "\n".join([*lines, "]>", "<robot name='&a12;'/>"]))


def code(folder: Path) -> Path:
    text = (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r"><link name="${{}}"/></robot>'
    )
    attack = f"__import__('pathlib').Path('{folder / 'pwned'}').touch()"
    return written(folder, text.replace("{}", attack), "robot.xacro")


def entity(folder: Path) -> Path:
    text = f'<!DOCTYPE r [<!ENTITY x SYSTEM "file://{folder / "secret"}">]><robot name="&x;"/>'
    written(folder, "the secret", "secret")
    return written(folder, text)


REFUSED: dict[str, Callable[[Path], Path | str]] = {
    "missing": lambda folder: folder / "gone.urdf",
    "misspelt": lambda _: "cartpoel",
    "nameless": lambda _: "",
    "a folder without a card": lambda folder: folder,
    "a folder that is not there": lambda folder: folder / "gone" / "",
    "a name longer than names are": lambda _: "x" * 5000,
    "a path with a null": lambda folder: f"{folder}/a\0b.urdf",
    "binary": lambda folder: written(folder, os.urandom(100_000)),
    "empty": lambda folder: written(folder, ""),
    "blank": lambda folder: written(folder, " \n" * 1000),
    "a bomb": bomb,
    "an entity": entity,
    "nested": lambda folder: written(folder, "<a>" * 1_000_000),
    "wide": lambda folder: written(folder, "<robot>" + "<a/>" * 1_000_000),
    "code": code,
    "a device": lambda _: "/dev/zero",
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_is_no_robot_is_refused_in_one_message(
    why: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    monkeypatch.chdir(tmp_path)
    robot = REFUSED[why](tmp_path)
    before = sorted(tmp_path.rglob("*"))
    # xacro is expanded in a process of its own, which begins anew.
    with processor(3.0 if why == "code" else 1.0):
        status, words = said(capsys, robot)
    assert status == 2
    assert words.count("refused  ") == 1
    assert "\n    fix: " in words
    assert "there is no robot to simulate (1 refused)" in " ".join(words.split())
    assert "the secret" not in words
    assert max(map(len, words.splitlines())) <= 80
    assert sorted(tmp_path.rglob("*")) == before


def test_a_misspelt_name_is_answered_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    words = " ".join(said(capsys, "cartpoel")[1].split())
    assert "no robot is called 'cartpoel'; nearest: cartpole" in words
    assert "morph list robots" in words


def test_a_folder_without_a_card_names_what_is_in_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "urdf").mkdir()
    written(tmp_path, "<package/>", "package.xml")
    written(tmp_path / "urdf", "<robot/>")
    words = "".join(said(capsys, tmp_path)[1].split())
    assert str(tmp_path / "urdf" / "robot.urdf") in words
    assert "package.xml" not in words


def test_a_mesh_outside_is_left_out_and_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine").mkdir()
    secret = written(tmp_path, "secret", "secret.stl")
    (tmp_path / "mine" / "link.stl").symlink_to(secret)
    mesh = '<visual><geometry><mesh filename="link.stl"/></geometry></visual>'
    path = written(tmp_path / "mine", URDF.format("a", INERTIAL + mesh, ""))
    status, words = said(capsys, path)
    assert status == 0
    assert "repaired  mesh-outside" in words


def test_nothing_outside_a_given_folder_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, URDF.format("a", INERTIAL, ""))
    (tmp_path / "other").mkdir()
    status, words = said(capsys, path, "--folder", tmp_path / "other")
    assert status == 2
    assert "lies outside" in words


HOSTILE = ("\x9b31m", "\u202egnp.exe", "a\u200bb", "tab\tin", "x" * 190, "関節" * 40, "_" * 100)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_a_name_can_neither_move_the_cursor_nor_break_the_table(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from rich.cells import cell_len

    joint = (
        f'<link name="b">{INERTIAL}</link><joint name="j {name}" type="continuous">'
        f'<parent link="{name}"/><child link="b"/></joint>'
    )
    _, words = said(capsys, written(tmp_path, URDF.format(name, INERTIAL, joint)))
    lines = words.splitlines()
    assert all(line.isprintable() for line in lines)
    assert max(map(cell_len, lines)) <= 80


def test_the_same_fault_at_many_places_is_told_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parts = "".join(
        f'<link name="part_{k}">{INERTIAL}</link><joint name="j{k}" type="revolute">'
        f'<parent link="base"/><child link="part_{k}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="0" velocity="3"/></joint>'
        for k in range(20)
    )
    _, words = said(capsys, written(tmp_path, URDF.format("base", INERTIAL, parts)))
    assert words.count("its effort limit is 0") == 1
    assert "joint j0 (line 1), j1 (line 1)" in " ".join(words.split())
    assert "and 12 more: its effort limit" in " ".join(words.split())


def test_what_is_piped_is_neither_coloured_nor_cut() -> None:
    environment = {key: value for key, value in os.environ.items() if key != "COLUMNS"}
    done = subprocess.run(
        [*COMMAND, "quadruped_four_bar"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "\x1b" not in done.stdout
    joints = [joint["name"] for joint in inspect_robot("quadruped_four_bar").as_json()["joints"]]
    assert [name for name in joints if not re.search(rf"^{name} ", done.stdout, re.M)] == []


def test_a_terminal_is_coloured() -> None:
    main_end, other_end = pty.openpty()
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "80"}
    environment.pop("NO_COLOR", None)
    process = subprocess.Popen(
        [*COMMAND, "pendulum"], env=environment, stdout=other_end, stderr=other_end
    )
    assert process.wait(timeout=60) == 0
    os.close(other_end)
    shown = os.read(main_end, 100_000).decode()
    os.close(main_end)
    assert "\x1b[1m" in shown
