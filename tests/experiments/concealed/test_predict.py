"""Predictions of held-out runs against those of the generator, which shares no code with them."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.concealed.baselines import (
    refit_own_figures,
    solve_by_inverse_dynamics,
    solve_by_lasso,
    solve_by_sindy,
)
from experiments.concealed.generate import generate
from experiments.concealed.predict import predicted
from experiments.concealed.score import score
from experiments.concealed.seal import open_seal
from experiments.concealed.submission import check, submission
from morph.body.load import load


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A double pendulum with a payload that its description leaves out."""
    folder = tmp_path_factory.mktemp("concealed")
    return generate("development", 1, [1], folder)[0]


def test_a_description_predicts_what_the_generator_says_of_it(case: Path) -> None:
    readings = predicted(case, load(case / "robot.xml"))
    answer = submission(case.name, "nominal", none=1.0, predicted=readings)
    row = score(answer, open_seal(case))
    # E is 0 for the generator's own prediction by this description. Errors are of second order in
    # a step of 0.5 ms: (5e-4 * 20)^2 / 8 of a motion at 20 rad/s.
    assert row["E"] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("solve", [refit_own_figures, solve_by_lasso, solve_by_sindy])
def test_baselines_answer_and_predict(case: Path, solve: object) -> None:
    answer = check(solve(case, 1), where=case.name)  # type: ignore[operator]
    row = score(answer, open_seal(case))
    # Here each gains over the description; none of them finds the payload.
    assert 0.0 < row["E"] < 0.9
    assert not row["exact"]


def test_inverse_dynamics_that_is_told_the_load_finds_it(case: Path) -> None:
    answer = check(solve_by_inverse_dynamics(case, 1), where=case.name)
    truth = open_seal(case)
    assert score(answer, truth)["exact"]
    (finding,), (effect,) = answer["findings"], truth.about["effects"]
    # Masses of 0.81 and 0.46 kg may be wrong by 5 %, and a load is told from them no better.
    links = load(case / "robot.xml").links
    hidden = 0.05 * sum(link.mass for link in links)
    assert finding["parameters"]["m"]["value"] == pytest.approx(effect["figures"]["m"], abs=hidden)
