"""Linear, radial, network and track do what their formulas say, written out one by one."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import PolicyError
from morph.policy.linear import Linear
from morph.policy.network import MOST_LAYERS, WIDEST, Network
from morph.policy.observing import observations_of
from morph.policy.policy import Action, actions_of
from morph.policy.radial import MOST_UNITS, Radial
from morph.policy.track import Track

CART = load("cartpole")
WIDE = (Action(actuator="slide", unit="N", low=-1e5, high=1e5),)
SEEN: dict[str, Any] = {"action": WIDE, "observation": observations_of(CART), "period": 0.1}
POLE = (0.0, 1.0, 0.0, 0.0)


def test_a_law_about_a_state_commands_nothing_there_and_minus_k_beside_it() -> None:
    K, there = np.array([[1.0, -30.0, 2.0, -6.0]]), np.array([0.5, math.pi, 0.0, 0.0])
    law = Linear(weight=-K, bias=K @ there, **SEEN)
    beside = there + np.array([0.0, 0.1, 0.0, 0.0])
    told = law.act(np.stack([there, beside]), np.zeros(2))
    assert told == pytest.approx(np.array([[0.0], [3.0]]), abs=1e-12)


def test_basis_functions_are_what_the_formula_says() -> None:
    rng = np.random.default_rng(0)
    centre, width, weight = (
        rng.normal(size=(7, 5)),
        rng.uniform(0.5, 2.0, 5),
        rng.normal(size=(1, 7)),
    )
    law = Radial(centre=centre, width=width, weight=weight, angles=POLE, **SEEN)
    for x, theta, v, omega in rng.normal(size=(20, 4)):
        f = np.array([x, v, omega, math.sin(theta), math.cos(theta)])
        near = [math.exp(-0.5 * sum(((f - c) / width) ** 2)) for c in centre]
        told = law.act(np.array([x, theta, v, omega]), np.array(0.0))
        assert told == pytest.approx(weight[0] @ near, abs=1e-12)


def test_basis_functions_far_from_zero_lose_no_digits() -> None:
    # Squares of 1e6 taken apart would leave errors of 1e12 * 1e-16 = 1e-4 in the exponent.
    far = np.array([1e6, 0.0, 0.0, 0.0])
    law = Radial(centre=far[None] + 0.5, width=np.ones(4), weight=np.ones((1, 1)), **SEEN)
    assert law.act(far, np.array(0.0)) == pytest.approx(math.exp(-0.5), abs=1e-9)


def test_a_network_is_what_its_layers_say() -> None:
    rng = np.random.default_rng(1)
    sizes = ((3, 5), (4, 3), (1, 4))
    layers = tuple((rng.normal(size=size), rng.normal(size=size[0])) for size in sizes)
    law = Network(layers=layers, angles=POLE, **SEEN)
    x, theta, v, omega = 0.3, 2.0, -1.0, 0.7
    h = [x, v, omega, math.sin(theta), math.cos(theta)]
    for at, (W, b) in enumerate(layers):
        h = [sum(w * one for w, one in zip(row, h, strict=True)) for row in W] + b
        h = [math.tanh(one) for one in h] if at < 2 else h
    assert law.act(np.array([x, theta, v, omega]), np.array(0.0)) == pytest.approx(h, abs=1e-12)


def tracked(knots: int = 4) -> Track:
    k = np.arange(knots, dtype=float)
    nominal = np.outer(k, [1.0, 0.0, 0.0, 0.0]) + np.array([0.0, math.pi, 0.0, 0.0])
    gain = -np.outer(k + 1.0, [1.0, 10.0, 0.0, 0.0])[:, None, :]
    return Track(nominal=nominal, command=100.0 * k[:, None], gain=gain, angles=POLE, **SEEN)


def test_a_trajectory_is_followed_knot_by_knot_and_held_at_its_end() -> None:
    law = tracked()
    # 3 * 0.1 is a rounding error above 0.3, and 0.3 - 1e-9 one below: both are knot 3.
    times = np.array([0.0, 0.0999, 0.1, 0.25, 0.3 - 1e-9, 3 * 0.1, 0.4, 1e6])
    told = [
        law.act(law.nominal[k], np.array(t)) for t, k in zip(times, law.knot(times), strict=True)
    ]
    assert law.knot(times).tolist() == [0, 0, 1, 2, 3, 3, 3, 3]
    assert np.ravel(told).tolist() == [0.0, 0.0, 100.0, 200.0, 300.0, 300.0, 300.0, 300.0]


def test_feedback_takes_the_short_way_round() -> None:
    law = tracked()
    # The pole should be at pi; -3 is 0.1416 beyond it, and 9 turns make no difference.
    beyond = math.tau - 3.0 - math.pi
    for turns in (0, 9):
        seen = np.array([2.0, -3.0 + turns * math.tau, 0.0, 0.0])
        told = law.act(seen, np.array(0.2))
        assert told == pytest.approx(200.0 - 3.0 * 10.0 * beyond, abs=1e-10)


def test_at_its_end_it_is_the_law_of_its_last_knot() -> None:
    law = tracked()
    rng = np.random.default_rng(2)
    last = Linear(
        weight=law.gain[-1], bias=law.command[-1] - law.gain[-1] @ law.nominal[-1], **SEEN
    )
    seen = law.nominal[-1] + rng.uniform(-1.0, 1.0, size=(50, 4))
    time = np.linspace(0.3, 9.0, 50)
    assert law.act(seen, time) == pytest.approx(last.act(seen, time), abs=1e-11)


def test_before_its_beginning_it_does_as_at_its_beginning() -> None:
    assert tracked().knot(np.array([-5.0, -0.01])).tolist() == [0, 0]


def made(kind: str, **wrong: Any) -> None:
    """Make a policy of a kind, some of it wrong."""
    right: dict[str, dict[str, Any]] = {
        "linear": {"weight": np.zeros((1, 4)), "bias": np.zeros(1)},
        "radial": {
            "centre": np.zeros((3, 4)),
            "width": np.ones(4),
            "weight": np.zeros((1, 3)),
        },
        "network": {"layers": ((np.zeros((1, 4)), np.zeros(1)),)},
        "track": {
            "nominal": np.zeros((2, 4)),
            "command": np.zeros((2, 1)),
            "gain": np.zeros((2, 1, 4)),
        },
    }
    kinds: dict[str, Any] = {
        "linear": Linear,
        "radial": Radial,
        "network": Network,
        "track": Track,
    }
    kinds[kind](**{**SEEN, **right[kind], **wrong})


@pytest.mark.parametrize(
    ("kind", "wrong", "what"),
    [
        ("linear", {"weight": np.zeros((1, 5))}, r"weight has the shape \(1, 5\)"),
        ("linear", {"weight": [["a"] * 4]}, "weight is no array of numbers"),
        ("linear", {"weight": np.full((1, 4), np.nan)}, "weight holds what is no number"),
        ("linear", {"bias": np.zeros(2)}, r"bias has the shape \(2,\)"),
        ("linear", {"observation": ()}, "it observes nothing"),
        ("linear", {"bound": "none"}, "its bound is 'none'"),
        ("radial", {"width": np.array([1.0, 1.0, 0.0, 1.0])}, "width of 0 is too small"),
        ("radial", {"width": -np.ones(4)}, "width of -1 is too small"),
        ("radial", {"centre": np.zeros((0, 4))}, r"centre has the shape \(0, 4\)"),
        (
            "radial",
            {
                "centre": np.zeros((MOST_UNITS + 1, 4)),
                "weight": np.zeros((1, MOST_UNITS + 1)),
            },
            "10001 basis functions",
        ),
        ("network", {"layers": ()}, "it has 0 layers"),
        ("network", {"layers": ((1.0, 1.0),) * (MOST_LAYERS + 1)}, "it has 17 layers"),
        ("network", {"layers": ((np.zeros((2, 4)), np.zeros(2)),)}, "layer.0.weight has"),
        (
            "network",
            {
                "layers": (
                    (np.zeros((WIDEST + 1, 4)), np.zeros(WIDEST + 1)),
                    (np.zeros((1, WIDEST + 1)), np.zeros(1)),
                )
            },
            "10001 outputs",
        ),
        ("track", {"nominal": np.zeros((0, 4))}, r"nominal has the shape \(0, 4\)"),
        ("track", {"command": np.zeros((3, 1))}, r"command has the shape \(3, 1\)"),
        ("track", {"gain": np.zeros((2, 4, 1))}, r"gain has the shape \(2, 4, 1\)"),
        ("track", {"nominal": np.zeros((100_001, 4))}, "at 100001 knots"),
        ("track", {"observation": (), "nominal": np.zeros((2, 0))}, "nominal has the shape|0 num"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(kind: str, wrong: dict[str, Any], what: str) -> None:
    with pytest.raises(PolicyError, match=what):
        made(kind, **wrong)


def test_more_is_not_seen_than_can_be_held() -> None:
    many = tuple(replace(SEEN["observation"][0], history=100) for _ in range(101))
    with pytest.raises(PolicyError, match="sees 10100 numbers at once"):
        Linear(weight=np.zeros((1, 1)), bias=np.zeros(1), action=actions_of(CART), observation=many)
