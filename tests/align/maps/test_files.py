"""Maps in files: what is no map is refused before it can do harm."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from morph.alignment.errors import MapError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.files import MOST_BYTES, read, write


def one() -> AffineMap:
    law, none = np.eye(2), np.zeros(2)
    return AffineMap(
        state_law=law, state_shift=none, lift_law=law, lift_shift=none,
        action_law=np.eye(1), action_state=np.zeros((1, 2)), action_shift=np.zeros(1),
        read_law=np.eye(1), read_state=np.zeros((1, 2)), read_shift=np.zeros(1),
    )  # fmt: skip


def saved(path: Path, **parts: object) -> Path:
    numbers = {"kind": np.array("affine"), **one().weights()} | parts
    np.savez(path, **{name: value for name, value in numbers.items() if value is not None})  # type: ignore[arg-type]
    return path


def test_nothing_is_left_beside_a_file_that_was_written(tmp_path: Path) -> None:
    write(tmp_path / "map.npz", one())
    assert [each.name for each in tmp_path.iterdir()] == ["map.npz"]


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"kind": None}, r"does not say what kind of map"),
        ({"kind": np.array("guess")}, r"'guess' is no sort of map"),
        ({"kind": np.array(3.0)}, r"does not say what kind of map"),
        ({"state_law": None}, r"state_law is missing, unknown or misshapen"),
        ({"more": np.zeros(2)}, r"more is missing, unknown or misshapen"),
        ({"state_law": np.eye(3)}, r"has the shape"),
        (
            {"state_law": np.full((2, 2), np.nan)},
            r"state_law holds float64 that are not all finite",
        ),
        ({"state_law": np.array(["a", "b"])}, r"state_law holds <U1"),
    ],
)
def test_numbers_that_make_no_map_are_refused(
    parts: dict[str, object], said: str, tmp_path: Path
) -> None:
    with pytest.raises(MapError, match=said):
        read(saved(tmp_path / "map.npz", **parts))


def test_objects_are_never_unpickled(tmp_path: Path) -> None:
    class Trap:
        def __reduce__(self) -> tuple[object, tuple[str, str]]:
            return open, (str(tmp_path / "sprung"), "w")

    path = saved(tmp_path / "map.npz", state_shift=np.array([Trap()], dtype=object))
    with pytest.raises(MapError, match=r"cannot be read: .*\n  fix: .*without objects"):
        read(path)
    assert not (tmp_path / "sprung").exists()


def test_what_unpacks_to_more_than_may_be_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("state_law.npy", bytes(MOST_BYTES + 1))
    assert path.stat().st_size < 20_000
    with pytest.raises(MapError, match=r"1 arrays of 16000001 bytes, where"):
        read(path)


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut short"])
def test_what_is_no_archive_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    path.write_bytes(content)
    with pytest.raises(MapError, match=r"cannot be read"):
        read(path)


def test_a_file_that_is_missing_is_said_to_be(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"No such file"):
        read(tmp_path / "none.npz")


def locked(data: bytes) -> bytes:
    """Return an archive whose first member says that it is locked by a password."""
    changed, entry = bytearray(data), data.index(b"PK\x01\x02")
    changed[6] |= 1
    changed[entry + 8] |= 1
    return bytes(changed)


def holed(data: bytes) -> bytes:
    """Return an archive with a hole where its first member is packed."""
    changed = bytearray(data)
    changed[60:90] = bytes(30)
    return bytes(changed)


@pytest.mark.parametrize("spoil", [locked, holed])
def test_an_archive_that_cannot_be_unpacked_is_refused(
    tmp_path: Path, spoil: Callable[[bytes], bytes]
) -> None:
    path = tmp_path / "map.npz"
    np.savez_compressed(path, kind=np.array("affine"), numbers=np.arange(50.0))
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(MapError, match=r"it cannot be read"):
        read(path)


def test_a_member_that_is_no_array_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("kind.npy", b"affine")
    with pytest.raises(MapError, match=r"it holds what is no array"):
        read(path)
