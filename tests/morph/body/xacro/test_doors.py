"""Xacro that reaches outside its folder: nothing there is opened, and nothing is written."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from morph.body.xacro import expand, process
from morph.errors import RobotError

NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
SECRET = "the-secret-outside"


def robot(inside: str) -> str:
    return f'<robot {NAMESPACE} name="r">\n{inside}\n</robot>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A description's folder, with something outside that it must not reach."""
    (tmp_path / "outside").mkdir()
    secret = f'<robot {NAMESPACE}><link name="{SECRET}"/></robot>'
    for name in ("secret.xacro", "secret.yaml"):
        (tmp_path / "outside" / name).write_text(secret if name.endswith("o") else f"a: {SECRET}")
    own = tmp_path / "own"
    (own / "urdf").mkdir(parents=True)
    (own / "package.xml").write_text("<package><name>mine</name></package>")
    (own / "urdf" / "part.xacro").write_text(robot('<link name="part"/>'))
    (own / "numbers.yaml").write_text("mass: 2.5\nlimits: {hip: [1, 2]}\nangle: !degrees 180\n")
    return own


def written(folder: Path, inside: str) -> Path:
    path = folder / "urdf" / "robot.urdf.xacro"
    path.write_text(robot(inside))
    return path


def link(expression: str) -> str:
    return f'<link name="{expression}"/>'


OUTSIDE = {
    "include of an absolute path": '<xacro:include filename="/etc/passwd"/>',
    "include that climbs": '<xacro:include filename="../../outside/secret.xacro"/>',
    "optional include that climbs": (
        '<xacro:include filename="../../outside/secret.xacro" optional="true"/>'
    ),
    "pattern that climbs": '<xacro:include filename="../../outside/*.xacro"/>',
    "pattern that climbs behind": '<xacro:include filename="*/../../../outside/*.xacro"/>',
    "pattern of the root": '<xacro:include filename="/e*/pass*"/>',
    "include by a name made up": (
        '<xacro:property name="up" value="../.."/>'
        '<xacro:include filename="${up}/outside/secret.xacro"/>'
    ),
    "include by an argument": (
        '<xacro:arg name="up" default="../.."/>'
        '<xacro:include filename="$(arg up)/outside/secret.xacro"/>'
    ),
    "include by find": '<xacro:include filename="$(find mine)/../outside/secret.xacro"/>',
    "find of a path": '<xacro:include filename="$(find ../outside)/secret.xacro"/>',
    "find of dots": '<xacro:include filename="$(find ..)/outside/secret.xacro"/>',
    "include by dirname": '<xacro:include filename="$(dirname)/../../outside/secret.xacro"/>',
    "include by environment": '<xacro:include filename="$(env HOME)/secret.xacro"/>',
    "include by optenv": '<xacro:include filename="$(optenv X ../../outside)/secret.xacro"/>',
    "include by eval": "<xacro:include filename=\"$(eval '../../outside/secret.xacro')\"/>",
    "include by cwd": '<xacro:include filename="$(cwd)/outside/secret.xacro"/>',
    "include by a url": '<xacro:include filename="file:///etc/passwd"/>',
    "include of a device": '<xacro:include filename="/dev/zero"/>',
    "include of a pipe": '<xacro:include filename="pipe"/>',
    "include of a folder": '<xacro:include filename="../urdf"/>',
    "include through a link": '<xacro:include filename="link.xacro"/>',
    "include through a linked folder": '<xacro:include filename="linked/secret.xacro"/>',
    "pattern through a linked folder": '<xacro:include filename="li*/secret.xacro"/>'
    '<xacro:include filename="lin*.xacro"/>',
    "include of a name too long": f'<xacro:include filename="{"9" * 400}"/>',
    "include of a path too long": f'<xacro:include filename="{"9/" * 4000}"/>',
    "include of a long pattern": f'<xacro:include filename="{"*/" * 4000}"/><xacro:nobody/>',
    "include of a zero": "<xacro:include filename=\"${'\\x00'}\"/>",
    "include of half a character": "<xacro:include filename=\"${'\\ud800'}\"/>",
    "find of a long name": f'<xacro:include filename="$(find {"a" * 5000})/x"/>',
    "include of itself": '<xacro:include filename="robot.urdf.xacro"/>',
    "yaml outside": link("${load_yaml('../../outside/secret.yaml')}"),
    "yaml outside by namespace": link("${xacro.load_yaml('/etc/passwd')}"),
    "yaml through find": link("${xacro.load_yaml('$(find mine)/../outside/secret.yaml')}"),
    "yaml through a link": link("${xacro.load_yaml('linked/secret.yaml')}"),
    "yaml of aliases": link("${load_yaml('bomb.yaml')}"),
    "yaml that nests": link("${load_yaml('deep.yaml')}"),
    "yaml that runs code": link("${load_yaml('code.yaml').x.y}"),
    "environment": link("$(env HOME)"),
    "environment by eval": link("${env('HOME')}"),
    "unknown command": link("$(anon x)"),
}


def plant(folder: Path) -> None:
    """Add what hostile descriptions reach for."""
    urdf = folder / "urdf"
    (urdf / "link.xacro").symlink_to(folder.parent / "outside" / "secret.xacro")
    (urdf / "linked").symlink_to(folder.parent / "outside")
    os.mkfifo(urdf / "pipe")
    lines = ["a0: &a0 [x, x]"] + [f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]" for n in range(1, 60)]
    (urdf / "bomb.yaml").write_text("\n".join(lines))
    (urdf / "deep.yaml").write_text("[" * 100_000)
    (urdf / "code.yaml").write_text("x: !!python/object/apply:os.system ['true']")


