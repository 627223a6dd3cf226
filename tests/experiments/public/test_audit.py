"""What a folder of data lacks, has otherwise, or has beyond its manifests."""

from __future__ import annotations

import gzip
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from experiments.public.audit import audit, write_manifest
from experiments.public.content import DataError
from experiments.public.manifest import load_sets

COMMIT = "0123456789abcdef0123456789abcdef01234567"
LISTING = f"""[[set]]
name = "rig"
kind = "recordings"
about = "a rig"
licence = "MIT"
stored = "gzip"
notes = ["README.md"]
[[set.origin]]
repository = "owner/rig"
commit = "{COMMIT}"
"""


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A folder with one set of two files, and its listing and manifest beside it."""
    folder = tmp_path / "shared" / "recordings" / "rig"
    (folder / "day").mkdir(parents=True)
    (folder / "README.md").write_text("what I think of it\n")
    (folder / "LICENSE").write_text("MIT\n")
    (folder / "day" / "run.csv.gz").write_bytes(gzip.compress(b"0,1\n"))
    (tmp_path / "data.toml").write_text(LISTING)
    (whole,) = load_sets(tmp_path / "data.toml", tmp_path)
    write_manifest(tmp_path / "shared", whole, tmp_path)
    return tmp_path / "shared"


def test_a_folder_agrees_with_the_manifest_written_from_it(root: Path) -> None:
    sets = load_sets(root.parent / "data.toml", root.parent)
    found = audit(root, sets)
    assert found.whole
    assert found.right == 2
    # The folder of one kind may be named, too.
    assert audit(root / "recordings", sets) == found
    # Packed by another hand it is the same.
    (root / "recordings/rig/day/run.csv.gz").write_bytes(gzip.compress(b"0,1\n", 1, mtime=7))
    assert audit(root, sets) == found


def test_what_is_missing_different_or_unlisted_is_named(root: Path) -> None:
    folder = root / "recordings" / "rig"
    (folder / "LICENSE").unlink()
    (folder / "day" / "run.csv.gz").write_bytes(gzip.compress(b"0,2\n"))
    (folder / "day" / "notes.txt").write_text("mine\n")
    found = audit(root, load_sets(root.parent / "data.toml", root.parent))
    assert found.missing == ("rig/LICENSE",)
    assert found.unlisted == ("rig/day/notes.txt",)
    assert found.different[0].startswith("rig/day/run.csv.gz: has sha256 ")
    assert (found.right, found.whole) == (0, False)


def test_what_is_no_regular_file_is_named_and_not_waited_for(root: Path) -> None:
    folder = root / "recordings" / "rig"
    (folder / "LICENSE").rename(folder / "README.md")
    os.mkfifo(folder / "LICENSE")
    run = folder / "day" / "run.csv.gz"
    run.rename(root / "run.csv.gz")
    run.symlink_to(root / "run.csv.gz")
    os.mkfifo(folder / "pipe")
    (folder / "nowhere").symlink_to(root / "nothing")
    (folder / "outside").symlink_to(root)
    found = audit(root, load_sets(root.parent / "data.toml", root.parent))
    assert found.different == (
        "rig/LICENSE: it is a pipe, no regular file",
        "rig/day/run.csv.gz: it is a link",
    )
    assert found.unlisted == ("rig/nowhere", "rig/outside", "rig/pipe")
    with pytest.raises(DataError, match="cannot be read"):
        write_manifest(root, load_sets(root.parent / "data.toml", root.parent)[0], root)


def test_a_file_is_not_read_beyond_the_most_that_a_set_may_hold(root: Path) -> None:
    with (root / "recordings" / "rig" / "LICENSE").open("wb") as file:
        file.truncate(2**40)
    found = audit(root, load_sets(root.parent / "data.toml", root.parent))
    assert found.different[0].startswith(f"rig/LICENSE: it has {2**40} bytes, and ")


def test_a_bomb_is_not_unpacked_beyond_what_is_declared(root: Path) -> None:
    # 100 MB of zeros pack to 0.1 MB; 5 bytes are read, one more than the 4 declared.
    (root / "recordings/rig/day/run.csv.gz").write_bytes(gzip.compress(bytes(10**8)))
    found = audit(root, load_sets(root.parent / "data.toml", root.parent))
    assert found.different == ("rig/day/run.csv.gz: holds 5 bytes instead of 4",)


def test_no_manifest_is_written_from_nothing(root: Path, tmp_path: Path) -> None:
    (whole,) = load_sets(root.parent / "data.toml", root.parent)
    shutil.rmtree(root)
    with pytest.raises(DataError, match="holds no file of rig"):
        write_manifest(root, replace(whole, files=()), tmp_path / "elsewhere")
    assert not (tmp_path / "elsewhere").exists()
