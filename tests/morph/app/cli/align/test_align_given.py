"""Files of transitions from strangers: what cannot be read is refused in three parts."""

from __future__ import annotations

import io
import os
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.cli.align_inputs import pairs, read
from morph.app.cli.main import main
from morph.errors import TransferError

RNG = np.random.default_rng(0)
GOOD: dict[str, Any] = {
    "state": RNG.normal(size=(20, 2)),
    "command": RNG.normal(size=(20, 1)),
    "after": RNG.normal(size=(20, 2)),
}


def packed(array: Any) -> bytes:
    held = io.BytesIO()
    np.save(held, array)
    return held.getvalue()


def archive(how: int = zipfile.ZIP_STORED, **members: bytes) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", how) as file:
        for name, value in {**{name: packed(GOOD[name]) for name in GOOD}, **members}.items():
            file.writestr(f"{name}.npy", value)
    return held.getvalue()


def spoilt(data: bytes, at: int, value: bytes) -> bytes:
    """Return bytes with some of the first member, and of its entry in the directory, changed."""
    changed, entry = bytearray(data), data.index(b"PK\x01\x02")
    changed[at : at + len(value)] = value
    changed[entry + at + 2 : entry + at + 2 + len(value)] = value
    return bytes(changed)


def holed(how: int) -> bytes:
    data = bytearray(archive(how))
    data[60:90] = bytes(30)
    return bytes(data)


def headed(shape: str) -> bytes:
    """Return an array of which there is nothing but what it says to be."""
    head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head


DAMAGED = {
    "larger than any memory": archive(state=headed("(1000000000000, 2000)")),
    "negative": archive(state=headed("(-20, 2)")),
    "brackets without end": archive(
        state=b"\x93NUMPY\x01\x00" + struct.pack("<H", 9000) + b"(" * 8999 + b"\n"
    ),
    "no array": archive(state=b"junk"),
    "holes where it is packed": holed(zipfile.ZIP_DEFLATED),
    "holes where it is packed otherwise": holed(zipfile.ZIP_LZMA),
    "locked": spoilt(archive(), 6, b"\x01"),
    "packed as nobody packs": spoilt(archive(), 8, b"\x63"),
    "nothing": b"",
    "half": archive()[:300],
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_file_is_refused_as_what_cannot_be_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / "odd.npz"
    path.write_bytes(DAMAGED[name])
    for of in (lambda: read(path, "--target"), lambda: pairs(path)):
        with pytest.raises(TransferError) as found:
            of()
        assert str(path) in found.value.where
        assert found.value.what.startswith(("it cannot be read: ", "state is no array"))


def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "pipe.npz"
    os.mkfifo(path)
    with pytest.raises(TransferError, match=r"it is a pipe, no regular file"):
        read(path, "--target")


@pytest.mark.parametrize(
    ("changed", "what"),
    [
        ({"state": np.full((20, 2), 1e200)}, r"state holds numbers that are .* larger than 1e\+30"),
        ({"turns": np.array(["a", "b"])}, r"turns is of type <U1 and says more than yes or no"),
        ({"turns": np.array([np.nan, 5.0])}, r"turns is of type float64 and says more"),
        ({"turns": np.zeros(2, dtype="M8[s]")}, r"turns is of type datetime64\[s\] and says more"),
        ({"turns": np.zeros(3)}, r"have the shapes"),
        ({"state_names": np.array(["\ud800", "b"])}, r"state_names holds a name with letters"),
        ({"state_names": np.array(["a\x1b[31m", "b"])}, r"state_names holds a name with letters"),
        ({"command_names": np.array([" "])}, r"command_names holds a name with letters"),
    ],
)
def test_what_a_map_could_not_use_or_a_page_not_show_is_refused(
    tmp_path: Path, changed: dict[str, Any], what: str
) -> None:
    path = tmp_path / "odd.npz"
    np.savez(path, **GOOD | changed)
    with pytest.raises(TransferError, match=what) as found:
        read(path, "--target")
    assert found.value.where == f"--target {path}"


def test_angles_that_go_round_may_be_told_by_0_and_1(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **GOOD, turns=np.array([0.0, 1.0]))
    assert read(tmp_path / "a.npz", "--target").seen.turns.tolist() == [False, True]


def test_pairs_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.npz"
    np.savez(path, source=np.full((4, 2), np.nan), target=np.ones((4, 2)))
    with pytest.raises(TransferError, match=r"source holds numbers that are not finite"):
        pairs(path)
    np.savez(path, source=np.ones((4, 2)), target=np.ones((3, 2)))
    with pytest.raises(TransferError, match=r"pairs have the shapes"):
        pairs(path)


def test_the_name_of_a_file_moves_no_cursor_and_two_of_one_name_are_both_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, law = np.random.default_rng(1), np.array([[0.9, 0.2], [0.0, 0.5]])
    for folder in ("one", "two"):
        state, command = rng.normal(size=(60, 2)), rng.normal(size=(60, 1))
        after = state @ law.T + command @ np.array([[0.0, 1.0]])
        (tmp_path / folder).mkdir()
        np.savez(tmp_path / folder / "a\x1b[31m.npz", state=state, command=command, after=after)
    files = [str(tmp_path / folder / "a\x1b[31m.npz") for folder in ("one", "two")]
    out = tmp_path / "out"
    words = ["--source", files[0], "--target", files[1], "--out", str(out), "--quiet"]
    assert main(["align", *words]) == 0
    assert "\x1b" not in capsys.readouterr().out
    text = (out / "align.json").read_text()
    assert "\\u001b" not in text.split('"provenance"')[0]
    assert text.count('"a\\\\x1b[31m') == 4  # two names, and two hashes
