"""The study's scoring, and its command line."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from experiments.plant.defect import Places, Planted
from experiments.plant.originals import packaged_root
from experiments.planted import judged, main


def _finding(code: str, kind: str, name: str, what: str = "") -> dict[str, Any]:
    return {"code": code, "where": {"kind": kind, "name": name}, "what": what}


PLANT = Planted(
    defect="flipped-axis",
    variant="negated",
    robot="biped",
    site="left_hip",
    fact="",
    did="",
    places=Places(
        parts=frozenset({"left_hip", "left_thigh"}),
        meshes=frozenset({"thigh.stl"}),
        partners=frozenset({"right_hip"}),
    ),
    codes=frozenset({"axis-flipped"}),
    also=frozenset({"joint-axis"}),
)


@pytest.mark.parametrize(
    ("finding", "named", "own", "twin"),
    [
        (_finding("axis-flipped", "joint", "left_hip"), True, True, False),
        (_finding("joint-axis", "joint", "left_hip"), True, False, False),
        (_finding("axis-flipped", "joint", "right_hip", "beside left_hip"), True, True, True),
        (_finding("axis-flipped", "joint", "right_hip", "its twin"), False, False, False),
        (_finding("axis-flipped", "joint", "left_knee"), False, False, False),
        (_finding("axis-flipped", "robot", "left_hip"), False, False, False),
        (_finding("limb-mirrored", "joint", "left_hip"), False, False, False),
        (_finding("axis-flipped", "mesh", "package://a/Thigh.STL"), True, True, False),
    ],
)
def test_a_defect_is_named_by_a_right_code_at_a_right_place(
    finding: dict[str, Any], named: bool, own: bool, twin: bool
) -> None:
    row = judged(PLANT, [], [finding], "repaired")
    assert (row["named"], row["by_own_code"], row["by_twin_only"]) == (named, own, twin)
    assert len(row["found"] + row["beside"] + row["elsewhere"]) == 1


def test_what_the_original_had_already_names_nothing() -> None:
    known = _finding("axis-flipped", "joint", "left_hip")
    row = judged(PLANT, [known], [known], "repaired")
    assert not row["named"]
    assert row["known_before"] == ["axis-flipped"]
    assert judged(replace(PLANT, codes=frozenset({"mimic"})), [known], [], "ok")["found"] == []


def test_a_dry_run_says_where_the_defects_go(
    real_robots: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if not packaged_root().is_dir():
        pytest.skip("example-robot-data is not installed")
    assert main(["--dry", "--per-class", "2", "--defect", "lost-base"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 2
    assert all(line.startswith("lost-base") for line in said)


def test_a_part_of_the_originals_is_not_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MORPH_ROBOTS", str(tmp_path))
    assert main(["--dry"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "files of aqua are not there" in said.err
    assert "MORPH_ROBOTS" in said.err


@pytest.mark.parametrize("talkative", [False, True])
def test_an_importer_that_says_the_same_of_every_copy_names_nothing(
    real_robots: Path,
    talkative: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if not packaged_root().is_dir():
        pytest.skip("example-robot-data is not installed")

    def same(path: Path) -> tuple[list[dict[str, Any]], str]:
        links = [str(link.get("name")) for link in ET.parse(path).findall("link")]
        said = [_finding("axis-flipped", "link", name) for name in links if talkative]
        return said, "ok"

    monkeypatch.setattr("experiments.planted.inspected", same)
    asked = ["--quiet", "--per-class", "2", "--defect", "flipped-axis", "--defect", "lfs-stub"]
    assert main(asked) == 0
    said = capsys.readouterr().out
    assert "all: 0/4 = 0.0%" in said
    assert said.count("missed:") == 4
    assert ("already in the original: axis-flipped" in said) == talkative
    assert "new in originals that were only written anew: 0" in said
