"""The study of manifold alignment, and the bodies in a formula on which it rests."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest
from rich.console import Console

from experiments.aligning.cases import LEVELS, Case, cases_of, measured
from experiments.aligning.formula import PERIOD, SPREAD, CartPole, plain, worn
from experiments.aligning.report import drawn
from experiments.interval import interval, mean_interval
from experiments.manifolds import clear, figures, foretold, main, shown, worse
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.features import Features

TRUE = """
<mujoco>
  <option timestep="0.0002" integrator="RK4"/>
  <worldbody>
    <body>
      <joint type="slide" axis="1 0 0" damping="0.1"/>
      <inertial pos="0 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
      <body>
        <joint type="hinge" axis="0 1 0"/>
        <inertial pos="0 0 0.25" mass="0.5" diaginertia="0.0104166667 0.0104166667 1e-5"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="cart"/></actuator>
</mujoco>""".replace('<joint type="slide"', '<joint name="cart" type="slide"')


def test_the_formula_moves_as_the_same_body_in_mujoco() -> None:
    # The pole's inertia is m L^2 / 12 = 0.5 * 0.25 / 12 = 0.0104. Steps of 10 ms that move places
    # by the speed at their end are ahead by half a step times the change of speed, and no more than
    # a hundredth beside; speeds differ by how accelerations change in a step.
    model = mujoco.MjModel.from_xml_string(TRUE)
    data = mujoco.MjData(model)
    start, u = np.array([0.1, 0.2, -0.3, 0.4]), -4.0
    data.qpos[:], data.qvel[:], data.ctrl[:] = start[:2], start[2:], u
    mujoco.mj_step(model, data, nstep=round(PERIOD / model.opt.timestep))
    found = CartPole().step(start[None], np.array([[u]]))[0]
    truth = np.concatenate([data.qpos, data.qvel])
    moved = truth - start
    np.testing.assert_allclose(found[2:] - start[2:], moved[2:], rtol=0.01)
    ahead = 0.25 * PERIOD * moved[2:]
    np.testing.assert_allclose(found[:2] - start[:2] - ahead, moved[:2], rtol=0.01, atol=1e-5)


def test_its_own_feedback_balances_and_holding_still_does_not() -> None:
    body, rng = plain(CartPole(), 0.02), np.random.default_rng(100)
    gain = CartPole().gain() @ np.diag(SPREAD)
    seen = body.transitions(200, rng)
    same = Features(source_look=np.eye(4), target_look=np.eye(4))
    found = same.fit(MapData(source=seen, target=seen), rng)
    assert body.score(found, gain, np.random.default_rng(1)) > 0.9  # type: ignore[arg-type]
    # Told nothing, the target still follows a source that nobody steers: it falls.
    assert body.score(found, 0.0 * gain, np.random.default_rng(1)) < 0.5  # type: ignore[arg-type]


def test_what_is_worn_comes_off_by_the_true_law() -> None:
    rng = np.random.default_rng(101)
    body = worn(CartPole(), 2, 0.0, 0.0, rng)
    x, e = rng.standard_normal((5, 4)), rng.standard_normal((5, 2))
    np.testing.assert_allclose(body.seen(x, e, rng) @ body.law.T, x, atol=1e-9)


def test_cases_are_ordered_seed_by_seed_and_none_is_twice() -> None:
    cases = cases_of([100, 101], quick=False)
    assert [case.seed for case in cases] == sorted(case.seed for case in cases)
    assert len(set(cases)) == len(cases)
    assert {case.target for case in cases if case.source == "formula"} == set(LEVELS)


def line(gain: float, bent: float, level: float) -> list[tuple[Case, dict[str, object]]]:
    names = ("manifold", "uma", "sparse", "pca_affine", "transport")
    rows = []
    for seed in range(3):
        ways: dict[str, object] = {}
        for name in (*names, "pairs_only"):
            ways[name] = {"score": gain + 0.1, "agreement": 1.0}
            ways[f"{name}, shuffled"] = {"score": 0.1, "agreement": 0.0}
        ways["manifold_free"] = ways["features"] = {"score": 0.1, "agreement": 0.0}
        case = Case(seed=seed, source="formula", target="bend", level=level)
        rows.append((case, {"ways": ways, "measures": {"bent": bent}}))
    return rows


def test_a_measure_that_falls_where_the_gain_rises_is_said_to_foretell() -> None:
    both = [one for k in range(5) for one in line(0.1 * k, 1.0 - 0.1 * k, float(k))]
    lines = figures([case for case, _ in both], [row for _, row in both])
    assert [row["manifold"] for row in foretold(lines)] == [pytest.approx(-1.0)]
    assert lines[3]["ways"]["sparse"]["gain"] == pytest.approx([0.3, 0.3, 0.3])
    assert "manifold, shuffled" in drawn(lines)


def pair(scores: dict[str, list[float]]) -> list[tuple[Case, dict[str, object]]]:
    """Return two bodies of the shelf under three seeds, with scores of some ways."""
    rows = []
    for seed in range(3):
        ways: dict[str, object] = {}
        for name in ("manifold", "uma", "sparse", "pca_affine", "transport", "pairs_only"):
            ways[name] = {"score": scores.get(name, [0.8] * 3)[seed]}
            ways[f"{name}, shuffled"] = {"score": 0.1}
        ways["no source"], ways["oracle"] = {"score": 0.7}, {"score": 1.0}
        case = Case(seed=seed, source="cartpole", target="cart_two_links", level=10.0)
        rows.append((case, {"ways": ways, "measures": {}}))
    return rows


def test_what_ridge_does_as_well_is_above_its_shuffled_control_and_not_above_ridge(
    capsys: pytest.CaptureFixture[str],
) -> None:
    scores = {"sparse": [0.95, 0.96, 0.97], "uma": [0.6, 0.5, 0.7], "manifold": [0.7, 0.9, 0.8]}
    lines = figures(*zip(*pair(scores), strict=True))
    here = ["cartpole > cart_two_links (10)"]
    assert all(where == here for where in clear(lines).values())
    above, below = clear(lines, "more", 0.0), worse(lines)
    assert {name for name, where in above.items() if where} == {"sparse"}
    assert {name for name, where in below.items() if where} == {"uma"}
    shown(lines, Console(width=170))
    said = capsys.readouterr().out
    assert "0.96*" in said
    assert "0.60x" in said


@pytest.mark.parametrize("count", [1, 3, 10])
def test_its_intervals_are_those_of_every_study(count: int) -> None:
    # The same draws and the same figure, to rounding.
    x = np.random.default_rng(count).random(count)
    np.testing.assert_allclose(mean_interval(x, middle=True), interval(x), atol=1e-12)
    np.testing.assert_allclose(
        mean_interval(x), interval(x, of=lambda y: float(y.mean())), atol=1e-12
    )


def test_the_quick_study_ends_with_every_control_beside_each_claim(tmp_path: Path) -> None:
    file = tmp_path / "study.json"
    told = ["--quick", "--engine", "inline", "--out", str(tmp_path)]
    assert main([*told, "--json", str(file)]) == 0
    told = json.loads(file.read_text())
    shelf = next(each for each in told["figures"] if each["source"] != "formula")
    controls = {"hold still", "oracle", "no source", "features", "manifold, sign flipped"}
    assert controls <= set(shelf["ways"])
    assert shelf["ways"]["oracle"]["score"][0] > 0.9
    assert shelf["ways"]["hold still"]["score"][0] < 0.3
    for name in clear(told["figures"]):
        assert f"{name}, shuffled" in shelf["ways"]


def test_a_case_is_the_same_again() -> None:
    case = Case(seed=100, source="formula", target="pairs", level=2.0)
    assert measured(case) == measured(case)
