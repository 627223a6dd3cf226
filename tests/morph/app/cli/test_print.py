from __future__ import annotations

import csv
import json
import re
from io import StringIO
from pathlib import Path

import jsonschema
import mujoco
import numpy as np
import pytest

import morph.fabrication
from morph.app.cli.main import main
from morph.body.load import load
from morph.fabrication.reading import read_package
from morph.print.threemf import read_3mf
from morph.run_folder import OWNED

SCHEMA = json.loads((Path(morph.fabrication.__file__).parent / "package.schema.json").read_text())
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


def test_the_masses_of_the_robot_are_those_of_the_parts_put_together_by_steiner(
    written: Path,
) -> None:
    said = json.loads((written / "package.json").read_text())
    model = mujoco.MjModel.from_xml_path(str(written / "robot" / "robot.xml"))
    for link in said["links"]:
        mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for part in said["parts"]:
            for copy in part["copies"]:
                if copy["link"] != link["link"]:
                    continue
                pose = np.array(copy["pose_mm"]).reshape(4, 4)
                xx, yy, zz, xy, xz, yz = part["weight"]["inertia_kgm2"]
                spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                centre = pose[:3, :3] @ part["weight"]["com_m"] + pose[:3, 3] / 1000
                kg = part["weight"]["mass_kg"]
                mass += kg
                first += kg * centre
                second += pose[:3, :3] @ spread @ pose[:3, :3].T
                second += kg * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        centre = first / mass
        second -= mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        body = model.body(link["link"])
        turn = np.empty(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        axes = turn.reshape(3, 3)
        # Sums of a few doubles, and a file that writes them whole.
        assert body.mass[0] == pytest.approx(mass, rel=1e-12)
        np.testing.assert_allclose(body.ipos, centre, atol=1e-12)
        found = axes @ np.diag(body.inertia) @ axes.T
        np.testing.assert_allclose(found, second, atol=1e-9 * np.abs(second).max())


def test_other_readers_find_the_same_mass_in_the_urdf(written: Path) -> None:
    urdf, robot = str(written / "robot" / "robot.urdf"), load(written / "robot")
    pinocchio = pytest.importorskip("pinocchio")
    # It counts the base only where that may move.
    model = pinocchio.buildModelFromUrdf(urdf, pinocchio.JointModelFreeFlyer())
    assert pinocchio.computeTotalMass(model) == pytest.approx(robot.mass, rel=1e-9)
    yourdfpy = pytest.importorskip("yourdfpy")
    links = yourdfpy.URDF.load(urdf, load_meshes=False, build_scene_graph=False).robot.links
    found = sum(link.inertial.mass for link in links if link.inertial is not None)
    assert found == pytest.approx(robot.mass, rel=1e-9)


def test_each_plate_is_valid_in_millimetres_and_every_copy_is_on_one(written: Path) -> None:
    said = json.loads((written / "package.json").read_text())
    counts: dict[str, int] = {}
    for plate in said["plates"]:
        read = read_3mf(written / plate["file"])
        assert read.unit == "MilliMeter"
        for name, _ in read.items:
            counts[name] = counts.get(name, 0) + 1
    made = [part for part in (*said["parts"], *said["gauges"]) if part["printed"]]
    assert counts == {part["name"]: len(part["copies"]) or 1 for part in made}


def test_a_package_holds_what_it_names_and_nothing_unknown(written: Path) -> None:
    said = json.loads((written / "package.json").read_text())
    named = {each["file"] for each in (*said["parts"], *said["gauges"], *said["plates"])}
    known = {"assembly.html", "bom.csv", "package.json", "report.html", OWNED}
    found = {path.relative_to(written) for path in written.rglob("*") if path.is_file()}
    # What the folders of robots hold is their descriptions' to say.
    beside = {str(path) for path in found if path.parts[0] not in ("robot", "designed")}
    assert beside == (named - {""}) | known
    assert {str(path) for path in found if path.name[0] == "."} == {OWNED}


def test_the_robot_of_a_package_is_inspected_and_simulated(written: Path, tmp_path: Path) -> None:
    robot = str(written / "robot")
    assert main(["inspect", robot]) == 0
    assert main(["simulate", robot, "--seconds", "0.1", "--out", str(tmp_path / "run.csv")]) == 0


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
