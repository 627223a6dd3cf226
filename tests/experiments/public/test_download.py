"""Fetching from a server on this machine that is honest, cut short, slow, wrong or hostile."""

from __future__ import annotations

import gzip
import hashlib
import os
import urllib.error
from functools import partial
from http.client import HTTPMessage
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any
from urllib.request import Request

import pytest

from experiments.public.content import DataError
from experiments.public.download import SafeRedirect, fetch, install
from experiments.public.manifest import DataSet, Origin, load_sets, with_files

COMMIT = "0123456789abcdef0123456789abcdef01234567"
CONTENT = b"time,position\n0.0,0.1\n"
PATH = f"/owner/rig/{COMMIT}/log/day/run.csv"


def a_set(files: dict[str, bytes], *, stored: str = "raw") -> DataSet:
    """Return a set of one repository, `owner/rig`, with these files as they are public."""
    origin = Origin(repository="owner/rig", commit=COMMIT, folder="log")
    whole = DataSet(
        name="rig",
        kind="recordings",
        licence="MIT",
        about="a rig",
        origins=(origin,),
        stored=stored,
    )
    packed = ".gz" if stored == "gzip" else ""
    rows = {
        f"{name}{packed}": [len(data), hashlib.sha256(data).hexdigest()]
        for name, data in files.items()
    }
    return with_files(whole, rows, "rig.toml")


def send(handler: BaseHTTPRequestHandler, data: bytes, length: int) -> None:
    """Send data, and say that there are so many bytes."""
    handler.send_response(200)
    handler.send_header("Content-Length", str(length))
    handler.end_headers()
    handler.wfile.write(data)


RIG = a_set({"day/run.csv": CONTENT})


def put(whole: DataSet, root: Path, server: Any, patience: float = 60.0) -> bool:
    """Install the only file of a set."""
    (public,) = whole.files
    get = partial(fetch, patience=patience)
    return install(whole, public, root, hosts=server.hosts, get=get)


def left(root: Path) -> list[Path]:
    """Return all files under a root, half-written ones too."""
    return [path for path in root.rglob("*") if path.is_file()]


def test_a_file_is_stored_as_public_and_fetched_once(server: Any, tmp_path: Path) -> None:
    server.files[PATH] = CONTENT
    assert put(RIG, tmp_path, server)
    assert left(tmp_path) == [tmp_path / "recordings" / "rig" / "day" / "run.csv"]
    assert left(tmp_path)[0].read_bytes() == CONTENT
    assert not put(RIG, tmp_path, server)
    assert server.asked == [PATH]


def test_a_table_is_stored_packed_but_public_and_hashed_unpacked(
    server: Any, tmp_path: Path
) -> None:
    server.files[PATH] = CONTENT
    packed = a_set({"day/run.csv": CONTENT}, stored="gzip")
    assert put(packed, tmp_path, server)
    (path,) = left(tmp_path)
    assert path.name == "run.csv.gz"
    assert gzip.decompress(path.read_bytes()) == CONTENT
    # A copy that was cut short counts as missing.
    path.write_bytes(path.read_bytes()[:-6])
    assert put(packed, tmp_path, server)
    assert gzip.decompress(path.read_bytes()) == CONTENT


def cut_short(handler: BaseHTTPRequestHandler) -> None:
    send(handler, CONTENT[:-3], len(CONTENT))
    handler.close_connection = True


def endless(handler: BaseHTTPRequestHandler) -> None:
    handler.send_response(200)
    handler.end_headers()
    while True:
        handler.wfile.write(bytes(2**16))


def nothing(handler: BaseHTTPRequestHandler) -> None:
    handler.close_connection = True


def not_there(handler: BaseHTTPRequestHandler) -> None:
    handler.send_error(404)


def in_circles(handler: BaseHTTPRequestHandler) -> None:
    handler.send_response(302)
    handler.send_header("Location", handler.path)
    handler.end_headers()


