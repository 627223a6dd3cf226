"""Files that a description names are found inside its folder, and nowhere else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.body.paths import MOST_ALIKE, Files, _common, own_folder

XML = "<package><name>arm_description</name></package>"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package `arm` with meshes, and a canary outside it."""
    root = tmp_path / "work" / "arm"
    for name in (
        "urdf/robot.urdf",
        "meshes/visual/upper.stl",
        "meshes/visual/Lower.STL",
        "meshes/collision/upper.stl",
        "meshes/hand.obj",
        "meshes/.hidden/hidden.stl",
    ):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(name)
    (root / "package.xml").write_text(XML)
    (tmp_path / "work" / "canary.stl").write_text("canary")
    (tmp_path / "work" / "arm_secrets").mkdir()
    (tmp_path / "work" / "arm_secrets" / "canary.stl").write_text("canary")
    return root


def found(package: Path, written: str) -> tuple[str | None, str]:
    """Return what a path leads to, seen from the package, and how it was found."""
    result = Files(package / "urdf" / "robot.urdf").find(written)
    inside = None if result.path is None else str(result.path.relative_to(package.resolve()))
    return inside, result.how


@pytest.mark.parametrize(
    ("written", "file"),
    [
        ("../meshes/visual/upper.stl", "meshes/visual/upper.stl"),
        ("../meshes/collision/upper.stl", "meshes/collision/upper.stl"),
        ("./../meshes/./hand.obj", "meshes/hand.obj"),
        ("..\\meshes\\hand.obj", "meshes/hand.obj"),
        (" ../meshes/hand.obj ", "meshes/hand.obj"),
        ("file://../meshes/hand.obj", "meshes/hand.obj"),
        ("package://arm/meshes/hand.obj", "meshes/hand.obj"),
        ("package://arm_description/meshes/hand.obj", "meshes/hand.obj"),
        ("PACKAGE://arm/meshes/visual/../hand.obj", "meshes/hand.obj"),
        ("model://arm/meshes/hand.obj", "meshes/hand.obj"),
    ],
)
def test_a_right_path_is_found_without_a_word(package: Path, written: str, file: str) -> None:
    assert found(package, written) == (file, "exact")


def test_an_absolute_path_into_the_folder_is_right(package: Path) -> None:
    path = package / "meshes" / "hand.obj"
    assert found(package, str(path)) == ("meshes/hand.obj", "exact")
    assert found(package, f"file://{path}") == ("meshes/hand.obj", "exact")


@pytest.mark.parametrize(
    ("written", "file", "how"),
    [
        # The package bears another name here, as after a download: nothing is wrong with the file.
        ("package://other_name/meshes/hand.obj", "meshes/hand.obj", "package"),
        (
            "package://stack/robots/arm/meshes/visual/upper.stl",
            "meshes/visual/upper.stl",
            "package",
        ),
        ("../meshes/HAND.obj", "meshes/hand.obj", "case"),
        ("package://arm/Meshes/Visual/Upper.stl", "meshes/visual/upper.stl", "case"),
        ("package://arm/meshes/visual/lower.stl", "meshes/visual/Lower.STL", "case"),
        ("hand.obj", "meshes/hand.obj", "moved"),
        ("meshes/hand.obj", "meshes/hand.obj", "moved"),
        ("/usr/author/arm/meshes/hand.obj", "meshes/hand.obj", "moved"),
        ("file:///usr/author/arm/meshes/hand.obj", "meshes/hand.obj", "moved"),
        ("C:\\robots\\arm\\meshes\\hand.obj", "meshes/hand.obj", "moved"),
        ("package://arm/hand.obj", "meshes/hand.obj", "moved"),
        ("package://arm/stl/hand.obj", "meshes/hand.obj", "moved"),
        ("package:///hand.obj", "meshes/hand.obj", "moved"),
        ("../../../meshes/hand.obj", "meshes/hand.obj", "moved"),
    ],
)
def test_a_wrong_path_is_searched_for_inside_and_it_is_said(
    package: Path, written: str, file: str, how: str
) -> None:
    assert found(package, written) == (file, how)