@pytest.mark.parametrize("name", OUTSIDE)
def test_what_reaches_outside_is_refused_by_line(folder: Path, name: str) -> None:
    plant(folder)
    with pytest.raises(RobotError, match=r"\.xacro:\d+: ") as error:
        expand(written(folder, OUTSIDE[name]), folder)
    assert SECRET not in str(error.value)


def test_a_file_that_is_missing_or_outside_is_refused(folder: Path) -> None:
    with pytest.raises(RobotError, match="is not there"):
        expand(folder / "none.xacro", folder)
    with pytest.raises(RobotError, match="leads out"):
        expand(folder.parent / "outside" / "secret.xacro", folder)
    (folder / "door.xacro").symlink_to(folder.parent / "outside" / "secret.xacro")
    with pytest.raises(RobotError, match="leads out"):
        expand(folder / "door.xacro", folder)


def test_an_expansion_that_takes_too_long_is_ended(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "SECONDS", 0.001)
    with pytest.raises(RobotError, match="for too long"):
        expand(written(folder, ""), folder)


WATCHED = """
import json, sys
opened, watching = [], []
def watch(event, arguments):
    if watching and event in ("open", "os.listdir", "os.scandir"):
        opened.append(str(arguments[0]))
sys.addaudithook(watch)
from morph.body.xacro import child
shut = child._shut
def shut_and_watch(folder):
    shut(folder)
    watching.append(True)
child._shut = shut_and_watch
answer, _ = child._answer(json.loads(sys.argv[1]))
watching.clear()
print(json.dumps([answer, opened]))
"""


def answer(folder: Path, inside: str) -> tuple[dict[str, str], list[str]]:
    """Return what the process says when nobody has looked before, and what it opens."""
    path = folder / "urdf" / "robot.urdf.xacro"
    path.write_text(robot(inside))
    request = {"path": str(path), "folder": str(folder), "arguments": {}, "elements": 10_000}
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, json.dumps(request)],
        capture_output=True,
        text=True,
        check=True,
    )
    said, opened = json.loads(done.stdout)
    return said, opened


@pytest.mark.parametrize("name", OUTSIDE)
def test_the_process_by_itself_opens_nothing_outside(folder: Path, name: str) -> None:
    plant(folder)
    said, opened = answer(folder, OUTSIDE[name])
    assert "what" in said
    # A number is a file opened by its name before.
    assert [
        path for path in opened if not path.isdigit() and not path.startswith(f"{folder}")
    ] == []


def test_the_watch_sees_what_is_opened(folder: Path) -> None:
    said, opened = answer(folder, '<xacro:include filename="part.xacro"/>')
    assert "what" not in said
    assert f"{folder}/urdf/part.xacro" in opened


GUARDED = """
import os, socket, subprocess, sys
from pathlib import Path
from morph.body.xacro.child import _shut
own, outside = sys.argv[1:]
mine = own + "/numbers.yaml"
_shut(Path(own))
open(mine).close()
os.listdir(own)
tries = [
    lambda: open(outside), lambda: open(own + "/new", "w"), lambda: open(mine, "a"),
    lambda: os.open(mine, os.O_RDWR), lambda: os.listdir("/"), lambda: os.system("true"),
    lambda: subprocess.run(["true"]), lambda: socket.socket(), lambda: exec("1"),
    lambda: os.remove(mine), lambda: os.fork(), lambda: __import__("sqlite3"),
    lambda: os.rename(mine, own + "/new"), lambda: os.symlink("a", own + "/b"),
]
for number, each in enumerate(tries):
    try:
        each()
    except PermissionError:
        continue
    sys.exit(f"try {number} went through")
"""


def test_the_doors_are_shut_even_if_an_expression_could_run_code(folder: Path) -> None:
    outside = str(folder.parent / "outside" / "secret.xacro")
    done = subprocess.run([sys.executable, "-c", GUARDED, str(folder), outside], check=False)
    assert done.returncode == 0


def test_nothing_is_written(folder: Path) -> None:
    def state() -> dict[str, tuple[int, int]]:
        found = [folder.parent, *folder.parent.rglob("*")]
        return {str(p): (p.lstat().st_mtime_ns, p.lstat().st_size) for p in found}

    (folder / "urdf" / "robot.urdf.xacro").write_text(robot(link("${load_yaml('x.yaml')}")))
    (folder / "robot.xacro").write_text(robot('<xacro:include filename="urdf/p*.xacro"/>'))
    before = state()
    assert b'name="part"' in expand(folder / "robot.xacro", folder)
    with pytest.raises(RobotError, match="not there"):
        expand(folder / "urdf" / "robot.urdf.xacro", folder)
    assert state() == before


def test_a_folder_that_is_reached_by_a_link_is_its_own_folder(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.xacro").write_text('<robot name="a"><link name="b"/></robot>')
    (tmp_path / "linked").symlink_to(tmp_path / "real")
    assert b"link" in expand(tmp_path / "linked" / "a.xacro", tmp_path / "linked")


def test_a_path_from_where_one_stands_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a.xacro").write_text('<robot name="a"><link name="b"/></robot>')
    (tmp_path / "linked").symlink_to(tmp_path / "real")
    monkeypatch.chdir(tmp_path)
    assert b"link" in expand(Path("linked/a.xacro"), tmp_path / "real")
    assert b"link" in expand(Path("real/a.xacro"), Path("real"))
