"""The study of six fluids runs small, and its worlds and figures are what it says."""

from __future__ import annotations

import json

import numpy as np
import pytest

from experiments.fluids import main
from experiments.waters.cases import NOISE, drawn
from experiments.waters.judge import calibration
from experiments.waters.worlds import WORLDS, Disturbance, halfway


def test_a_body_rises_in_water_heavier_than_it_is_trimmed_for_and_no_other_does() -> None:
    told = {}
    for world in WORLDS:
        run = world.simulator().run(seconds=1.0)
        told[world.name] = float(run["hull.linear_velocity.z"][-1])
    # 25 kg/m3 on 0.017 m3: 4.2 N, on 17 kg and 32 kg of water 0.085 m/s2; drag takes little yet.
    assert told["salt"] == pytest.approx(0.08, abs=0.02)
    assert told["brackish"] == pytest.approx(0.08 * 12.0 / 25.0, abs=0.01)
    for name in ("fresh", "salt, trimmed for it", "fresh, hull overgrown"):
        assert abs(told[name]) < 0.005


def test_a_world_halfway_rises_half_as_fast() -> None:
    fresh, salt = WORLDS[0], WORLDS[4]
    between = halfway(fresh, salt)
    assert between.density == pytest.approx(1012.5)
    assert between.hull_drag == 1.0


def test_cases_come_again_by_their_seeds_and_worlds_take_turns() -> None:
    one, same, next_one = drawn("clean", 104), drawn("clean", 104), drawn("clean", 105)
    assert np.array_equal(one.run.position, same.run.position)
    assert (one.truth, next_one.truth) == ((104 % 6,), (105 % 6,))
    assert one.unknown == Disturbance()
    assert one.run.position.shape == (101, 13)
    # Noise on the held paddles' readings stays near what it should be: chi-squared, 5 of 100.
    rough = np.diff(one.run.position[:, 2], n=3).std() / np.sqrt(20.0)
    assert rough == pytest.approx(NOISE, rel=0.35)


def test_a_calibration_error_is_the_gap_between_confidence_and_success() -> None:
    sure = np.array([0.95, 0.95, 0.95, 0.95, 0.55, 0.55])
    right = np.array([1, 1, 1, 0, 1, 0]) > 0
    # |3 - 3.8| + |1 - 1.1| of 6 answers.
    assert calibration(sure, right) == pytest.approx(0.9 / 6.0)


def test_the_study_runs_small_and_finds_salt_water(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--quick", "--only", "clean", "--seed", "106", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["schema"] == "morph.fluids/1"
    (clean,) = told["cases"]
    for probability in clean["probability"].values():
        assert np.sum(probability, axis=1) == pytest.approx(np.ones(4), abs=1e-3)
    # Salt water under a body that is trimmed for fresh water: 4 N that nothing else explains.
    assert clean["truth"] == ["salt"]
    assert clean["probability"]["eq. 13"][-1][4] > 0.95
