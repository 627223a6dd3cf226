"""What a policy really saw is stored beside it, and a stranger's numbers ask for little memory."""

from __future__ import annotations

import json
import tracemalloc
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import OutputError, PolicyError
from morph.policy.policy import Policy
from morph.policy.radial import MOST_UNITS
from morph.policy.replay import REPLAYED, apart
from morph.policy.store import load_policy, write_policy


@pytest.fixture
def policy(every: dict[str, Policy]) -> Policy:
    return every["radial"]


def test_what_was_really_seen_is_stored_from_its_beginning_to_its_end(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    times = 0.05 * np.arange(301)
    seen = np.random.default_rng(0).normal(size=(301, policy.size))
    folder = write_policy(policy, tmp_path / "policy", pendulum, observed=seen, times=times)
    stored = load_file(folder / "weights.safetensors")
    assert len(stored["replay.time"]) == REPLAYED
    assert stored["replay.time"][[0, -1]].tolist() == [0.0, 15.0]
    assert np.array_equal(stored["replay.observation"][-1], seen[-1])
    assert load_policy(folder, pendulum) == policy


def test_few_observations_are_stored_once_each(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    seen, times = np.zeros((3, policy.size)), np.array([0.0, 0.05, 0.1])
    folder = write_policy(policy, tmp_path / "policy", pendulum, observed=seen, times=times)
    stored = load_file(folder / "weights.safetensors")
    assert stored["replay.time"].tolist() == [0.0, 0.05, 0.1]


@pytest.mark.parametrize(
    ("seen", "times"),
    [
        (np.zeros((3, 2)), np.zeros(3)),
        (np.zeros((3, 6)), np.zeros(4)),
        (np.zeros((3, 6)), None),
        (np.zeros((0, 6)), np.zeros(0)),
        (np.full((3, 6), np.nan), np.zeros(3)),
        (np.zeros((3, 6)), np.array([0.0, np.inf, 1.0])),
    ],
)
def test_what_does_not_fit_the_policy_is_not_stored(
    policy: Policy, pendulum: Robot, tmp_path: Path, seen: Array, times: Array | None
) -> None:
    with pytest.raises(PolicyError, match="what was observed has the shape"):
        write_policy(policy, tmp_path / "policy", pendulum, observed=seen, times=times)
    assert not (tmp_path / "policy").exists()


def test_the_task_and_how_it_was_learned_are_passed_on(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    learned = {"search": "pilco", "trials": 3, "cost": 15.1}
    folder = write_policy(
        policy, tmp_path / "p", pendulum, task="swing-up", task_sha256="ab", learned=learned
    )
    said = json.loads((folder / "policy.json").read_text())
    assert said["task"] == {"name": "swing-up", "sha256": "ab"}
    assert said["learned"] == learned


@pytest.mark.parametrize("learned", [{"cost": float("nan")}, {"cost": np.zeros(2)}])
def test_what_json_cannot_say_is_refused_before_anything_is_written(
    policy: Policy, pendulum: Robot, tmp_path: Path, learned: dict[str, Any]
) -> None:
    with pytest.raises(PolicyError, match="how it was learned cannot be written"):
        write_policy(policy, tmp_path / "policy", pendulum, learned=learned)
    assert not (tmp_path / "policy").exists()


def test_an_export_that_cannot_be_replaced_is_told_of(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    folder = write_policy(policy, tmp_path / "policy", pendulum)
    (folder / "policy.onnx").mkdir()
    with pytest.raises(OutputError, match="cannot be replaced"):
        write_policy(policy, folder, pendulum)


def test_a_strangers_numbers_get_neither_much_memory_nor_much_time(
    policy: Policy,
    pendulum: Robot,
    tmp_path: Path,
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    # As many units as are allowed, at as many times: 10000 * 1000 numbers would be 80 MB, and
    # those of the formula as much again. The reader's own 64 MiB are there in any case; 100
    # times are replayed at once, which is 8 MB.
    path = write_policy(policy, tmp_path / "policy", pendulum) / "weights.safetensors"
    tensors = load_file(path)
    inputs = tensors["centre"].shape[1]
    tensors |= {
        "centre": np.zeros((MOST_UNITS, inputs)),
        "weight": np.zeros((2, MOST_UNITS)),
        "replay.time": np.zeros(1000),
        "replay.observation": np.zeros((1000, policy.size)),
        "replay.action": np.zeros((1000, 2)),
    }
    save_file(tensors, path)
    tracemalloc.start()
    with processor(10.0):
        loaded = load_policy(path.parent, pendulum)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert loaded.weights()["centre"].shape == (MOST_UNITS, inputs)
    assert most < 100e6


def test_small_actions_are_compared_in_their_unit_and_great_ones_by_their_share() -> None:
    assert apart(np.array([1e-3 + 1e-7]), np.array([1e-3])) == pytest.approx(1e-7)
    assert apart(np.array([1e3 + 1e-4]), np.array([1e3])) == pytest.approx(1e-7)
    assert apart(np.array([np.nan]), np.array([0.0])) != 0.0
    assert apart(np.empty((0, 2)), np.empty((0, 2))) == 0.0
