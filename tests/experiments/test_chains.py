"""The study of the chain of balance: it runs small, and counts as it says."""

from __future__ import annotations

import json

import numpy as np
import pytest

from experiments.balance_chained.summary import first, from_nothing
from experiments.chains import Shuffled, main
from morph.alignment.maps.affine_map import AffineMap
from morph.arrays import JSON
from morph.policy_transfer.balancers import balancer
from morph.policy_transfer.relay import same


@pytest.fixture(scope="module")
def figures(tmp_path_factory: pytest.TempPathFactory) -> JSON:
    out = tmp_path_factory.mktemp("chains") / "out.json"
    said = ["--quick", "--seeds", "101:102", "--engine", "inline", "--json", str(out)]
    said += ["--out", str(out.parent / "cells")]
    assert main(said) == 0
    found: JSON = json.loads(out.read_text(encoding="utf-8"))
    return found


def test_a_small_chain_ends_on_a_humanoid_on_a_free_board(figures: JSON) -> None:
    end = figures["ends"]["humanoid_free"]
    assert end["samples"] == 20 + 40
    assert figures["hops"]["humanoid_free"]["hold_still"] <= 0.3
    assert figures["hops"]["humanoid_free"]["oracle"] >= 0.95
    assert figures["hops"]["humanoid_free"]["kept"]["iqm"] > 0.9


def test_learning_that_never_arrives_is_said_to_be_unsolved(figures: JSON) -> None:
    # One generation of 16 runs that fall: no feedback from that stands.
    scratch = figures["ends"]["humanoid_free"]["scratch"]
    assert scratch["solved"] == 0.0
    assert scratch["spent"]["iqm"] >= 16


def test_a_curve_is_enough_from_where_it_stays_enough() -> None:
    assert first({"5": 0.97, "10": 0.4, "20": 0.96, "40": 0.99}, 1.0) == 20.0
    assert first({"5": 0.97, "10": 0.4}, 1.0) == np.inf


def test_the_best_size_of_moves_is_the_one_that_arrives_oftenest() -> None:
    soon, late = {"spent": 10.0, "solved": False}, {"spent": 90.0, "solved": True}
    ends = [{"samples": 9, "scratch": {"0.1": soon, "0.3": late}}]
    found = from_nothing(ends)
    assert found["size"] == "0.3"
    assert found["samples_over_scratch"] == pytest.approx(0.1)


def test_a_shuffled_map_tells_each_actuator_what_is_another_ones() -> None:
    right = same(balancer("rider_five_links_passive"))
    count = len(right.action_law)
    wrong = Shuffled(tuple(np.roll(np.arange(count), 1).tolist()))(right)
    assert isinstance(wrong, AffineMap)
    told = wrong.action(np.zeros((1, len(right.state_law))), np.arange(float(count))[None])
    assert told[0] == pytest.approx(np.roll(np.arange(count), 1))
