"""`morph weigh`, from the command line."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.fabrication.content import Package
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.package import write_content, write_parts, write_robots
from morph.fabrication.package_folder import package_folder
from morph.fabrication.policies import matched_in
from morph.fabrication.printed import designed
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.store import write_policy
from morph.print.job import Job, Laid, Orientation, Plate
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement
from morph.print.printer import Profile, material, printer
from morph.print.sliced import Sliced
from morph.print.weight import Weight
from morph.task.tasks import task

CORNERS = np.array([[0.0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]])
WEDGE = Mesh(vertices=CORNERS, faces=np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


def job(weight: Weight) -> Job:
    """A rod printed as one wedge that weighs as the description says."""
    rod = Part(
        name="rod",
        number="P-01",
        kind="printed",
        mesh=WEDGE,
        placements=(Placement(link="rod", pose=np.eye(4), world=np.eye(4)),),
        weight=weight,
    )
    lies = Orientation(turn=np.eye(3), support_mm3=0.0, first_support_mm3=0.0, height_mm=30.0)
    pose = np.eye(4)
    pose[:2, 3] = 50.0
    return Job(
        profile=Profile(printer=printer("mk4"), material=material("pla")),
        parts=(rod,),
        refused=(),
        checks=(),
        orientations={"rod": lies},
        sliced={"rod": Sliced(source="estimate", weight=weight, support_kg=0.0, seconds=60.0)},
        plates=(Plate(name="plate_1", laid=(Laid(part="rod", copy=0, pose=pose),)),),
    )


@pytest.fixture(scope="module", autouse=True)
def few_runs() -> Iterator[None]:
    """Policies are judged by 20 runs, not by 100: what holds a pendulum holds it in every one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("morph.fabrication.match.case.MOST", 20)
        yield


@pytest.fixture(scope="module")
def made_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pendulum that a spring of 20 N m/rad balances, printed as it was designed."""
    base = tmp_path_factory.mktemp("made")
    robot = load("pendulum")
    before = designed(robot)["rod"]
    package = Package(
        name="pendulum",
        title="A pendulum",
        designed_sha256=robot.sha256,
        job=job(before),
        links=(
            LinkMass(
                link="rod", designed=before, predicted=before, measured=None, source="estimate"
            ),
        ),
        complete=frozenset({"rod"}),
    )
    asked = task("balance", robot)
    # Upright is at half a turn, where the sine falls: 20 sin(q) - 4 v holds it.
    spring = Linear(
        weight=np.array([[-4.0, 20.0, 0.0]]),
        bias=np.zeros(1),
        angles=np.array([1.0, 0.0]),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=asked.period,
    )
    learned = write_policy(
        spring, base / "learned", robot, task=asked.name, task_sha256=asked.sha256
    )
    place = base / "package"
    with package_folder(place) as made:
        found = write_robots(made, robot, package)
        _, said = matched_in(made, learned, robot, seconds=2.0)
        assert said.verdict == "holds"
        files = write_parts(made, package.job, {})
        write_content(made, replace(package, made_sha256=found.sha256, policy=said), files)
    return place


@pytest.fixture
def folder(tmp_path: Path, made_once: Path) -> Path:
    """A copy, which a test may change."""
    return Path(shutil.copytree(made_once, tmp_path / "package", symlinks=True))


def test_a_reading_corrects_the_robot_and_the_policy_is_tried(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["weigh", str(folder), "P-01=950", "--seconds", "60", "--quiet"]) == 0
    told = capsys.readouterr().out
    assert "A pendulum weighs 0.9500 kg; it was 1.0000 kg before" in told
    assert "rod: 950.00 g, 1000.00 g predicted" in told
    assert "the policy holds" in told
    assert load(folder / "robot").mass == pytest.approx(0.95)
    assert (folder / "report.html").is_file()


def test_a_policy_that_is_lost_is_told_by_the_exit_status(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Upright, gravity pulls by 8 * 9.81 * 0.5 = 39 N m per rad, and the spring holds 20.
    given = ["weigh", str(folder), "rod=8000", "--anyway", "--no-match", "--quiet"]
    assert main(given) == 3
    told = capsys.readouterr().out
    assert "the policy is lost on this robot" in told
    assert "leave out --no-match" in told
    said = json.loads((folder / "package.json").read_text())
    assert said["policy"]["verdict"] == "lost"
    assert said["parts"][0]["measured_g"] == pytest.approx(8000.0)


def test_json_is_the_packages_own(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["weigh", str(folder), "rod=1000", "--seconds", "60", "--json", "--quiet"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((folder / "package.json").read_text())


@pytest.mark.parametrize(
    ("given", "what"),
    [
        (["rid=900"], "there is no part 'rid'"),
        (["rod=100"], "far from what was predicted"),
        (["rod=900", "--seconds", "-1"], "is no time"),
    ],
)
def test_what_makes_no_sense_changes_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str], given: list[str], what: str
) -> None:
    before = (folder / "package.json").read_bytes()
    assert main(["weigh", str(folder), *given, "--quiet"]) == 2
    assert what in capsys.readouterr().err
    assert (folder / "package.json").read_bytes() == before


def test_a_folder_without_a_package_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["weigh", str(tmp_path), "rod=1"]) == 2
    assert "there is no package" in capsys.readouterr().err
