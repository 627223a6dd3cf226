from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.cube import (
    FITTED,
    PUBLISHED,
    RIVAL,
    SETS,
    Floor,
    controls,
    fitted,
    main,
    report,
    studied,
)
from experiments.cube_tosses import (
    DESCRIPTION,
    FOLDER,
    HALF,
    RATE,
    flights,
    on,
    position_errors,
    rotation_errors,
    tosses,
)
from experiments.data import DataError
from experiments.openloop import from_mjcf
from morph.physics.world.ground import Ground


@pytest.fixture(scope="module")
def root(recordings: Path) -> Path:
    if not (recordings / FOLDER / "tosses.npz").is_file():
        pytest.skip(f"there is no {FOLDER} in {recordings}")
    return recordings


def test_until_it_lands_a_simulated_toss_flies_as_the_real_one(root: Path) -> None:
    real = tosses(root, range(300, 310))
    robot = from_mjcf(DESCRIPTION)
    for flight, toss in zip(flights([on(robot, (Ground(),))], real), real, strict=True):
        # A corner reaches at most sqrt(3) half widths down.
        low = toss[:, 2] < np.sqrt(3.0) * HALF
        airborne = int(np.argmax(low))
        strayed = np.linalg.norm(flight[0, :airborne, :3] - toss[:airborne, :3], axis=1)
        # The recorded speed along z is the mean over the sample before: half a sample of
        # gravity, 9.81 / 296 = 0.033 m/s, too little; and lengths measured 2 % small are 2 %
        # of the way. Both grow with the time, and the first sample is exact.
        times = np.arange(airborne) / RATE
        way = np.linalg.norm(toss[:airborne, :3] - toss[0, :3], axis=1)
        assert (strayed <= 1e-3 + 0.033 * times + 0.02 * way).all()
        assert strayed[0] < 1e-12


def test_a_floor_with_the_right_friction_predicts_tosses_and_mujocos_own_does_not(
    root: Path,
) -> None:
    real = tosses(root, range(300, 320))
    floor = Floor(mu=PUBLISHED, stiffness=3000.0, damping=60.0)
    variants = controls(from_mjcf(DESCRIPTION), floor, Floor(mu=PUBLISHED))
    simulated = flights(list(variants.values()), real)
    position = dict(zip(variants, position_errors(simulated, real).mean(axis=1), strict=True))
    # The whole study's figures are 0.12, 0.14, 0.27 and 0.96, and 0.06 is one toss's spread: a
    # fifth of that, 0.013, is the error of a mean of twenty. Three of those aside:
    assert position["fitted"] < 0.14 + 0.04
    assert position["fitted, friction a pyramid"] > 0.27 - 0.06
    assert position["as MuJoCo comes"] > 0.8
    assert position["softness alone"] > 0.8
    rotation = rotation_errors(simulated, real).mean(axis=1)
    assert rotation[0] < rotation[-1]


def test_eight_tosses_and_few_tries_are_enough_for_the_published_friction(root: Path) -> None:
    floor = fitted(
        from_mjcf(DESCRIPTION), tosses(root, range(8)), np.random.default_rng(3), rounds=5, tries=9
    )
    # Published to two digits; the goal of the whole study is a tenth, of this small one a fifth.
    assert floor.mu == pytest.approx(PUBLISHED, rel=0.2)


def test_the_fit_is_the_same_for_the_same_seed(root: Path) -> None:
    robot, real = from_mjcf(DESCRIPTION), tosses(root, range(2))
    once, again = (
        fitted(robot, real, np.random.default_rng(5), rounds=1, tries=4) for _ in range(2)
    )
    assert once == again


def test_friction_fitted_alone_leaves_the_floor_as_hard_as_mujoco_has_it(root: Path) -> None:
    floor = fitted(
        from_mjcf(DESCRIPTION),
        tosses(root, range(8)),
        np.random.default_rng(3),
        rounds=3,
        tries=9,
        hard=True,
    )
    assert (floor.stiffness, floor.damping) == (None, None)
    assert [type(effect).__name__ for effect in floor.effects()] == ["Ground", "ContactFriction"]
    assert floor.mu == pytest.approx(PUBLISHED, rel=0.2)


def test_a_study_says_what_it_fitted_and_what_it_scored(
    root: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def quick(*_: object, hard: bool) -> Floor:
        return Floor(mu=0.3) if hard else Floor(mu=0.2, stiffness=2000.0, damping=60.0)

    monkeypatch.setattr("experiments.cube.fitted", quick)
    result = json.loads(json.dumps(studied(root, train=2, test=3, seed=4)))
    assert result["schema"] == "morph.cube/2"
    assert (result["train"], result["seed"]) == ([0, 1], 4)
    assert (result["floor"]["mu"], result["friction_alone"]) == (0.2, 0.3)
    assert [each["tosses"] for each in result["sets"]] == [[100, 102], [300, 302]]
    for scored in result["sets"]:
        errors = scored["errors"]
        assert errors["fitted"]["position_widths"] < 0.5
        # What does not move strays by the whole toss, and a toss is told from another.
        still = errors["does not move"]["position_widths"]
        assert still > 2.0 * errors["fitted, of another toss"]["position_widths"] > 0.5
        more = errors[RIVAL]["position_widths"] - errors[FITTED]["position_widths"]
        assert scored["rival_costs_more"]["widths"] == pytest.approx(more)
    report(result)
    said = capsys.readouterr().out
    assert "tosses 100 to 102 (judged, opened once)" in said
    assert "tosses 300 to 302 (development)" in said


def test_no_toss_is_fitted_and_scored() -> None:
    assert not set(range(100)) & {toss for each in SETS.values() for toss in each}
    assert not set(SETS["judged, opened once"]) & set(SETS["development"])


def test_tosses_that_are_not_there_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(DataError, match="cannot be read"):
        tosses(tmp_path, range(2))
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path))
    assert main(["--train", "2", "--test", "2"]) == 2
    assert "MORPH_RECORDINGS" in capsys.readouterr().err


def test_more_tosses_than_there_are_is_refused() -> None:
    with pytest.raises(SystemExit):
        main(["--train", "101"])
