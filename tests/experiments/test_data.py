"""The downloader, against files on this machine instead of the network."""

from __future__ import annotations

import gzip
import hashlib
import re
from pathlib import Path

import pytest

from experiments.data import DataError, Source, check, data_root, download, main, sources

CONTENT = b"time,position\n0.0,0.1\n"


@pytest.fixture
def source(tmp_path: Path) -> Source:
    """Return a recording that is public as a local file."""
    public = tmp_path / "public.csv"
    public.write_bytes(CONTENT)
    digest = hashlib.sha256(CONTENT).hexdigest()
    return Source(
        set="rig", file="day/run.csv.gz", url=public.as_uri(), size=len(CONTENT), sha256=digest
    )


def test_a_download_is_verified_gzipped_and_not_done_twice(source: Source, tmp_path: Path) -> None:
    root = tmp_path / "data"
    assert download(source, root)
    assert gzip.decompress((root / "rig" / "day" / "run.csv.gz").read_bytes()) == CONTENT
    check(source, root)
    (tmp_path / "public.csv").unlink()
    assert not download(source, root)


@pytest.mark.parametrize(
    ("sent", "message"),
    [(CONTENT[:-3], "19 bytes instead of 22"), (CONTENT[::-1], "has sha256 .* instead of")],
)
def test_what_was_not_used_is_refused_and_not_written(
    source: Source, tmp_path: Path, sent: bytes, message: str
) -> None:
    (tmp_path / "public.csv").write_bytes(sent)
    with pytest.raises(DataError, match=message):
        download(source, tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_without_a_network_the_address_and_the_way_out_are_named(
    source: Source, tmp_path: Path
) -> None:
    (tmp_path / "public.csv").unlink()
    with pytest.raises(DataError, match=r"(?s)public\.csv: cannot download.*MORPH_RECORDINGS"):
        download(source, tmp_path / "data")


def test_a_damaged_copy_is_downloaded_again(source: Source, tmp_path: Path) -> None:
    path = source.at(tmp_path / "data")
    download(source, tmp_path / "data")
    path.write_bytes(path.read_bytes()[:-6])
    with pytest.raises(DataError, match="cannot be read"):
        check(source, tmp_path / "data")
    assert download(source, tmp_path / "data")


def test_the_root_is_the_folder_that_the_environment_names(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path))
    assert data_root() == tmp_path


def test_check_ends_with_2_where_a_recording_is_missing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path))
    assert main(["--check"]) == 2
    assert "cannot be read: No such file" in capsys.readouterr().err


def test_every_address_holds_a_commit_and_no_file_is_named_twice() -> None:
    known = sources()
    assert len({s.at(Path()) for s in known}) == len(known) == len({s.url for s in known})
    shape = r"https://raw\.githubusercontent\.com/[\w.-]+/[\w.-]+/[0-9a-f]{40}/.+\.csv"
    assert all(re.fullmatch(shape, s.url) for s in known)
    assert {s.set for s in known} == {"dfki_double_pendulum", "so101_sage"}


def test_the_recordings_on_this_machine_are_those_that_were_used() -> None:
    root = data_root()
    if not all(source.at(root).exists() for source in sources()):
        pytest.skip(f"the recordings are not under {root}; get them: python -m experiments.data")
    for source in sources():
        check(source, root)
