from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import mujoco
import pytest
import trimesh

import morph.app.cli.convert
from morph.app.cli.main import main
from morph.body.convert import FORMATS
from morph.body.inspect import inspect_robot

SCHEMA = json.loads(
    (Path(morph.app.cli.convert.__file__).parent / "conversion.schema.json").read_text()
)
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def done(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    status = main(["convert", *map(str, arguments)])
    told = capsys.readouterr()
    assert (status, told.err) == (0, "")
    return told.out


def refused(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: str | Path) -> str:
    """Return the one message of a command that must be refused and leave all as it was."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    status = main(["convert", *map(str, arguments)])
    told = capsys.readouterr()
    assert (status, told.out) == (2, "")
    assert MESSAGE.fullmatch(told.err), told.err
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    return told.err


@pytest.mark.parametrize("to", FORMATS)
def test_what_was_written_is_named_and_can_be_simulated(
    to: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = done(capsys, "quadruped_printed", "--to", to, "--out", tmp_path / "out")
    path = tmp_path / "out" / FORMATS[to][0]
    assert str(path) in "".join(words.split())
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.body_mass.sum() == pytest.approx(inspect_robot(path).robot.mass)  # type: ignore[union-attr]
    assert max(map(len, words.splitlines())) <= max(80, len(str(path)) + 30)


def test_what_urdf_cannot_hold_is_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = done(capsys, "quadruped_four_bar", "--to", "urdf", "--out", tmp_path / "out")
    assert "URDF does not hold:\n" in words
    assert words.count("\n  the closed chain ") == 8
    words = done(capsys, "quadruped_four_bar", "--to", "mjcf", "--out", tmp_path / "out")
    assert "does not hold" not in words


def test_json_is_by_its_schema(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content = json.loads(
        done(capsys, "quadruped_printed", "--to", "urdf", "--out", tmp_path / "out", "--json")
    )
    jsonschema.Draft202012Validator(SCHEMA).validate(content)
    files = [Path(name) for name in content["files"]]
    assert set(files) == {path for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert (files[0].name, files[-1].name) == ("robot.urdf", "findings.json")
    assert "the gains of 8 servos" in content["left_out"]


@pytest.mark.parametrize("to", FORMATS)
def test_meshes_are_cut_into_pieces_when_asked(
    to: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))
    # Two boxes beside each other: the hull of both fills the gap between them as well.
    boxes = (trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 1)))
    boxes[1].apply_translation((3, 0, 0))
    trimesh.util.concatenate(boxes).export(tmp_path / "two.stl")
    (tmp_path / "robot.xml").write_text(
        "<mujoco><asset><mesh name='two' file='two.stl'/></asset><worldbody><body name='a'>"
        "<geom type='mesh' mesh='two' group='3'/></body></worldbody></mujoco>"
    )
    asked = (tmp_path / "robot.xml", "--pieces", "--to", to, "--out", tmp_path / "out", "--json")
    assert main(["convert", *map(str, asked)]) == 0
    told = capsys.readouterr()
    assert told.err == "cutting two\n"
    content = json.loads(told.out)
    jsonschema.Draft202012Validator(SCHEMA).validate(content)
    (cut,) = content["pieces"]
    # 4 of hull for 2 of boxes; a piece is rounded off by a hundredth of the whole.
    assert (cut["link"], cut["mesh"], cut["pieces"]) == ("a", "two", 2)
    assert cut["hull_ratio"] == pytest.approx(2.0, rel=1e-6)
    assert cut["pieces_ratio"] == pytest.approx(1.0, abs=0.05)
    assert mujoco.MjModel.from_xml_path(content["files"][0]).ngeom == 2


def test_repairs_are_said_and_where_to_see_them(
    real_robots: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bolt = real_robots / "erd_bolt/robots/bolt.urdf"
    words = done(capsys, bolt, "--to", "mjcf", "--out", tmp_path / "out")
    found = json.loads((tmp_path / "out" / "findings.json").read_text())["findings"]
    count = sum(each["severity"] == "repaired" for each in found)
    assert count > 0
    assert f"{count} repairs are in it, which morph inspect " in " ".join(words.split())


@pytest.mark.parametrize(("base", "kinds"), [("fixed", []), ("floating", [0]), ("board", [2])])
def test_a_base_can_be_chosen(
    base: str, kinds: list[int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robot.urdf").write_text(
        '<robot name="r"><link name="a"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" '
        'izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    out = tmp_path / "out"
    done(capsys, tmp_path / "robot.urdf", "--base", base, "--to", "urdf", "--out", out)
    assert mujoco.MjModel.from_xml_path(str(out / "robot.urdf")).jnt_type.tolist() == kinds


@pytest.mark.parametrize("robot", ["pendulum", "cartpole"])
def test_a_base_that_the_description_decides_is_not_overruled(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = (robot, "--base", "floating", "--to", "urdf", "--out", tmp_path / "out")
    assert "how its base stands: fixed, not floating" in refused(capsys, tmp_path, *asked)


@pytest.mark.parametrize("robot", ["nowhere", "gone.urdf", "empty.urdf"])
def test_a_robot_that_is_none_is_refused_and_nothing_is_written(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.urdf").touch()
    refused(capsys, tmp_path, robot, "--to", "urdf", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_of_others_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    words = refused(capsys, tmp_path, "pendulum", "--to", "urdf", "--out", tmp_path)
    assert "holds no earlier conversion" in words
    words = refused(capsys, tmp_path, "pendulum", "--to", "urdf", "--out", tmp_path / "thesis.tex")
    assert "this is a file" in words


def test_a_folder_of_others_is_refused_before_the_robot_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    words = refused(capsys, tmp_path, "nowhere", "--to", "urdf", "--out", tmp_path)
    assert "holds no earlier conversion" in words


def test_another_format_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["convert", "pendulum", "--to", "sdf", "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert "mjcf" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_an_interrupt_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("morph.body.convert.write_whole", interrupted)
    out = tmp_path / "out"
    assert main(["convert", "pendulum", "--to", "urdf", "--out", str(out)]) == 130
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert list(tmp_path.iterdir()) == []


def test_an_out_without_a_name_is_not_the_folder_where_one_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "pendulum", "--to", "mjcf", "--out", ""]) == 2
    assert capsys.readouterr().err.startswith("error: --out: no folder is named\n  fix: ")
    assert list(tmp_path.iterdir()) == []
