"""The study of hidden maps: its disguises, what it forgives, and one small case."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from experiments.disguised.disguise import disguise
from experiments.disguised.excited import wild
from experiments.disguised.judge import Truth, judged, symmetries
from experiments.disguises import Case, figures, in_words, main


def test_a_cart_pole_is_its_mirror_image_and_does_not_feel_where_it_stands() -> None:
    free = symmetries(wild("cartpole"), np.random.default_rng(100))
    signs = sorted((*state, *command) for state, command in free.signs)
    assert signs == [(-1.0,) * 5, (1.0,) * 5]
    assert free.shifts.tolist() == [True, False, False, False]


def test_what_is_bent_is_bared_and_what_is_doubled_shares_the_load() -> None:
    rng = np.random.default_rng(100)
    hidden = disguise(np.array([1.0, 2.0]), np.array([5.0]), rng, redundant=True, bent=True)
    x = rng.standard_normal((50, 2)) * 2.0
    y = hidden.states.worn(x)
    assert y.shape == (50, 4)
    z = hidden.states.bared(y)
    # Bisection halves 4 sixty times: rounding is what is left.
    np.testing.assert_allclose(z, (x / [1.0, 2.0]) @ hidden.states.mix.T, atol=1e-12)
    u = rng.uniform(-3.0, 3.0, size=(50, 1))
    np.testing.assert_allclose(hidden.command(hidden.commands.worn(u)), u, atol=1e-12)


def test_the_truth_or_its_mirror_image_is_right_and_half_of_it_is_not() -> None:
    body = wild("cartpole")
    rng = np.random.default_rng(101)
    hidden = disguise(np.ones(4), np.ones(1), rng, redundant=True, bent=True)
    x, u = body.starts(300, rng), body.commands(300, rng)
    truth = Truth(target=hidden.states.worn(x), told=hidden.commands.worn(u), state=x, command=u)
    free = symmetries(body, rng)
    for sign in (1.0, -1.0):
        row = judged((sign * x + [3.0, 0.0, 0.0, 0.0], sign * u), truth, hidden, free)
        assert row["whole"]
        assert float(row["least"]) > 1.0 - 1e-9
    # A command of the wrong sign: R2 is 1 - 4 var / var = -3, whichever image is taken.
    wrong = judged((x, -u), truth, hidden, free)
    assert not wrong["whole"]
    assert float(wrong["least"]) < -2.9


def test_a_small_study_finds_a_hidden_map_and_its_control_does_not(tmp_path: Path) -> None:
    told = ["--quick", "--engine", "inline", "--out", str(tmp_path)]
    assert main([*told, "--json", str(tmp_path / "found.json")]) == 0
    figures = json.loads((tmp_path / "found.json").read_text())["figures"]
    by_way = {line["way"]: line for line in figures}
    assert by_way["transition_kernel"]["right"] == 1.0
    assert by_way["any_order"]["right"] == 0.0


def test_the_headline_says_what_is_found_with_noise_before_what_is_found_without() -> None:
    cases, rows = [], []
    for noise, states, whole in ((0.0, 0.9999, True), (0.01, 0.98, False)):
        for kind in ("plain", "bent"):
            case = Case(seed=0, body="cartpole", kind=kind, noise=noise, way="transition_kernel")
            cases.append(case)
            fine = whole or kind == "plain"
            rows.append({"states": states if not fine else 0.9999, "commands": 0.9999,
                         "least": 0.98, "parts": 1.0, "whole": fine})  # fmt: skip
    noisy, exact = in_words(figures(cases, rows))
    assert noisy.startswith("noise 0.01:")
    assert "right 1 of 2, every single number too 0; signs and parts wrong in 1" in noisy
    assert exact.startswith("noise 0:")
    assert "right 2 of 2" in exact
