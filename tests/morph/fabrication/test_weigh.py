"""A package corrected by a scale."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError
from morph.fabrication.content import Package
from morph.fabrication.package import write_content, write_parts, write_robots
from morph.fabrication.package_folder import package_folder
from morph.fabrication.reading import read_package
from morph.fabrication.weigh import Weighed, write_weighed


@pytest.fixture
def written(tmp_path: Path, package: Package, pendulum: Robot) -> Path:
    """The pendulum of two bars, written without a policy."""
    folder = tmp_path / "package"
    with package_folder(folder) as made:
        robot = write_robots(made, pendulum, package)
        files = write_parts(made, package.job, {"Title": package.title})
        write_content(made, replace(package, made_sha256=robot.sha256), files)
    return folder


def weigh(folder: Path, **grams: float) -> Weighed:
    package = read_package(folder)
    shown = dict(package.readings) | {part: 1e-3 * each for part, each in grams.items()}
    with package_folder(folder) as made:
        return write_weighed(folder, made, package, shown, seconds=1.0)


def contents(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_link_weighs_what_its_parts_show_by_steiners_theorem(written: Path) -> None:
    found = weigh(written, bar=12.0)
    (rod,) = load(written / "robot").links
    # 0.1 kg bought at 0.5 m, and two bars of 12 g at 0.4 m and 0.6 m.
    assert rod.mass == pytest.approx(0.124, rel=1e-12)
    assert rod.com == pytest.approx((0.0, 0.0, -0.5), abs=1e-12)
    # m / 12 (b2 + c2) of each in mm, and 12 g at 0.1 m twice, about x.
    bar, ball = 0.012 / 12 * (20**2 + 40**2) * 1e-6, 0.1 / 12 * (2 * 30**2) * 1e-6
    assert rod.inertia[0] == pytest.approx(2 * bar + ball + 2 * 0.012 * 0.1**2, rel=1e-9)
    assert found.before_kg == pytest.approx(0.12)
    assert found.package.links[0].source == "scale"
    assert (written / "robot" / "robot.urdf").is_file()


def test_what_is_written_is_read_back_with_its_readings(written: Path) -> None:
    weigh(written, bar=12.0)
    found = read_package(written)
    assert found.readings == {"bar": pytest.approx(0.012)}
    measured = found.links[0].measured
    assert measured is not None
    assert measured.mass == pytest.approx(0.124)
    assert found.made_sha256 == load(written / "robot").sha256
    # What was designed and what was predicted stay.
    assert found.links[0].designed.mass == pytest.approx(1.0)
    assert found.links[0].predicted is not None
    assert found.links[0].predicted.mass == pytest.approx(0.12)


def test_readings_of_several_sessions_add_up_in_any_order(written: Path, tmp_path: Path) -> None:
    import shutil

    other = tmp_path / "other"
    shutil.copytree(written, other)
    weigh(written, bar=12.0)
    weigh(written, ball=90.0)
    weigh(other, ball=90.0)
    weigh(other, bar=11.0)
    weigh(other, bar=12.0)
    one, two = (load(folder / "robot") for folder in (written, other))
    assert one.sha256 == two.sha256
    assert one.links[0].mass == pytest.approx(0.09 + 0.024)


def test_weighing_again_changes_no_byte(written: Path) -> None:
    weigh(written, bar=12.0)
    before = contents(written)
    weigh(written, bar=12.0)
    assert contents(written) == before


def test_forgetting_every_reading_gives_the_masses_that_were_predicted(written: Path) -> None:
    before = load(written / "robot").links
    weigh(written, bar=12.0)
    assert load(written / "robot").links != before
    package = read_package(written)
    with package_folder(written) as made:
        write_weighed(written, made, package, {}, seconds=1.0)
    assert load(written / "robot").links == before
    assert read_package(written).links[0].source == "estimate"


@pytest.mark.parametrize("breaks", ["write_printed", "write_content"])
def test_what_fails_on_the_way_leaves_the_package_as_it_was(
    written: Path, breaks: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    before = contents(written)
    monkeypatch.setattr(f"morph.fabrication.weigh.{breaks}", full)
    with pytest.raises(Exception, match="No space left"):
        weigh(written, bar=12.0)
    assert contents(written) == before
    assert [each.name for each in written.parent.iterdir() if "package" in each.name] == ["package"]


def test_a_package_whose_robot_is_another_is_refused(
    written: Path, change: Callable[[Path, str, object], None]
) -> None:
    change(written / "package.json", "links", [])
    with pytest.raises(MakeError, match="the package speaks of"):
        weigh(written, bar=12.0)


@pytest.fixture
def change() -> Callable[[Path, str, object], None]:
    def changed(path: Path, key: str, value: object) -> None:
        said = json.loads(path.read_text())
        path.write_text(json.dumps(said | {key: value}))

    return changed


def test_masses_stay_physical_however_light_a_reading_is(written: Path) -> None:
    weigh(written, bar=0.001)
    (rod,) = load(written / "robot").links
    xx, yy, zz = rod.inertia[:3]
    assert xx + yy > zz > 0
    assert np.isfinite(rod.com).all()
