"""Manifests: where files are public, and what a hostile one may not do."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from experiments.public.content import DataError
from experiments.public.manifest import MANIFESTS, Hosts, Origin, load_sets

COMMIT = "0123456789abcdef0123456789abcdef01234567"
HASH = "a" * 64
SET = f"""[[set]]
name = "rig"
kind = "robots"
about = "a rig"
licence = "MIT"
[[set.origin]]
repository = "owner/rig"
commit = "{COMMIT}"
"""


def loaded(tmp_path: Path, listing: str, manifest: str = "[file]\n") -> object:
    """Return the sets of a listing with one manifest, that of the set `rig`."""
    (tmp_path / "data.toml").write_text(listing)
    (tmp_path / "rig.toml").write_text(manifest)
    return load_sets(tmp_path / "data.toml", tmp_path)


@pytest.mark.parametrize(
    "name",
    ["../x", "/x", "a/../../x", "a//x", "./x", "a\\\\..\\\\x", "a/", "..", "a\\u0000b"],
)
def test_a_file_outside_its_set_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(DataError, match=r"(?s)rig\.toml: cannot use file .*without \.\."):
        loaded(tmp_path, SET, f'[file]\n"{name}" = [1, "{HASH}"]\n')


@pytest.mark.parametrize(
    "row",
    ["-1", "[1]", f'[-1, "{HASH}"]', f'["1", "{HASH}"]', f'[67108865, "{HASH}"]', '[1, "ab"]'],
)
def test_a_file_without_a_size_and_a_hash_is_refused(tmp_path: Path, row: str) -> None:
    # 64 MiB is 67108864 bytes.
    with pytest.raises(DataError, match="cannot use size and hash of 'a'"):
        loaded(tmp_path, SET, f'[file]\n"a" = {row}\n')


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("owner/rig", "../rig", "repository '../rig'"),
        ("owner/rig", "owner/rig/../../other", "repository"),
        ("owner/rig", "https://evil.example/x", "repository"),
        (COMMIT, "main", "commit 'main' of owner/rig"),
        (COMMIT, COMMIT[:7], "commit '0123456'"),
        ('name = "rig"', 'name = "../rig"', "name '../rig'"),
        ('kind = "robots"', 'kind = "../robots"', "kind"),
        ('licence = "MIT"', 'license = "MIT"', "set rig: .*licen[cs]e"),
        ("[[set.origin]]\n", '[[set.origin]]\nfolder = "../other"\n', "folder"),
        ("[[set.origin]]\n", '[[set.origin]]\nbelow = "/etc"\n', "folder"),
        ("[[set.origin]]\n", '[[set.origin]]\nfiles = ["../a"]\n', "folder"),
        (
            "[[set.origin]]\n",
            '[[set.made]]\nfile = "../a"\nby = "xacro"\ninputs = ["b"]\n[[set.origin]]\n',
            "file '../a'",
        ),
    ],
)
def test_a_set_that_could_reach_elsewhere_is_refused(
    tmp_path: Path, before: str, after: str, message: str
) -> None:
    assert loaded(tmp_path, SET)
    with pytest.raises(DataError, match=message):
        loaded(tmp_path, SET.replace(before, after))


def test_a_file_that_no_origin_has_is_refused(tmp_path: Path) -> None:
    narrow = SET.replace("[[set.origin]]\n", '[[set.origin]]\nbelow = "urdf"\n')
    with pytest.raises(DataError, match="no origin of rig has LICENSE"):
        loaded(tmp_path, narrow, f'[file]\n"LICENSE" = [1, "{HASH}"]\n')


@pytest.mark.parametrize(
    ("origin", "file", "path"),
    [
        (Origin(folder="log"), "a/b.csv", "log/a/b.csv"),
        (Origin(folder="log", below="a"), "a/b.csv", "log/b.csv"),
        (Origin(folder="log", below="a"), "ab.csv", None),
        (Origin(files=("LICENSE",)), "LICENSE", "LICENSE"),
        (Origin(files=("LICENSE",)), "b.csv", None),
        (Origin(folder="all", joined="__"), "maker__arm__a_b.urdf", "all/maker/arm/a_b.urdf"),
    ],
)
def test_an_origin_says_where_a_file_of_the_set_is_public(
    origin: Origin, file: str, path: str | None
) -> None:
    assert origin.path_of(file) == path


def test_an_address_is_quoted() -> None:
    origin = Origin(repository="owner/rig", commit=COMMIT)
    address = origin.url("a b/#1?.csv", Hosts().raw)
    assert address == (f"https://raw.githubusercontent.com/owner/rig/{COMMIT}/a%20b/%231%3F.csv")


def test_every_set_has_files_and_a_commit_or_says_what_is_not_established() -> None:
    sets = load_sets()
    assert {whole.name for whole in sets} == {path.stem for path in MANIFESTS.glob("*.toml")}
    for whole in sets:
        assert whole.files, whole.name
        unknown = [origin for origin in whole.origins if origin.commit == "unknown"]
        assert not unknown or whole.unsettled, whole.name


def test_no_two_files_of_the_sets_have_one_address_or_one_place() -> None:
    files = [(whole, public) for whole in load_sets() for public in whole.files]
    places = [whole.folder(Path("nowhere")) / public.file for whole, public in files]
    assert len(set(places)) == len(places)
    addresses = [
        public.origin.url(public.path, "https://host")
        for _, public in files
        if public.origin.repository
    ]
    shape = r"https://host/[\w.-]+/[\w.-]+/([0-9a-f]{40}|HEAD)/[\w./%-]+"
    assert [one for one in addresses if not re.fullmatch(shape, one)] == []
    # Licences of two sets of one repository are one file.
    assert len(addresses) - len(set(addresses)) == 1
