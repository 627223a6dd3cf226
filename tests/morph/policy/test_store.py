"""A policy on disk: what is written is read, and what was tampered with is not."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.pattern import Pattern, Swing, pattern
from morph.policy.store import load_policy, write_policy


@pytest.fixture(scope="module")
def swimmer() -> Robot:
    return load("hexapod_swimmer")


@pytest.fixture(scope="module")
def policy(swimmer: Robot) -> Pattern:
    names = [actuator.name for actuator in swimmer.actuators]
    rng = np.random.default_rng(0)
    numbers = rng.normal(size=(len(names), 5)).tolist()
    keys = ("offset", "amplitude", "frequency", "phase", "rate")
    swings = {
        name: Swing(**dict(zip(keys, row, strict=True)))
        for name, row in zip(names, numbers, strict=True)
    }
    return pattern(swimmer, swings, period=0.02)


@pytest.fixture
def folder(policy: Pattern, swimmer: Robot, tmp_path: Path) -> Path:
    return write_policy(policy, tmp_path / "policy", swimmer, task="swim")


def test_a_policy_survives_being_written_and_read(
    policy: Pattern, folder: Path, swimmer: Robot
) -> None:
    assert load_policy(folder, swimmer) == policy
    assert sorted(file.name for file in folder.iterdir()) == ["policy.json", "weights.safetensors"]


def test_the_same_policy_is_written_as_the_same_bytes(
    policy: Pattern, folder: Path, swimmer: Robot, tmp_path: Path
) -> None:
    again = write_policy(policy, tmp_path / "again", swimmer, task="swim")
    for file in folder.iterdir():
        assert file.read_bytes() == (again / file.name).read_bytes()


def test_it_says_what_the_specification_asks_for(folder: Path, swimmer: Robot) -> None:
    said = json.loads((folder / "policy.json").read_text())
    assert said["schema"] == "morph.policy/1"
    assert said["kind"] == "pattern"
    assert said["robot"] == {"name": "hexapod_swimmer", "sha256": swimmer.sha256}
    assert said["task"]["name"] == "swim"
    assert said["control_period_s"] == 0.02
    assert said["hold"] == "zero-order"
    assert [set(each) for each in said["action"]] == [{"actuator", "unit", "low", "high"}] * 6
    assert set(said["provenance"]) == {"morph", "mujoco"}


def test_another_body_does_not_get_it(folder: Path) -> None:
    # Same actuators in the same order; only its ballast differs.
    with pytest.raises(PolicyError, match="made for 'hexapod_swimmer'") as caught:
        load_policy(folder, load("hexapod_swimmer_ballast"))
    assert "the robot it was made for" in caught.value.fix


def test_it_is_not_written_for_another_body(policy: Pattern, tmp_path: Path) -> None:
    with pytest.raises(PolicyError, match="actuators of cartpole"):
        write_policy(policy, tmp_path / "policy", load("cartpole"))
    assert not (tmp_path / "policy").exists()


def test_a_strangers_folder_is_left_alone(policy: Pattern, swimmer: Robot, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(PolicyError, match="holds no earlier policy"):
        write_policy(policy, tmp_path, swimmer)
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.tex"]


def change(path: tuple[str | int, ...], value: Any) -> Callable[[dict[str, Any]], None]:
    def act(said: dict[str, Any]) -> None:
        inner: Any = said
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value

    return act


@pytest.mark.parametrize(
    ("act", "what"),
    [
        (change(("schema",), "morph.policy/2"), "its schema is 'morph.policy/2'"),
        (change(("kind",), "tabular"), "its kind is 'tabular'"),
        (change(("kind",), "radial"), "shapes"),
        (change(("kind",), None), "kind is None, not a text"),
        (change(("kind",), "x" * 1000), "not a text of at most 200"),
        (change(("hold",), "linear"), "hold is 'linear'"),
        (change(("robot",), []), r"robot is \[\], not an object"),
        (change(("robot", "sha256"), "0" * 64), "made for 'hexapod_swimmer'"),
        (change(("control_period_s",), "fast"), "control_period_s is 'fast'"),
        (change(("control_period_s",), True), "control_period_s is True"),
        (change(("control_period_s",), 1e99), "control period"),
        (change(("control_period_s",), 10**400), "not a finite number"),
        (change(("action",), {}), "action is {}, not a list"),
        (change(("action",), [None] * 6), "not a list of at most 1000 objects"),
        (change(("action",), [{}] * 1001), "not a list of at most 1000 objects"),
        (change(("action", 0, "actuator"), "right_rear"), "it commands 'right_rear"),
        (change(("action", 0, "unit"), "m"), r"left_front \(m\)"),
        (change(("action", 0, "high"), float("nan")), "high is nan"),
        (change(("action", 0, "high"), -1e9), "bounds"),
        (change(("action", 0, "high"), 0.01), "its actions differ"),
        (change(("observation",), [{"channel": "hull"}]), "unit is None"),
        (lambda said: said["action"].reverse(), "it commands"),
        (lambda said: said["action"].pop(), "shapes"),
    ],
)
def test_a_policy_that_says_something_else_is_refused(
    folder: Path, swimmer: Robot, act: Callable[[dict[str, Any]], None], what: str
) -> None:
    path = folder / "policy.json"
    said = json.loads(path.read_text())
    act(said)
    path.write_text(json.dumps(said))
    with pytest.raises(PolicyError, match=what):
        load_policy(folder, swimmer)


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "it is not JSON"),
        (b"[" * 100_000, "it is not JSON"),
        (b"[]", r"it holds \[\], not an object"),
        (b"\xff\xfe", "it is not JSON"),
        (b" " * (2**20 + 1), "1048577 bytes, and 1048576 are read at most"),
        (b'{"schema": ' + b"[" * 900 + b"]" * 900 + b"}", "its schema is"),
    ],
)
def test_what_is_no_policy_is_refused(
    folder: Path, swimmer: Robot, content: bytes, what: str
) -> None:
    (folder / "policy.json").write_bytes(content)
    with pytest.raises(PolicyError, match=what):
        load_policy(folder, swimmer)


@pytest.mark.parametrize("name", ["policy.json", "weights.safetensors"])
def test_a_policy_without_one_of_its_files_is_refused(
    folder: Path, swimmer: Robot, name: str
) -> None:
    (folder / name).unlink()
    with pytest.raises(PolicyError, match="no such file") as caught:
        load_policy(folder, swimmer)
    assert caught.value.where.endswith(name)


@pytest.mark.parametrize(
    ("name", "value", "what"),
    [
        ("offset", np.array([np.nan] * 6), "'offset' does not consist of finite"),
        ("offset", np.zeros(6, dtype=np.int64), "'offset' does not consist of finite"),
        ("offset", np.zeros(7), "shapes"),
        ("offset", np.full(6, 1e7), "offset = 1e\\+07"),
        ("offset", np.zeros(6), "its actions differ"),
        ("more", np.zeros(6), "shapes"),
        ("replay.time", np.zeros((2, 2)), "lacks observations and actions"),
        ("replay.time", np.zeros(0), "lacks observations and actions"),
        ("replay.observation", np.zeros((64, 1)), "lacks observations and actions"),
        ("replay.action", np.zeros((64, 5)), "lacks observations and actions"),
    ],
)
def test_numbers_that_were_changed_are_refused(
    folder: Path, swimmer: Robot, name: str, value: Any, what: str
) -> None:
    path = folder / "weights.safetensors"
    tensors = load_file(path)
    tensors[name] = value
    save_file(tensors, path)
    with pytest.raises(PolicyError, match=what):
        load_policy(folder, swimmer)


def test_a_refusal_does_not_repeat_a_file_to_its_reader(folder: Path, swimmer: Robot) -> None:
    path = folder / "weights.safetensors"
    tensors = load_file(path)
    save_file(tensors | {f"{index}" * 100: np.zeros(1) for index in range(100, 600)}, path)
    with pytest.raises(PolicyError, match="shapes") as caught:
        load_policy(folder, swimmer)
    assert len(str(caught.value)) < 1000


def test_more_actions_than_are_ever_written_are_not_replayed(
    policy: Pattern, folder: Path, swimmer: Robot
) -> None:
    path = folder / "weights.safetensors"
    time = np.linspace(0.0, 1.0, 10_001)
    nothing = np.empty((len(time), 0))
    replay = {"time": time, "observation": nothing, "action": policy.act(nothing, time)}
    tensors = load_file(path)
    save_file(tensors | {f"replay.{name}": value for name, value in replay.items()}, path)
    with pytest.raises(PolicyError, match="or holds too many"):
        load_policy(folder, swimmer)


def test_an_amplitude_that_is_wrong_by_a_millionth_shows(folder: Path, swimmer: Robot) -> None:
    # Amplitudes here are about 1: of 64 sines the greatest is above 0.9, and 3e-6 of it above
    # 2e-6, twice the tolerance; 1e-7 of it is a tenth of the tolerance.
    path = folder / "weights.safetensors"
    tensors = load_file(path)
    true = tensors["amplitude"].copy()
    assert abs(true).max() > 1.0
    tensors["amplitude"] = true + 1e-7
    save_file(tensors, path)
    load_policy(folder, swimmer)
    tensors["amplitude"] = true + 4e-6
    save_file(tensors, path)
    with pytest.raises(PolicyError, match="its actions differ"):
        load_policy(folder, swimmer)


@pytest.mark.parametrize("content", [b"", b"\x80\x04K\x01.", b"\xff" * 64, b"\x00" * 4096])
def test_weights_that_are_no_safetensors_are_refused(
    folder: Path, swimmer: Robot, content: bytes
) -> None:
    (folder / "weights.safetensors").write_bytes(content)
    with pytest.raises(PolicyError, match="it is no safetensors file"):
        load_policy(folder, swimmer)


def test_weights_with_a_byte_flipped_are_refused_or_the_same(
    policy: Pattern, folder: Path, swimmer: Robot
) -> None:
    path = folder / "weights.safetensors"
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    refused = 0
    for at in rng.integers(0, len(whole), 200):
        spoilt = bytearray(whole)
        spoilt[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(spoilt))
        try:
            read = load_policy(folder, swimmer)
        except PolicyError:
            refused += 1
        else:
            # What passes differs by less than the replay can tell.
            time = np.linspace(0.0, 9.0, 50)
            nothing = np.empty((50, 0))
            apart = np.abs(read.act(nothing, time) - policy.act(nothing, time))
            assert apart.max() < 1e-5
    assert refused > 100
