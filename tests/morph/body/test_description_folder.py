"""Nothing outside a description's folder is opened, whatever the description names."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from morph.body.description import read_description
from morph.errors import DescriptionRefused

WATCHED = """
import json, sys
from pathlib import Path
from morph.body.description import read_description
from morph.errors import MorphError

WATCHED_FOR = ("open", "os.listdir", "os.scandir", "os.mkdir", "os.rename", "os.remove",
               "os.symlink", "subprocess.Popen", "socket.connect")
folder, opened, watching = Path(sys.argv[1]).resolve(), [], False

def watch(event, arguments):
    # A number is a file that is open: its path was told when it was opened.
    if watching and not isinstance(arguments[0], int) and event in WATCHED_FOR:
        opened.append((event, str(arguments[0])))

sys.addaudithook(watch)
for path in sorted(folder.glob("*/urdf/*.urdf")):
    for once in (False, True):  # The first time imports what it needs.
        watching = once
        try:
            read_description(path, base="fixed")
        except MorphError:
            pass
        watching = False
outside = [(event, name) for event, name in opened if not name.startswith(str(folder / "arm"))]
print(json.dumps((len(opened), outside)))
"""
"""Reads descriptions while every file that is opened is written down."""


def test_nothing_outside_the_folder_is_opened(bench: Any, tmp_path: Path) -> None:
    stl = b"solid a\nendsolid a\n"
    outside = [
        "../../canary.stl",
        "/etc/passwd",
        "package://arm/../canary.stl",
        "file:///etc/hosts",
    ]
    outside += ["../meshes/link.stl", "../meshes/folder/canary.stl", "~/.ssh/id_rsa"]
    inside = ["../meshes/here.stl", "package://other/here.stl", "HERE.STL"]
    bench.folder = tmp_path / "work"
    path = bench.write(
        *[bench.link("a", *(bench.mesh(file) for file in (*outside, *inside)))],
        name="arm/urdf/robot.urdf",
        files={"../meshes/here.stl": stl, "../../canary.stl": stl},
    )
    (path.parent.parent / "meshes" / "link.stl").symlink_to(tmp_path / "work" / "canary.stl")
    (path.parent.parent / "meshes" / "folder").symlink_to(tmp_path / "work")
    entity = '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="&a;"/>'
    (path.parent / "entity.urdf").write_text(entity)
    command = [sys.executable, "-c", WATCHED, str(tmp_path / "work")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    count, strays = json.loads(done.stdout)
    assert count >= 3
    assert strays == []


def test_a_description_that_is_a_link_out_of_the_given_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "given").mkdir()
    (tmp_path / "outside.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    link = tmp_path / "given" / "robot.urdf"
    link.symlink_to(tmp_path / "outside.urdf")
    with pytest.raises(DescriptionRefused) as caught:
        read_description(link, base="fixed", folder=tmp_path / "given")
    assert caught.value.findings[0].severity == "refused"
