"""The policies of a package."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import onnx
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MakeError, PolicyError
from morph.fabrication.content import Package
from morph.fabrication.package import (
    DESIGNED,
    POLICY,
    ROBOT,
    write_content,
    write_parts,
    write_robots,
)
from morph.fabrication.package_folder import package_folder
from morph.fabrication.policies import matched_in, policies_in, task_of
from morph.fabrication.reading import read_package
from morph.fabrication.weigh import write_weighed
from morph.physics.worlds import world
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.store import load_policy, write_policy
from morph.search.evaluate import evaluate
from morph.search.lqr import Lqr
from morph.search.search import Problem
from morph.task.task import Task
from morph.task.tasks import task

SHORT = 60.0
"""Seconds that matching may take; it ends when a policy does, far before."""


@pytest.fixture(scope="module", autouse=True)
def few_runs() -> Iterator[None]:
    """Policies are judged by 20 runs, not by 100: what holds a pendulum holds it in every one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("morph.fabrication.match.case.MOST", 20)
        yield


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a policy that balances the pendulum."""
    robot = load("pendulum")
    asked = task("balance", robot)
    policy = Lqr().run(Problem(task=asked, simulator=asked.simulator()), seed=0).policy
    folder = tmp_path_factory.mktemp("learned")
    return write_policy(policy, folder, robot, task=asked.name, task_sha256=asked.sha256)


@pytest.fixture(scope="module")
def made_once(
    tmp_path_factory: pytest.TempPathFactory, package: Package, pendulum: Robot, learned: Path
) -> Path:
    folder = tmp_path_factory.mktemp("made") / "package"
    with package_folder(folder) as made:
        robot = write_robots(made, pendulum, package)
        _, said = matched_in(made, learned, pendulum, seconds=SHORT)
        files = write_parts(made, package.job, {"Title": package.title})
        whole = replace(package, made_sha256=robot.sha256, policy=said)
        write_content(made, whole, files)
    return folder


@pytest.fixture
def written(tmp_path: Path, made_once: Path) -> Path:
    """A copy, which a test may change."""
    return Path(shutil.copytree(made_once, tmp_path / "package", symlinks=True))


def test_the_policy_of_a_package_is_the_printed_robots_and_says_so(written: Path) -> None:
    printed, designed = load(written / ROBOT), load(written / DESIGNED)
    assert load_policy(written / POLICY, printed).action[0].actuator == "hinge"
    with pytest.raises(PolicyError, match="it was made for"):
        load_policy(written / POLICY, designed)
    said = read_package(written).policy
    assert said is not None
    # The rod weighs 0.12 kg instead of 1: what held it shakes it.
    assert (said.task, said.verdict) == ("balance", "matched")
    (was, asked), (now, there) = policies_in(written, designed, printed)
    assert was != now
    assert (asked.robot, there.robot) == (designed, printed)
    # The exported one tells the same of itself.
    model = onnx.load(written / POLICY / "policy.onnx")
    (entry,) = model.metadata_props
    told = json.loads(entry.value)
    assert told["robot"]["sha256"] == printed.sha256
    assert (told["task"]["name"], told["learned"]["verdict"]) == ("balance", "matched")
    assert told["learned"]["growth"]["kept"] <= 0.02


def test_a_policy_that_holds_keeps_holding_where_a_part_weighs_a_little_more(
    written: Path,
) -> None:
    package = read_package(written)
    with package_folder(written) as made:
        found = write_weighed(written, made, package, {"bar": 0.0102}, seconds=SHORT)
    assert found.matched is not None
    assert found.matched.by == "unchanged"
    assert found.package.policy is not None
    assert found.package.policy.verdict == "holds"
    # It is stored for the corrected robot, with which it can be used.
    assert load_policy(written / POLICY, load(written / ROBOT)) == found.matched.policy


def test_a_policy_is_matched_again_where_a_part_weighs_far_more(written: Path) -> None:
    package = read_package(written)
    with package_folder(written) as made:
        found = write_weighed(written, made, package, {"ball": 0.5}, seconds=SHORT)
    assert found.package.policy is not None
    assert found.package.policy.verdict in {"holds", "matched"}
    printed = load(written / ROBOT)
    (_, _), (now, there) = policies_in(written, load(written / DESIGNED), printed)
    # A policy that lost could not: its pendulum would lie.
    rng = np.random.default_rng(7)
    assert evaluate(there, now, there.simulator(), rng=rng, rows=20).share == 1.0


def test_a_robot_that_weighs_the_same_keeps_its_policy_to_the_byte(written: Path) -> None:
    before = (written / POLICY / "policy.json").read_bytes()
    with package_folder(written) as made:
        found = write_weighed(written, made, read_package(written), {}, seconds=SHORT)
    assert found.matched is None
    assert (written / POLICY / "policy.json").read_bytes() == before


def stored(folder: Path, asked: Task, sha256: str, name: str = "") -> Path:
    robot = asked.robot
    still = Linear(
        weight=np.zeros((1, 3)),
        bias=np.zeros(1),
        angles=np.array([1.0, 0.0]),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=asked.period,
    )
    return write_policy(still, folder, robot, task=name or asked.name, task_sha256=sha256)


def test_a_task_is_found_again_in_the_world_in_which_it_was_learned(
    tmp_path: Path, learned: Path
) -> None:
    robot = load("pendulum")
    assert task_of(learned, robot).sha256 == task("balance", robot).sha256
    usual = task("balance", robot)
    path = stored(tmp_path, usual, "0" * 64)
    with pytest.raises(MakeError, match="another balance than this robot's"):
        task_of(path, robot)
    floor = replace(usual, world="hard_floor", effects=world("hard_floor", robot).effects)
    stored(tmp_path, usual, floor.sha256)
    assert task_of(tmp_path, robot).world == "hard_floor"


def test_a_policy_for_no_task_is_refused(tmp_path: Path) -> None:
    usual = task("balance", load("pendulum"))
    path = stored(tmp_path, usual, "", name="dance")
    with pytest.raises(MakeError, match="which task it is for: 'dance'"):
        task_of(path, usual.robot)