def test_of_files_of_one_name_the_one_with_most_of_the_path_is_taken(package: Path) -> None:
    assert found(package, "package://x/visual/upper.stl")[0] == "meshes/visual/upper.stl"
    assert found(package, "package://x/collision/upper.stl")[0] == "meshes/collision/upper.stl"
    assert found(package, "/a/b/collision/upper.stl")[0] == "meshes/collision/upper.stl"


def test_of_files_alike_in_all_but_capitals_the_exact_one_is_taken(package: Path) -> None:
    (package / "meshes" / "HAND.obj").write_text("other")
    if len(list((package / "meshes").glob("*.obj"))) == 2:  # Some systems hold only one.
        assert found(package, "package://x/meshes/HAND.obj")[0] == "meshes/HAND.obj"
        assert found(package, "package://x/meshes/hand.obj")[0] == "meshes/hand.obj"


def test_an_ambiguous_name_means_the_same_file_every_time(package: Path) -> None:
    chosen = {found(package, "upper.stl") for _ in range(5)}
    assert len(chosen) == 1
    # That it was a guess is said.
    assert chosen.pop()[1] == "moved"


@pytest.mark.parametrize(
    "written",
    [
        *("", " ", "/", "..", ".", "../..", "package://", "package://arm", "file://", "://"),
        *(
            "meshes",
            "../meshes",
            "package://arm/meshes",
            "nothing.stl",
            "package://arm/nothing.stl",
        ),
        *("a\0b.stl", "hand.obj\0.stl", "hidden.stl", "http://example.org/other.stl"),
        *("a" * 300 + ".stl", "a/" * 400 + "hand.stl", "x" * 5000, "/" * 5000, "../" * 2000),
        *("~/hand.stl", "$HOME/hand.stl", "${arm}/x.stl", "*.stl", "meshes/*", "-"),
    ],
)
def test_what_is_not_there_is_missing_and_no_error(package: Path, written: str) -> None:
    assert found(package, written)[0] is None


OUT = [
    "../../canary.stl",
    "../../arm/../canary.stl",
    "../../arm_secrets/canary.stl",
    "package://arm/../canary.stl",
    "package://arm/../arm_secrets/canary.stl",
    "file://../../canary.stl",
    "/etc/passwd",
    "file:///etc/passwd",
    "/proc/self/environ",
    "../../../../../../../../../etc/passwd",
    "..\\..\\canary.stl",
]


@pytest.mark.parametrize("written", OUT)
def test_a_path_that_leads_out_is_never_taken(package: Path, written: str) -> None:
    assert found(package, written) == (None, "outside")


@pytest.mark.parametrize("written", ["../../canary.stl", "../../no_canary.stl"])
def test_what_lies_outside_is_not_even_told_to_be_there(package: Path, written: str) -> None:
    assert found(package, written) == (None, "outside")


def test_links_that_lead_out_are_not_followed(package: Path) -> None:
    outside = package.parent
    (package / "meshes" / "canary.stl").symlink_to(outside / "canary.stl")
    (package / "meshes" / "secrets").symlink_to(outside / "arm_secrets")
    (package / "meshes" / "there_and_back.stl").symlink_to(package / "meshes" / "canary.stl")
    for written in (
        "../meshes/canary.stl",
        "package://arm/meshes/canary.stl",
        "../meshes/secrets/canary.stl",
        "package://arm/meshes/secrets/canary.stl",
        "../meshes/there_and_back.stl",
        "canary.stl",
        "CANARY.stl",
    ):
        assert found(package, written)[0] is None, written


def test_links_inside_the_folder_are_followed(package: Path) -> None:
    (package / "meshes" / "alias.obj").symlink_to("hand.obj")
    path, how = found(package, "../meshes/alias.obj")
    assert how == "exact"
    assert (package / str(path)).read_text() == "meshes/hand.obj"


def test_a_circle_of_links_is_missing(package: Path) -> None:
    (package / "meshes" / "one.stl").symlink_to("two.stl")
    (package / "meshes" / "two.stl").symlink_to("one.stl")
    assert found(package, "../meshes/one.stl")[0] is None


def test_a_pipe_is_no_file(package: Path) -> None:
    os.mkfifo(package / "meshes" / "pipe.stl")
    assert found(package, "../meshes/pipe.stl")[0] is None


def test_a_folder_whose_name_begins_like_ours_is_outside(package: Path) -> None:
    # arm_secrets begins with arm: a comparison of texts would take it for a part.
    files = Files(package / "urdf" / "robot.urdf")
    assert files.find(str(package.parent / "arm_secrets" / "canary.stl")).how == "outside"


