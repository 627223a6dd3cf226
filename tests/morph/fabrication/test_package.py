from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import morph.fabrication
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError, OutputError
from morph.fabrication.content import Package
from morph.fabrication.package import DESIGNED, ROBOT, write_content, write_parts, write_robots
from morph.fabrication.package_folder import check_out, package_folder
from morph.fabrication.reading import read_package

SCHEMA = json.loads((Path(morph.fabrication.__file__).parent / "package.schema.json").read_text())


@pytest.fixture
def written(tmp_path: Path, package: Package, pendulum: Robot) -> Path:
    folder = tmp_path / "package"
    with package_folder(folder) as made:
        robot = write_robots(made, pendulum, package)
        package = replace(package, made_sha256=robot.sha256, readings={"bar": 0.015})
        files = write_parts(made, package.job, {"Title": package.title})
        write_content(made, package, files)
    return folder


def test_what_is_written_is_what_its_schema_says(written: Path) -> None:
    jsonschema.validate(json.loads((written / "package.json").read_text()), SCHEMA)


def test_a_package_is_read_back_as_it_was(written: Path, package: Package) -> None:
    found = read_package(written)
    bar, ball = found.job.parts
    was = package.job.parts[0]
    assert (bar.number, bar.count, bar.seats[0].holds, ball.kind) == ("P-01", 2, "M3", "bought")
    assert found.readings == {"bar": pytest.approx(0.015)}
    assert bar.mesh is not None
    assert was.mesh is not None
    # STL holds 32-bit floats: 6e-8 of 40 mm is 2.4e-6 mm, and volume 3 * 6e-8 of it.
    assert bar.mesh.volume == pytest.approx(was.mesh.volume, rel=2e-7)
    np.testing.assert_allclose(bar.mesh.bounds, was.mesh.bounds, atol=3e-6)
    for one, other in zip(found.links, package.links, strict=True):
        assert one.now.mass == other.now.mass
        np.testing.assert_array_equal(one.now.inertia, other.now.inertia)
    assert found.hinges[0].name == "hinge"
    assert found.job.profile == package.job.profile


def test_the_robots_are_the_designed_one_and_the_one_with_the_masses_of_its_parts(
    written: Path, package: Package, pendulum: Robot
) -> None:
    before, after = load(written / DESIGNED), load(written / ROBOT)
    assert before.mass == pytest.approx(pendulum.mass, rel=1e-12)
    # Two bars of 10 g and a ball of 100 g.
    assert after.mass == pytest.approx(0.120, rel=1e-12)
    assert after.sha256 == read_package(written).made_sha256
    assert load(written / ROBOT / "robot.urdf").mass == pytest.approx(0.120, rel=1e-12)


def spoiled(folder: Path, change: object) -> None:
    path = folder / "package.json"
    said = json.loads(path.read_text())
    change(said)  # type: ignore[operator]
    path.write_text(json.dumps(said))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda said: said.update(schema="morph.package/9"), r"its schema is not"),
        (lambda said: said.update(extra=1), r"the key 'extra' is unknown"),
        (lambda said: said["parts"][0].update(file="../../secret.stl"), r"is not in the package"),
        (lambda said: said["parts"][0].update(file="parts/none.stl"), r"cannot be read"),
        (lambda said: said["parts"][0].update(kind="grown"), r"is 'grown'"),
        (
            lambda said: said["parts"][0]["weight"].update(mass_kg=-1.0),
            r"an inertia that no body has",
        ),
        (
            lambda said: said["parts"][0]["copies"][0].update(pose_mm=[1.0] * 16),
            r"also stretches",
        ),
        (
            lambda said: said["parts"][0]["copies"][0].update(pose_mm=[1.0] * 4),
            r"4 numbers stand where 16",
        ),
        (lambda said: said["links"][0].update(source="hearsay"), r"comes from 'hearsay'"),
        (lambda said: said.update(gauges=said["parts"]), r"two parts have the same name"),
    ],
)
def test_a_package_that_was_tampered_with_is_refused(
    written: Path, change: object, says: str
) -> None:
    spoiled(written, change)
    with pytest.raises(MakeError, match=says):
        read_package(written)


@pytest.mark.parametrize("content", [b"", b"{", b'{"schema": NaN}', b"[" * 100_000, b"\xff\xfe"])
def test_what_is_no_package_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "package.json").write_bytes(content)
    with pytest.raises(MakeError, match=r"package\.json"):
        read_package(tmp_path)


def test_a_failure_on_the_way_leaves_the_earlier_package(written: Path) -> None:
    before = (written / "package.json").read_bytes()
    with pytest.raises(ValueError, match=r"on the way"), package_folder(written) as made:  # noqa: PT012
        (made / "half").write_text("half")
        raise ValueError("on the way")
    assert (written / "package.json").read_bytes() == before
    assert [each.name for each in written.parent.iterdir()] == ["package"]


def test_nothing_is_written_over_what_is_no_package(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with (
        pytest.raises(OutputError, match=r"holds no earlier package"),
        package_folder(tmp_path),
    ):
        pass
    assert (tmp_path / "letter.txt").read_text() == "dear"


def rewrite(folder: Path, package: Package, robot: Robot) -> None:
    with package_folder(folder) as made:
        write_robots(made, robot, package)
        write_content(made, package, write_parts(made, package.job, {}))


def test_what_a_user_put_beside_a_package_stays_when_it_is_made_anew(
    written: Path, package: Package, pendulum: Robot
) -> None:
    (written / "notes.txt").write_text("precious")
    (written / "photos").mkdir()
    (written / "photos" / "one.jpg").write_bytes(b"\xff\xd8")
    rewrite(written, package, pendulum)
    assert (written / "notes.txt").read_text() == "precious"
    assert (written / "photos" / "one.jpg").read_bytes() == b"\xff\xd8"
    assert [each.name for each in written.parent.iterdir()] == ["package"]


@pytest.mark.parametrize("name", ["parts/mine.stl", "robot/notes.txt", "policy/mine.txt"])
def test_a_user_s_file_in_a_folder_of_a_package_is_never_deleted(name: str, written: Path) -> None:
    (written / name).parent.mkdir(exist_ok=True)
    (written / name).write_text("mine")
    with (
        pytest.raises(OutputError, match=rf"{name}: .*would be deleted"),
        package_folder(written),
    ):
        pass
    assert (written / name).read_text() == "mine"


def test_a_package_whose_list_of_files_is_gone_is_not_replaced(written: Path) -> None:
    (written / ".morph.files").unlink()
    with pytest.raises(OutputError, match="missing or damaged"), package_folder(written):
        pass
    assert (written / "package.json").is_file()


def test_the_current_folder_is_not_replaced(written: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(written)
    with pytest.raises(OutputError, match=r"this is the current folder"):
        check_out(Path("."))
