"""What every kind of policy must honour."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
from safetensors.numpy import load_file, save_file

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.export import LAWS, METADATA, export_onnx, export_policy, onnx_of
from morph.policy.kinds import KINDS
from morph.policy.policy import Action, Observation, Policy
from morph.policy.store import load_policy, write_policy

NAMES = (
    "linear, clip",
    "linear, sine",
    "linear, tanh",
    "linear, no angles",
    "radial",
    "network",
    "track",
    "pattern",
    "adjusted track",
    "adjusted pattern",
)


@pytest.fixture(params=NAMES)
def policy(request: pytest.FixtureRequest, every: dict[str, Policy]) -> Policy:
    return every[request.param]


def met(policy: Policy, rows: int = 200) -> tuple[Array, Array]:
    """Return observations and times that nothing here has seen before."""
    rng = np.random.default_rng(7)
    time = rng.uniform(0.0, 3.0, rows)
    return 3.0 * policy.typical(time, rng), time


def test_every_kind_is_tried_here_and_has_a_law_in_onnx(every: dict[str, Policy]) -> None:
    assert set(every) == set(NAMES)
    assert {type(policy) for policy in every.values()} == set(KINDS) == set(LAWS)
    assert len({kind.kind for kind in KINDS}) == len(KINDS)


def test_it_survives_being_written_and_read(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    folder = write_policy(policy, tmp_path / "policy", pendulum)
    again = load_policy(folder, pendulum)
    seen, time = met(policy)
    assert again == policy
    assert np.array_equal(again.act(seen, time), policy.act(seen, time))


def test_what_is_stored_to_be_replayed_is_not_all_at_a_bound(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    # Else a policy with other numbers would pass.
    folder = write_policy(policy, tmp_path / "policy", pendulum)
    action = load_file(folder / "weights.safetensors")["replay.action"]
    assert (np.abs(action) < 9.999).mean() > 0.3


@pytest.mark.parametrize("size", [1.0, 1e3, 1e9, 1e300])
def test_commands_stay_within_bounds_whatever_is_seen(policy: Policy, size: float) -> None:
    seen, time = met(policy)
    told = policy.act(size * seen / np.abs(seen).max(initial=1.0), 1e3 * time)
    assert told.shape == (200, 2)
    assert np.isfinite(told).all()
    assert (np.abs(told) <= 10.0).all()


def test_many_at_once_are_told_what_each_alone_is_told(policy: Policy) -> None:
    seen, time = met(policy, rows=24)
    told = policy.act(seen, time)
    alone = [policy.act(one, np.array(t)) for one, t in zip(seen, time, strict=True)]
    shaped = policy.act(seen.reshape(2, 3, 4, -1), time.reshape(2, 3, 4))
    # Sums of at most 20 products, in another order: 20 * 1e-16 of numbers of order 1e2.
    assert np.stack(alone) == pytest.approx(told, abs=1e-11)
    assert shaped.reshape(24, -1) == pytest.approx(told, abs=1e-11)


def test_one_clock_for_all_and_clocks_apart_are_the_same_law(policy: Policy) -> None:
    seen, _ = met(policy, rows=6)
    together = policy.act(seen, np.full(6, 0.4))
    apart = policy.act(np.concatenate([seen, seen]), np.repeat([0.4, 1.1], 6))
    assert apart[:6] == pytest.approx(together, abs=1e-11)


def test_it_does_not_change_what_it_is_given(policy: Policy) -> None:
    seen, time = met(policy)
    before = seen.copy()
    policy.act(seen, time)
    assert np.array_equal(seen, before)


def test_an_angle_may_have_gone_round_before(policy: Policy) -> None:
    if not policy.weights().get("angles", np.zeros(1)).any():
        return  # It sees no angle.
    seen, time = met(policy)
    turned = seen.copy()
    turned[:, 0] += 2.0 * np.pi
    turned[:, 1] -= 4.0 * np.pi
    # Sines of numbers that are a rounding error of 10 apart, 2e-15, times gains of order 1e2.
    assert policy.act(turned, time) == pytest.approx(policy.act(seen, time), abs=1e-10)


def test_its_numbers_cannot_be_changed(policy: Policy) -> None:
    if policy.kind == "pattern":
        return  # Its numbers are no arrays.
    for name, value in policy.weights().items():
        if value.ndim and not name.startswith("pattern."):
            with pytest.raises(ValueError, match="read-only"):
                value[...] = 0.0


def test_it_is_equal_to_itself_and_to_nothing_else(
    policy: Policy, every: dict[str, Policy]
) -> None:
    assert [other == policy for other in every.values()].count(True) == 1
    assert policy != "a policy"


def test_exported_it_does_the_same_in_another_evaluator(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    path = export_onnx(policy, tmp_path / "policy.onnx", pendulum)
    session = onnxruntime.InferenceSession(path)
    seen, time = met(policy)
    (told,) = session.run(None, {"observation": seen, "time": time})
    assert told.dtype == np.float64
    # Both work in float64.
    assert told == pytest.approx(policy.act(seen, time), abs=1e-9)
    far = np.full_like(seen, 1e300)
    (told,) = session.run(None, {"observation": far, "time": time})
    assert told == pytest.approx(policy.act(far, time), abs=1e-6)


def test_a_folder_is_exported_with_the_metadata_that_it_holds(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    folder = write_policy(policy, tmp_path / "policy", pendulum, task="balance")
    path = export_policy(folder, pendulum)
    assert path == folder / "policy.onnx"
    (held,) = [each for each in onnx.load(path).metadata_props if each.key == METADATA]
    assert json.loads(held.value) == json.loads((folder / "policy.json").read_text())
    assert load_policy(folder, pendulum) == policy
    # A new policy in the same folder does not keep the old one's export.
    write_policy(policy, folder, pendulum)
    assert not path.exists()


def test_the_same_policy_is_exported_as_the_same_bytes(policy: Policy) -> None:
    first, second = (onnx_of(policy).SerializeToString(deterministic=True) for _ in range(2))
    assert first == second


def wrong(name: str, value: Array) -> list[tuple[str, Any]]:
    """Return numbers that a tensor may not hold, each with what is said of it."""
    longer = np.zeros((*value.shape[:-1], value.shape[-1] + 1)) if value.ndim else np.zeros(1)
    return [
        ("does not consist of finite", np.full_like(value, np.nan)),
        ("finite floating", np.zeros(value.shape, dtype=np.int64)),
        ("shape", longer),
        ("shape", np.zeros((*value.shape, 1))),
        ("no number from|numbers other than", np.full_like(value, 1e10)),
    ]


def test_numbers_that_are_wrong_in_any_way_are_refused(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    path = write_policy(policy, tmp_path / "policy", pendulum) / "weights.safetensors"
    tensors = load_file(path)
    for name in policy.weights():
        for what, value in wrong(name, tensors[name]):
            save_file(tensors | {name: value}, path)
            with pytest.raises(PolicyError, match=what):
                load_policy(path.parent, pendulum)
        save_file({key: value for key, value in tensors.items() if key != name}, path)
        with pytest.raises(PolicyError, match="shapes"):
            load_policy(path.parent, pendulum)
    save_file(tensors | {"more": np.zeros(1)}, path)
    with pytest.raises(PolicyError, match="shapes"):
        load_policy(path.parent, pendulum)


def test_numbers_that_were_changed_a_little_are_found_out(
    policy: Policy, pendulum: Robot, tmp_path: Path
) -> None:
    path = write_policy(policy, tmp_path / "policy", pendulum) / "weights.safetensors"
    tensors = load_file(path)
    for name, value in policy.weights().items():
        if name.rpartition(".")[2] not in {"angles", "bound"} and value.size:
            save_file(tensors | {name: value * 1.01 + 1e-3}, path)
            with pytest.raises(PolicyError, match="its actions differ"):
                load_policy(path.parent, pendulum)


@pytest.mark.parametrize(
    ("key", "value", "what"),
    [
        ("channel", "elbow.acceleration", "'elbow.acceleration', which the state"),
        ("channel", "knee.position", "nearest channels are"),
        ("unit", "deg", "which is in rad|in deg with a scale of 1 is no angle"),
        ("scale", 0.0, "scale = 0"),
        ("offset", 1e12, "offset = 1e\\+12"),
        ("history", 0, "history = 0"),
        ("history", 1.5, "history is 1.5, not a whole number"),
        ("history", 10**9, "history = 1e\\+09"),
        ("history", 2, "shape"),
        ("delay_s", -0.1, "delay_s = -0.1"),
        ("delay_s", 1e9, "delay_s = 1e\\+09"),
    ],
)
def test_an_observation_that_is_none_is_refused(
    policy: Policy, pendulum: Robot, tmp_path: Path, key: str, value: object, what: str
) -> None:
    if not policy.observation:
        return  # It observes nothing.
    path = write_policy(policy, tmp_path / "policy", pendulum) / "policy.json"
    said = json.loads(path.read_text())
    said["observation"][0][key] = value
    path.write_text(json.dumps(said))
    with pytest.raises(PolicyError, match=what):
        load_policy(path.parent, pendulum)


def test_a_kind_without_a_law_in_onnx_is_not_exported(every: dict[str, Policy]) -> None:
    class Still(Policy):
        kind = "still"

        def act(self, observation: Array, time: Array) -> Array:
            return np.zeros((*np.shape(time), len(self.action)))

        def weights(self) -> dict[str, Array]:
            return {}

        @classmethod
        def of(
            cls,
            weights: Any,
            *,
            action: tuple[Action, ...],
            period: float,
            observation: tuple[Observation, ...],
        ) -> Policy:
            return cls(action=action, period=period, observation=observation)

    with pytest.raises(PolicyError, match="kind still cannot be exported"):
        onnx_of(Still(action=every["pattern"].action))
