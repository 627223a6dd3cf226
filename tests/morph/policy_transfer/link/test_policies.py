from __future__ import annotations

import base64
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.policy.policy import Action
from morph.policy.policy_json import hash_of
from morph.policy_transfer.link.offer import offer_of
from morph.policy_transfer.link.policies import Policies


def biases(policies: Policies) -> float:
    """Return what tells the policy in use from the others."""
    return float(policies.policy.weights()["bias"][0])


def test_a_policy_replaces_the_one_in_use_only_between_trials(
    cartpole: Robot, linear: Any, tmp_path: Path
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    policies.offer(offer_of(linear(1.0), cartpole, version=1))
    policies.offer(offer_of(linear(2.0), cartpole, version=2))
    assert (policies.version, biases(policies)) == (0, 0.0)
    assert policies.between_trials() == linear(2.0)
    assert policies.version == 2


def test_what_waits_and_what_is_in_use_outlive_the_program(
    cartpole: Robot, linear: Any, tmp_path: Path
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    policies.offer(offer_of(linear(1.0), cartpole, version=1))
    policies = Policies(tmp_path, cartpole, linear(0.0))
    assert biases(policies) == 0.0
    policies.between_trials()
    assert biases(Policies(tmp_path, cartpole, linear(0.0))) == 1.0


def test_an_older_policy_comes_too_late(cartpole: Robot, linear: Any, tmp_path: Path) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    newer = offer_of(linear(3.0), cartpole, version=3)
    policies.offer(newer)
    # The same once more is no error; it is what a kill between two writes leaves.
    policies.offer(newer)
    for version in (2, 3):
        with pytest.raises(TransferError, match=rf"its version is {version}, and 3 was offered"):
            policies.offer(offer_of(linear(9.0), cartpole, version=version))
    assert policies.between_trials() == linear(3.0)


def spoilt(offer: dict[str, Any], name: str = "weights.safetensors") -> dict[str, Any]:
    data = bytearray(base64.b64decode(offer["files"][name]))
    data[-1] ^= 1
    return {**offer, "files": {**offer["files"], name: base64.b64encode(data).decode()}}


def test_an_offer_that_is_not_sound_is_refused_and_the_policy_in_use_stays(
    cartpole: Robot, linear: Any, tmp_path: Path
) -> None:
    policies = Policies(
        tmp_path,
        cartpole,
        linear(0.0),
        verify=lambda policy: "it falls in simulation" if policy.weights()["bias"][0] > 8 else None,
    )
    sound = offer_of(linear(1.0), cartpole, version=1)
    wide = linear(1.0, action=(Action(actuator="slide", unit="N", low=-50.0, high=50.0),))
    other = load("double_pendulum")
    offers: dict[str, dict[str, Any]] = {
        r"its files do not have its hash": spoilt(sound),
        r"it is for another body": {**sound, "robot_sha256": hash_of(other)},
        r"its version is no number from 1": {**sound, "version": None},
        r"its version is no number": {**sound, "version": True},
        r"its version is no": {**sound, "version": 10**5000},
        r"it has no weights.safetensors": {**sound, "files": []},
        r"its weights.safetensors is no base64": {
            **sound,
            "files": {"weights.safetensors": "%"},
        },
        r"slide from -50 to 50 N, and the body takes -10 to 10": offer_of(
            wide, cartpole, version=1
        ),
        r"its period is 0.01 s, not 0.05 s": offer_of(
            linear(1.0, period=0.01), cartpole, version=1
        ),
        r"it falls in simulation": offer_of(linear(9.0), cartpole, version=1),
    }
    for says, offer in offers.items():
        with pytest.raises(TransferError, match=says):
            policies.offer(offer)
        assert policies.between_trials() == linear(0.0)
    # A body that says it is this one, and is another in its files.
    lying = offer_of(linear(1.0), replace(cartpole, sha256="0" * 64), version=1)
    with pytest.raises(TransferError, match=r"it was made for 'cartpole', whose description"):
        policies.offer({**lying, "robot_sha256": hash_of(cartpole)})
    policies.offer(sound)
    assert policies.between_trials() == linear(1.0)


def test_a_policy_that_is_withdrawn_gives_way_to_the_one_before(
    cartpole: Robot, linear: Any, tmp_path: Path
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    for version in (1, 2):
        policies.offer(offer_of(linear(float(version)), cartpole, version=version))
        policies.between_trials()
    assert (policies.withdraw(), biases(policies)) == (1, 1.0)
    # It is not taken again, and the one before it is in use after a new start too.
    with pytest.raises(TransferError, match=r"its version is 2, and 2 was offered already"):
        policies.offer(offer_of(linear(5.0), cartpole, version=2))
    assert biases(Policies(tmp_path, cartpole, linear(0.0))) == 1.0
    assert (policies.withdraw(), policies.withdraw(), biases(policies)) == (0, 0, 0.0)


@pytest.mark.parametrize("file", ["1/weights.safetensors", "1/policy.json"])
def test_a_policy_that_is_spoilt_on_the_disk_is_left_for_the_one_before(
    cartpole: Robot, linear: Any, tmp_path: Path, file: str
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    policies.offer(offer_of(linear(1.0), cartpole, version=1))
    policies.between_trials()
    content = (tmp_path / file).read_bytes()
    (tmp_path / file).write_bytes(content[: len(content) // 2])
    again = Policies(tmp_path, cartpole, linear(0.0))
    assert (again.version, biases(again)) == (0, 0.0)
    assert again.notes[0].startswith("version 1 is left: ")


def test_a_policy_that_is_spoilt_while_it_waits_is_not_taken(
    cartpole: Robot, linear: Any, tmp_path: Path
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    policies.offer(offer_of(linear(1.0), cartpole, version=1))
    (tmp_path / "1" / "policy.json").write_text("{}")
    assert policies.between_trials() == linear(0.0)
    assert policies.notes[0].startswith("version 1 is not taken into use: ")


@pytest.mark.parametrize("content", ["", "{", '{"schema": "morph.policies/1"}'])
def test_a_state_that_is_spoilt_leaves_the_first_policy(
    cartpole: Robot, linear: Any, tmp_path: Path, content: str
) -> None:
    policies = Policies(tmp_path, cartpole, linear(0.0))
    policies.offer(offer_of(linear(1.0), cartpole, version=1))
    policies.between_trials()
    (tmp_path / "policies.json").write_text(content)
    assert biases(Policies(tmp_path, cartpole, linear(0.0))) == 0.0
