from __future__ import annotations

import struct
import time
import tracemalloc
import zlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from morph.body.inspect import inspect_robot
from morph.body.load import load
from morph.body.mjcf_bounds import GREATEST
from morph.errors import DescriptionRefused

BODY = "<body name='a'><joint/><geom size='1'/></body>"

# Where each attribute may stand.
HOLDERS = {
    "count": "<worldbody><replicate count='{}'><body><geom size='1'/></body></replicate>"
    "</worldbody>",
    "nrow": "<asset><hfield name='h' nrow='{}' ncol='2' size='1 1 1 1'/></asset>",
    "ncol": "<asset><hfield name='h' nrow='2' ncol='{}' size='1 1 1 1'/></asset>",
    "width": "<asset><texture name='t' type='2d' builtin='flat' width='{}' height='1'/></asset>",
    "height": "<asset><texture name='t' type='2d' builtin='flat' width='1' height='{}'/></asset>",
    "maxhullvert": "<asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' "
    "maxhullvert='{}'/></asset>",
    "octree_maxdepth": "<asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' "
    "octree_maxdepth='{}'/></asset>",
    "maxcontacts": "<option maxcontacts='{}'/>",
    "order": "<sensor><clock name='c' order='{}'/></sensor>",
    "dim": "<sensor><user name='u' dim='{}'/></sensor>",
    "params": "<asset><mesh name='m' builtin='supersphere' params='{} 1 1'/></asset>",
    "nsample": "<sensor><clock name='c' nsample='{}'/></sensor>",
}


def text(middle: str) -> str:
    return f"<mujoco>{middle}<worldbody>{BODY}</worldbody></mujoco>"


def refused(path: Path) -> str:
    """Return why a description was refused, within seconds and 200 MB."""
    load(path.parent / "first.xml")  # What is imported once is not counted.
    tracemalloc.start()
    began = time.process_time()
    with pytest.raises(DescriptionRefused) as error:
        load(path)
    seconds = time.process_time() - began
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert seconds < 10.0
    assert most < 200e6
    return error.value.what


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "first.xml").write_text(text(""))
    return tmp_path


@pytest.mark.parametrize("value", ["1000000000", "1e18", "-1e9"])
@pytest.mark.parametrize("key", GREATEST)
def test_an_absurd_size_is_refused_at_once(key: str, value: str, folder: Path) -> None:
    holder = HOLDERS.get(key, f"<size {key}='{{}}'/>")
    (folder / "robot.xml").write_text(text(holder.format(value)))
    assert f"asks for {key}={value}" in refused(folder / "robot.xml")


@pytest.mark.parametrize("memory", ["10G", "1000M", "8E", "99999999999"])
def test_absurd_memory_is_refused_at_once(memory: str, folder: Path) -> None:
    (folder / "robot.xml").write_text(text(f"<size memory='{memory}'/>"))
    assert f"asks for {memory} of memory" in refused(folder / "robot.xml")


COPIES = {
    "nested": "<replicate count='100'><replicate count='100'>{}</replicate></replicate>",
    "side by side": "<replicate count='600'>{}</replicate><replicate count='600'>{}</replicate>",
    "a grid": "<body><composite type='grid' count='100 100 1' spacing='1'><geom size='0.1'/>"
    "</composite></body>",
    "cloth": "<flexcomp name='f' type='grid' count='50 50 50' spacing='1 1 1'/>",
}


@pytest.mark.parametrize("how", COPIES)
def test_copies_that_multiply_are_refused_at_once(how: str, folder: Path) -> None:
    body = COPIES[how].format("<body><geom size='1'/></body>", "<body><geom size='1'/></body>")
    (folder / "robot.xml").write_text(text(f"<worldbody>{body}</worldbody>"))
    assert "with their copies" in refused(folder / "robot.xml")


@pytest.mark.parametrize("count", ["x", "", "0", "-5", "2.5", "1 x"])
def test_a_count_that_is_none_is_left_to_mujoco(count: str, folder: Path) -> None:
    holder = HOLDERS["count"].format(count)
    (folder / "robot.xml").write_text(text(holder))
    found = inspect_robot(folder / "robot.xml")
    assert found.verdict == "ok" or [each.code for each in found.findings] == ["engine-refused"]


def test_many_textures_count_together(folder: Path) -> None:
    # A cube has six sides: 6 * 1024^2 = 6.3 million; the third exceeds 2^24 = 16.8 million.
    one = "<texture name='{}' type='cube' builtin='flat' width='1024' height='1024'/>"
    for count, passes in ((2, True), (3, False)):
        assets = "".join(one.format(index) for index in range(count))
        (folder / "robot.xml").write_text(text(f"<asset>{assets}</asset>"))
        if passes:
            assert load(folder / "robot.xml").links
        else:
            assert "the textures up to this one" in refused(folder / "robot.xml")