def test_a_folder_that_is_given_bounds_what_is_read(package: Path) -> None:
    narrow = Files(package / "urdf" / "robot.urdf", package / "urdf")
    assert narrow.find("../meshes/hand.obj").how == "outside"
    wide = Files(package / "urdf" / "robot.urdf", package.parent)
    assert wide.find("../../canary.stl").how == "exact"


def test_the_own_folder_is_the_package_or_the_one_above_urdf(tmp_path: Path) -> None:
    for name, marks in (
        ("a/urdf/r.urdf", []),
        ("b/x/y/r.urdf", ["b/package.xml"]),
        ("c/r.urdf", []),
    ):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text("")
        for mark in marks:
            (tmp_path / mark).write_text("")
    assert own_folder(tmp_path / "a/urdf/r.urdf") == (tmp_path / "a").resolve()
    assert own_folder(tmp_path / "b/x/y/r.urdf") == (tmp_path / "b").resolve()
    assert own_folder(tmp_path / "c/r.urdf") == (tmp_path / "c").resolve()


@pytest.mark.parametrize(
    "content", ["", "<package>", "<package/>", "<package><name/></package>", "\x00", "<!DOCTYPE a>"]
)
def test_a_damaged_package_file_is_no_hindrance(package: Path, content: str) -> None:
    (package / "package.xml").write_text(content)
    assert found(package, "package://arm/meshes/hand.obj") == ("meshes/hand.obj", "exact")


PARTS = ["..", ".", "", "arm", "meshes", "visual", "upper.stl", "canary.stl", "arm_secrets", "etc"]


@settings(deadline=None, max_examples=200)
@given(
    scheme=st.sampled_from(["", "/", "package://", "file://", "file:///", "x://"]),
    parts=st.lists(st.one_of(st.sampled_from(PARTS), st.text(max_size=8)), max_size=8),
)
def test_no_path_at_all_leads_out(
    tmp_path_factory: pytest.TempPathFactory, scheme: str, parts: list[str]
) -> None:
    root = tmp_path_factory.getbasetemp() / "walls"
    if not root.exists():
        (root / "arm" / "meshes").mkdir(parents=True)
        (root / "arm" / "meshes" / "upper.stl").write_text("")
        (root / "canary.stl").write_text("")
        (root / "arm" / "meshes" / "up").symlink_to(root)
    result = Files(root / "arm" / "robot.urdf").find(scheme + "/".join(parts))
    assert (result.path is None) == (result.how in ("missing", "outside"))
    if result.path is not None:
        assert result.path.resolve().is_relative_to((root / "arm").resolve())
        assert result.path.is_file()


@pytest.mark.parametrize("kind", ["link", "pipe"])
def test_a_manifest_that_is_no_file_of_the_folder_is_not_opened(
    kind: str, package: Path, tmp_path: Path
) -> None:
    manifest = package / "package.xml"
    manifest.rename(tmp_path / "elsewhere.xml")
    if kind == "link":
        manifest.symlink_to(tmp_path / "elsewhere.xml")
    else:
        os.mkfifo(manifest)
    assert Files(package / "urdf" / "robot.urdf").packages == {"arm"}


def test_only_the_beginning_of_a_manifest_is_read(package: Path) -> None:
    with (package / "package.xml").open("ab") as manifest:
        # Sparse: 1 TiB of zeros fits no memory.
        manifest.truncate(2**40)
    assert Files(package / "urdf" / "robot.urdf").packages == {"arm"}


def test_few_files_of_one_name_are_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for index in range(MOST_ALIKE + 50):
        (tmp_path / f"{index:03}").mkdir()
        (tmp_path / f"{index:03}" / "part.stl").write_text("x")
    compared = []

    def counted(wanted: tuple[str, ...], there: tuple[str, ...]) -> tuple[int, int]:
        compared.append(there)
        return _common(wanted, there)

    monkeypatch.setattr("morph.body.paths._common", counted)
    result = Files(tmp_path / "robot.urdf").find("gone/part.stl")
    assert result.path == tmp_path.resolve() / "000" / "part.stl"
    assert len(compared) == MOST_ALIKE
