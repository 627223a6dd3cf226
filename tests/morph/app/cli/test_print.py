from __future__ import annotations

import csv
import json
import re
from io import StringIO
from pathlib import Path

import jsonschema
import pytest

import morph.make
from morph.app.cli.main import main
from morph.body.load import load
from morph.make.reading import read_package

SCHEMA = json.loads((Path(morph.make.__file__).parent / "package.schema.json").read_text())
WORDS = ("--printer", "mk4", "--material", "pla", "--slicer", "none", "--quiet")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("print") / "package"
    assert main(["print", "quadruped_printed", *WORDS, "--out", str(out)]) == 0
    return out


def test_the_package_holds_all_that_was_promised(written: Path) -> None:
    said = json.loads((written / "package.json").read_text())
    jsonschema.validate(said, SCHEMA)
    for name in (
        *("report.html", "assembly.html", "bom.csv", "plates/plate_1.3mf"),
        *("robot/robot.xml", "robot/robot.urdf", "designed/robot.xml"),
        *(part["file"] for part in said["parts"]),
    ):
        assert (written / name).is_file(), name
    assert {(part["name"], len(part["copies"])) for part in said["parts"] if part["printed"]} == {
        ("body", 1),
        ("upper_leg", 4),
        ("lower_leg", 4),
    }


def test_the_robot_weighs_what_its_parts_and_what_is_bought_do(written: Path) -> None:
    said = json.loads((written / "package.json").read_text())
    parts = sum(part["weight"]["mass_kg"] * len(part["copies"]) for part in said["parts"])
    robot = load(written / "robot")
    assert robot.mass == pytest.approx(parts, rel=1e-9)
    # Eight SG90 of 9 g, four cells of 48 g and a board of 25 g; the plastic is lighter than solid.
    bought = 8 * 0.009 + 0.048 + 0.025
    assert bought < robot.mass < load("quadruped_printed").mass


def test_the_bill_counts_what_is_bought(written: Path) -> None:
    rows = list(csv.DictReader(StringIO((written / "bom.csv").read_text())))
    counts = {row["name"]: row["count"] for row in rows}
    assert counts["sg90"] == "8"
    assert counts["lower_leg"] == "4"


def test_the_report_loads_nothing_and_names_every_part(written: Path) -> None:
    page = (written / "report.html").read_text(encoding="utf-8")
    assert "default-src &#39;none&#39;" in page
    head = page[: page.index("<script")]
    assert not re.search(r"(src|href)=[\"']https?:", head)
    for name in ("upper_leg", "lower_leg", "sg90", "front_left_hip"):
        assert name in head


def test_the_package_is_read_back(written: Path) -> None:
    package = read_package(written)
    assert package.now_kg == pytest.approx(load(written / "robot").mass, rel=1e-9)
    assert {mass.source for mass in package.links} == {"estimate"}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--printer", "mk5", "--material", "pla"), "no printer is called 'mk5'"),
        (("--printer", "mk4", "--material", "wood"), "no material is called 'wood'"),
        (
            ("--printer", "mk4", "--material", "pla", "--infill", "7"),
            "infill is 7, not from 0 to 1",
        ),
        (("--printer", "mk4", "--material", "pla", "--layer", "nan"), "layer_mm is nan"),
        (("--printer", "mk4", "--material", "pla", "--policy", "nowhere"), "nowhere"),
    ],
)
def test_what_cannot_be_used_is_said_and_nothing_is_written(
    words: tuple[str, ...],
    says: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "package"
    asked = ["print", "pendulum", *words, "--slicer", "none", "--quiet", "--out", str(out)]
    assert main(asked) == 2
    said = capsys.readouterr().err
    assert says in said
    assert "fix:" in said
    assert list(tmp_path.iterdir()) == []


def test_without_a_slicer_that_is_needed_nothing_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    asked = ["print", "pendulum", "--printer", "mk4", "--material", "pla", "--slicer", "needed"]
    assert main([*asked, "--out", str(tmp_path / "package")]) == 2
    assert "there is no PrusaSlicer" in capsys.readouterr().err
