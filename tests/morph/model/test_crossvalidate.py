from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.crossvalidate import folds, gain, probabilities, validated
from morph.model.episodes import episode, step_for
from morph.model.fit import fit
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.model.segments import Segments, cut
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Recording

Recorded = Callable[..., Recording]


def swings(robot: Robot, recorded: Recorded, sessions: tuple[str, ...]) -> Segments:
    """Return free swings of 4.2 s, one a session, in rollouts of a second."""
    runs = [
        replace(
            recorded(robot, seconds=4.2, start={"hinge": 0.6 + 0.2 * k}, seed=k, noise=1e-3),
            name=f"run_{k}",
            session=session,
        )
        for k, session in enumerate(sessions)
    ]
    step = step_for(runs, robot)
    return cut([episode(run, robot, step) for run in runs], 1.0)


@pytest.mark.parametrize(
    ("sessions", "due"),
    [
        # Three sessions, of the days' names in order: fri, mon, tue.
        (("mon", "tue", "fri", "fri"), [1] * 4 + [2] * 4 + [0] * 8),
        # Two sessions of three episodes in all: by episode.
        (("mon", "mon", "tue"), [0] * 4 + [1] * 4 + [2] * 4),
        # Eight segments of two episodes: four stretches of two.
        (("mon", "mon"), [0, 0, 1, 1, 2, 2, 3, 3]),
        (("mon",), [0, 1, 2, 3]),
    ],
)
def test_what_belongs_together_is_left_out_together(
    pendulum: Robot, recorded: Recorded, sessions: tuple[str, ...], due: list[int]
) -> None:
    assert folds(swings(pendulum, recorded, sessions)).tolist() == due


def test_losses_of_the_right_model_are_as_large_as_its_noise(
    pendulum: Robot, recorded: Recorded
) -> None:
    segments = swings(pendulum, recorded, ("", "", ""))
    right = Hypothesis(
        robot=pendulum,
        step=segments.step,
        knobs=knobs(pendulum),
        effects=(ViscousFriction(joint="hinge", b=0.01),),
    )
    found = fit(right, segments, np.array([1e-3]), np.ones(len(segments)))
    losses = validated(found, segments, folds(segments))
    # 12 segments of 100 readings in units of their noise: 100 each, less the 2 that a
    # start takes; the mean of 1200 squares strays by sqrt(2 / 1200) = 4 %. Four sigma.
    assert losses.mean() == pytest.approx(98.0, rel=0.16)
    # One segment strays by sqrt(2 / 100) = 14 %; five sigma over a dozen.
    assert losses.max() < 100.0 * 1.7
    # And friction that was never there is not found: gravity at 0.8 rad is 3.5 N m.
    assert found.hypothesis.effects[0].b < 1e-3  # type: ignore[attr-defined]


@pytest.mark.parametrize("tries", [1, 10])
def test_noise_alone_gives_no_confidence(tries: int) -> None:
    # Losses of 24 segments of 50 readings under equally good models, one for each try.
    rng = np.random.default_rng(0)
    sure = 0
    for _ in range(200):
        before, *after = rng.chisquare(50, (1 + tries, 24))
        sure += any(gain(before, losses, tries).sure for losses in after)
    # Each draw is wrongly sure in at most 10 %: 20 of 200, and sqrt(200 0.1 0.9) = 4.2.
    assert sure <= 20 + 3 * 4.3


def test_a_gain_in_every_segment_is_sure_and_has_its_size() -> None:
    rng = np.random.default_rng(1)
    before = rng.uniform(50.0, 150.0, 24)
    won = gain(before, 0.6 * before * rng.uniform(0.9, 1.1, 24), tries=100)
    # 40 % is taken away; 24 factors within 10 % stray by 0.06 / sqrt(24) = 1.2 % of 60 %.
    assert won.mean == pytest.approx(0.4, abs=0.03)
    assert won.sure
    assert 0.2 < won.low90 < won.mean
    assert not gain(0.6 * before, before, tries=1).sure


def test_two_segments_are_no_evidence() -> None:
    assert not gain(np.array([100.0, 100.0]), np.array([1.0, 1.0]), tries=1).sure


def test_probabilities_sum_to_one_and_follow_the_losses() -> None:
    rng = np.random.default_rng(2)
    base = rng.uniform(50.0, 150.0, 20)
    losses = {"none": base, "good": 0.5 * base, "alike": 0.5 * base * rng.uniform(0.8, 1.2, 20)}
    chances = probabilities(losses, {"none": 0, "good": 1, "alike": 1}, seed=0)
    assert sum(chances.values()) == pytest.approx(1.0, abs=1e-12)
    assert chances["none"] == 0.0
    assert 0.0 < chances["alike"] < 1.0
    assert chances == probabilities(losses, {"none": 0, "good": 1, "alike": 1}, seed=0)


def test_of_two_models_that_do_equally_well_the_simpler_is_likelier() -> None:
    base = np.random.default_rng(3).uniform(50.0, 150.0, 20)
    chances = probabilities({"plain": base, "rich": base}, {"plain": 1, "rich": 3}, seed=0)
    assert chances == {"plain": 1.0, "rich": 0.0}