def to_a_local_file(handler: BaseHTTPRequestHandler) -> None:
    handler.send_response(302)
    handler.send_header("Location", Path(__file__).as_uri())
    handler.end_headers()


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda handler: send(handler, CONTENT[::-1], len(CONTENT)), "has sha256 .* instead of"),
        (cut_short, "holds 19 bytes instead of 22"),
        (endless, "answers with more than the 512 bytes that are declared"),
        (nothing, "cannot download"),
        (not_there, "cannot download: 404 Not Found"),
        (in_circles, "infinite loop"),
        (to_a_local_file, "cannot download: 302"),
    ],
)
def test_what_is_not_the_file_is_refused_and_nothing_is_written(
    server: Any, tmp_path: Path, answer: object, message: str
) -> None:
    server.answers[PATH] = answer  # type: ignore[assignment]
    with pytest.raises(DataError, match=rf"(?s){message}.*fix:"):
        put(RIG, tmp_path, server)
    assert left(tmp_path) == []
    # The same file is had as soon as the server is honest.
    del server.answers[PATH]
    server.files[PATH] = CONTENT
    assert put(RIG, tmp_path, server)


@pytest.mark.parametrize("first", [b"", CONTENT[:5]])
def test_a_server_that_never_ends_its_answer_is_left(
    server: Any, tmp_path: Path, first: bytes
) -> None:
    def stall(handler: BaseHTTPRequestHandler) -> None:
        send(handler, first, len(CONTENT))
        server.over.wait()

    server.answers[PATH] = stall
    with pytest.raises(DataError, match=r"cannot download: .*timed out"):
        put(RIG, tmp_path, server, patience=0.1)
    assert left(tmp_path) == []


def test_a_server_that_drips_is_left_though_every_byte_comes_in_time(server: Any) -> None:
    def drip(handler: BaseHTTPRequestHandler) -> None:
        send(handler, b"", 10**9)
        while not server.over.wait(0.01):
            handler.wfile.write(b".")
            handler.wfile.flush()

    server.answers[PATH] = drip
    # At 100 bytes a second 10^9 take months: only the time ends it. A machine so busy
    # that connecting takes as long says the other.
    with pytest.raises(DataError, match=r"not complete after 0\.2 s|timed out"):
        fetch(f"{server.address}{PATH}", 10**9, patience=0.2)


def test_a_redirect_is_followed(server: Any, tmp_path: Path) -> None:
    def moved(handler: BaseHTTPRequestHandler) -> None:
        handler.send_response(301)
        handler.send_header("Location", "/elsewhere")
        handler.end_headers()

    server.answers[PATH] = moved
    server.files["/elsewhere"] = CONTENT
    assert put(RIG, tmp_path, server)


def test_a_redirect_out_of_encryption_is_not_followed() -> None:
    asked = Request("https://raw.example/file")
    with pytest.raises(urllib.error.URLError, match="not encrypted"):
        SafeRedirect().redirect_request(
            asked, None, 302, "Found", HTTPMessage(), "http://raw.example/file"
        )


def pointer(data: bytes) -> bytes:
    digest = hashlib.sha256(data).hexdigest()
    text = f"version https://git-lfs.github.com/spec/v1\noid sha256:{digest}\nsize {len(data)}\n"
    return text.encode()


def test_what_git_lfs_keeps_is_fetched_from_where_it_keeps_it(server: Any, tmp_path: Path) -> None:
    server.files[PATH] = pointer(CONTENT)
    server.files[f"/media{PATH}"] = CONTENT
    assert put(RIG, tmp_path, server)
    assert left(tmp_path)[0].read_bytes() == CONTENT


@pytest.mark.parametrize("other", [b"something else", CONTENT[::-1]])
def test_a_pointer_to_anything_else_is_not_followed(
    server: Any, tmp_path: Path, other: bytes
) -> None:
    server.files[PATH] = pointer(other)
    server.files[f"/media{PATH}"] = other
    with pytest.raises(DataError, match="bytes instead of 22"):
        put(RIG, tmp_path, server)
    assert server.asked == [PATH]
    assert left(tmp_path) == []