def picture(width: int, height: int) -> bytes:
    """Return a PNG that says it is so large, and is black."""
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    rows = zlib.compress(bytes((width + 1) * min(height, 4)))
    parts = ((b"IHDR", head), (b"IDAT", rows), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(held)) + name + held + struct.pack(">I", zlib.crc32(name + held))
        for name, held in parts
    )


HILLS = (
    "<asset><hfield name='h' file='{}' size='1 1 1 1'/></asset>"
    "<worldbody><geom type='hfield' hfield='h'/></worldbody>"
)
PAINT = (
    "<asset><texture name='t' type='2d' file='{}'/><material name='m' texture='t'/></asset>"
    "<worldbody><geom size='1' material='m'/></worldbody>"
)


@pytest.mark.parametrize("holder", [HILLS, PAINT], ids=["hfield", "texture"])
@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("bomb.png", picture(100_000, 100_000)),
        ("rubbish.png", b"rubbish" * 9),
        ("empty.png", b""),
        ("heights.bin", struct.pack("<ii", 30_000, 30_000) + bytes(8)),
        ("negative.bin", struct.pack("<ii", -1, -1) + bytes(4)),
    ],
    ids=["bomb", "rubbish", "empty", "heights", "negative"],
)
def test_a_picture_that_is_none_is_left_out(
    holder: str,
    name: str,
    content: bytes,
    folder: Path,
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    (folder / name).write_bytes(content)
    (folder / "robot.xml").write_text(text(holder.format(name)))
    with processor(1.0):
        robot = load(folder / "robot.xml")
    assert [each.code for each in robot.findings if each.severity == "repaired"] == [
        "mesh-unreadable"
    ]
    assert robot.assets == {}


@pytest.mark.parametrize(
    ("holder", "content"),
    [
        (HILLS, picture(4, 4)),
        (HILLS, struct.pack("<ii", 2, 2) + struct.pack("<4f", 0.0, 1.0, 2.0, 3.0)),
        (PAINT, picture(4, 4)),
    ],
    ids=["hfield", "heights", "texture"],
)
def test_a_picture_that_is_one_is_kept(holder: str, content: bytes, folder: Path) -> None:
    name = "map.png" if content[1:4] == b"PNG" else "map.bin"
    (folder / name).write_bytes(content)
    (folder / "robot.xml").write_text(text(holder.format(name)))
    robot = load(folder / "robot.xml")
    assert list(robot.assets.values()) == [content]
    assert [each for each in robot.findings if each.severity != "info"] == []


def test_a_mesh_larger_than_any_part_is_not_read(folder: Path) -> None:
    with (folder / "part.stl").open("wb") as file:
        file.truncate(10 * 2**30)  # Sparse: it takes no room on the disk.
    holder = (
        "<asset><mesh name='p' file='part.stl'/></asset><worldbody><geom type='mesh' mesh='p'/>"
    )
    (folder / "robot.xml").write_text(text(holder + "</worldbody>"))
    tracemalloc.start()
    robot = load(folder / "robot.xml")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 200e6
    assert [each.code for each in robot.findings if each.severity == "repaired"] == [
        "mesh-too-large"
    ]


@pytest.mark.parametrize(
    "element",
    [
        "<extension><plugin plugin='mujoco.elasticity.cable'/></extension>",
        "<asset><model name='other' file='first.xml'/></asset>",
        "<actuator><plugin plugin='mujoco.pid' joint='a'/></actuator>",
    ],
    ids=["extension", "model", "plugin"],
)
def test_an_element_that_runs_code_or_another_model_is_refused(element: str, folder: Path) -> None:
    (folder / "robot.xml").write_text(text(element))
    assert "loads code or another model" in refused(folder / "robot.xml")


def test_many_files_that_are_missing_are_told_at_once(
    folder: Path, processor: Callable[[float], AbstractContextManager[None]]
) -> None:
    # As many as a description of 4 MiB holds; each is looked for and each geom looks for its own.
    number = 3000
    meshes = "".join(f"<mesh name='m{k}' file='gone{k}.stl'/>" for k in range(number))
    geoms = "".join(f"<geom type='mesh' mesh='m{k}'/>" for k in range(number))
    holder = f"<asset>{meshes}</asset><worldbody>{geoms}</worldbody>"
    (folder / "robot.xml").write_text(text(holder))
    with processor(2.0):
        robot = load(folder / "robot.xml")
    assert len([each for each in robot.findings if each.code == "mesh-missing"]) == number
