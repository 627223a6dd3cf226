"""Which policy is whose."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from morph.app.viewer.compare.match_policies import matched, task_of
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import PolicyError, ViewError
from morph.policy.pattern import Swing, pattern
from morph.policy.store import write_policy


@pytest.fixture(scope="module")
def pole() -> Robot:
    return load("pendulum")


@pytest.fixture(scope="module")
def cart() -> Robot:
    return load("cartpole")


@pytest.fixture
def kept(tmp_path: Path) -> Callable[..., str]:
    """Writes a policy of a robot that tells its one motor a constant, and returns its folder."""

    def write(robot: Robot, told: float, task: str = "balance") -> str:
        folder = tmp_path / f"{robot.name}-{told:g}"
        swings = {robot.actuators[0].name: Swing(offset=told)}
        return str(write_policy(pattern(robot, swings), folder, robot, task=task))

    return write


def test_a_policy_is_that_of_the_body_that_it_was_made_for(
    pole: Robot, cart: Robot, kept: Callable[..., str]
) -> None:
    found = matched((cart, pole), (kept(pole, 0.5), "learned"))
    assert found[0] is None
    assert found[1] is not None
    assert found[1].task == "balance"
    assert found[1].policy == pattern(pole, {pole.actuators[0].name: Swing(offset=0.5)})


def test_of_a_body_that_stands_there_twice_the_first_has_the_first(
    pole: Robot, cart: Robot, kept: Callable[..., str]
) -> None:
    one, other = kept(pole, 0.5), kept(pole, 0.25)
    found = matched((pole, cart, pole), (other, one))
    assert [None if each is None else each.folder for each in found] == [other, None, one]


def test_a_second_policy_of_a_body_is_refused(pole: Robot, kept: Callable[..., str]) -> None:
    one, other = kept(pole, 0.5), kept(pole, 0.25)
    with pytest.raises(ViewError, match=r"(?s)pendulum has a policy already.*pendulum once more"):
        matched((pole,), (one, other))


def test_a_policy_of_another_body_names_those_that_are_shown(
    pole: Robot, cart: Robot, kept: Callable[..., str]
) -> None:
    folder = kept(cart, 0.5)
    match = rf"(?s)--policy {re.escape(folder)}: .*none of the bodies shown, which are pendulum"
    with pytest.raises(ViewError, match=match):
        matched((pole, pole), (folder,))


def test_a_folder_without_a_policy_is_an_error_of_that_file(pole: Robot, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match=r"policy\.json"):
        matched((pole,), (str(tmp_path),))


def test_policies_tell_their_task(pole: Robot, cart: Robot, kept: Callable[..., str]) -> None:
    assert task_of(matched((pole,), ())) is None
    assert task_of(matched((pole, cart), (kept(pole, 0.5), kept(cart, 0.5)))) == "balance"
    both = matched((pole, cart), (kept(pole, 0.5), kept(cart, 0.1, task="swing-up")))
    with pytest.raises(ViewError, match=r"do not tell one task .*balance.*swing-up"):
        task_of(both)


@pytest.mark.parametrize("task", [None, 3, [], {"name": 4}, {"name": "<b>dance</b>"}])
def test_a_policy_that_tells_no_task_needs_one_told(
    pole: Robot, kept: Callable[..., str], task: object
) -> None:
    folder = kept(pole, 0.5)
    file = Path(folder) / "policy.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"task": task}))
    with pytest.raises(ViewError, match=r"say by --task"):
        task_of(matched((pole,), (folder,)))