def test_a_pointer_that_was_published_as_the_file_stays_one(server: Any, tmp_path: Path) -> None:
    stub = pointer(CONTENT)
    server.files[PATH] = stub
    assert put(a_set({"day/run.csv": stub}), tmp_path, server)
    assert left(tmp_path)[0].read_bytes() == stub


def test_a_pipe_in_place_of_a_file_is_replaced_and_not_waited_for(
    server: Any, tmp_path: Path
) -> None:
    server.files[PATH] = CONTENT
    path = tmp_path / "recordings" / "rig" / "day" / "run.csv"
    path.parent.mkdir(parents=True)
    os.mkfifo(path)
    assert put(RIG, tmp_path, server)
    assert path.is_file()
    assert path.read_bytes() == CONTENT


def test_a_link_does_not_lead_a_file_outside(server: Any, tmp_path: Path) -> None:
    server.files[PATH] = CONTENT
    outside = tmp_path / "outside"
    outside.mkdir()
    folder = tmp_path / "data" / "recordings" / "rig"
    folder.mkdir(parents=True)
    (folder / "day").symlink_to(outside)
    with pytest.raises(DataError, match="is led outside by a link"):
        put(RIG, tmp_path / "data", server)
    assert left(outside) == []
    assert server.asked == []


def test_a_key_pressed_while_fetching_leaves_nothing(tmp_path: Path) -> None:
    def pressed(url: str, most: int) -> bytes:
        raise KeyboardInterrupt

    (public,) = RIG.files
    with pytest.raises(KeyboardInterrupt):
        install(RIG, public, tmp_path, get=pressed)
    assert left(tmp_path) == []


def test_what_a_killed_run_had_begun_is_swept_away(server: Any, tmp_path: Path) -> None:
    server.files[PATH] = CONTENT
    folder = tmp_path / "recordings" / "rig" / "day"
    folder.mkdir(parents=True)
    # Under such a name a file is written before it is renamed.
    (folder / ".run.csv.k1lled").write_bytes(CONTENT[:4])
    (folder / ".run2.csv.mine").write_bytes(b"another's")
    assert put(RIG, tmp_path, server)
    assert {path.name for path in left(tmp_path)} == {"run.csv", ".run2.csv.mine"}


def test_a_commit_that_is_unknown_asks_the_default_branch(server: Any, tmp_path: Path) -> None:
    origin = Origin(repository="owner/rig", commit="unknown")
    rows = {"run.csv": [len(CONTENT), hashlib.sha256(CONTENT).hexdigest()]}
    loose = DataSet(name="rig", kind="robots", licence="MIT", about="a rig", origins=(origin,))
    server.files["/owner/rig/HEAD/run.csv"] = CONTENT
    assert put(with_files(loose, rows, "rig.toml"), tmp_path, server)


def test_what_a_package_holds_needs_no_network(tmp_path: Path) -> None:
    (bolt,) = (whole for whole in load_sets() if whole.name == "erd_bolt")
    for public in bolt.files:
        assert install(bolt, public, tmp_path, get=no_network)
    assert len(left(tmp_path)) == len(bolt.files) > 10


def test_another_version_of_a_package_is_refused(tmp_path: Path) -> None:
    origin = Origin(package="example-robot-data", version="0.1", folder="x")
    whole = DataSet(name="rig", kind="robots", licence="MIT", about="a rig", origins=(origin,))
    whole = with_files(whole, {"a.urdf": [1, "0" * 64]}, "rig.toml")
    message = r"(?s)version 6.* instead of 0\.1.*pip install example-robot-data==0\.1"
    with pytest.raises(DataError, match=message):
        install(whole, whole.files[0], tmp_path, get=no_network)


def no_network(url: str, most: int) -> bytes:
    raise AssertionError(url)
