from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import DiagnosisError
from morph.model.experiment_design import CandidateRun, chosen, information
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns
from morph.model.missing_force.corrected import Corrected
from morph.model.missing_force.fit import fit
from morph.search.target import Simulated
from morph.task.swing_up import swing_up


@pytest.fixture(scope="module")
def model() -> Corrected:
    robot = load("cartpole")
    task = swing_up(robot)
    rng = np.random.default_rng(0)
    target = Simulated(task=task, simulator=task.simulator())
    run = target.trial(np.repeat(rng.uniform(-2.0, 2.0, (15, 1)), 4, axis=0), rng).run
    short = Run(
        position=run.position[:21],
        velocity=run.velocity[:21],
        command=run.command[:20],
        period=run.period,
    )
    knobs = tuple(replace(knob, fraction=0.2) for knob in unknowns(robot))
    hypothesis = Hypothesis(robot=robot, step=task.step, knobs=knobs)
    noise = np.full(4, 0.01)
    return fit(hypothesis, [short], noise=noise, force=False, integrator="rk4")


def _candidates() -> list[CandidateRun]:
    sizes = (0.01, 8.0, 2.0, 0.01, 6.0)
    rng = np.random.default_rng(1)
    told = np.repeat(rng.uniform(-1.0, 1.0, (5, 1)), 4, axis=0)
    return [
        CandidateRun(start=np.zeros(4), command=size * told, explores=at < 3)
        for at, size in enumerate(sizes)
    ]


def test_every_other_run_explores_and_each_tells_the_most_of_its_kind(model: Corrected) -> None:
    found = chosen(model, _candidates(), 4)
    # Stronger commands show more of a body at rest: 8 N before 2 N, 6 N before 0.01 N.
    assert [each.index for each in found] == [1, 4, 2, 3]
    assert found[0].gain > found[2].gain > 0.0


def test_the_gain_is_the_change_of_the_log_determinant(model: Corrected) -> None:
    candidates = _candidates()
    added = information(model, candidates)
    precision = model.posterior.H
    before, after = (np.linalg.slogdet(P)[1] for P in (precision, precision + added[1]))
    (first,) = chosen(model, candidates, 1)
    assert first.index == 1
    assert first.gain == pytest.approx(0.5 * (after - before), rel=1e-6)


def test_a_run_that_was_taken_tells_less_a_second_time(model: Corrected) -> None:
    twice = [_candidates()[1]] * 2
    first, second = chosen(model, twice, 2)
    assert second.gain < first.gain


def test_more_runs_than_candidates_are_refused(model: Corrected) -> None:
    with pytest.raises(DiagnosisError, match="6 of 5 runs"):
        chosen(model, _candidates(), 6)
