"""An ensemble finds the model that a run came from, and says when it does not know."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.body.vary import Heavier, vary
from morph.errors import DiagnosisError, EvidenceError
from morph.model.candidate import Candidate
from morph.model.ensemble import Ensemble
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.nuisance_parameters import knobs
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.sim.simulator import Simulator
from morph.sim.tangent import moved_by

PERIOD, NOISE = 0.05, 0.01


def _simulator(factor: float = 1.0, friction: float = 0.0) -> Simulator:
    robot = vary(load("cartpole"), Heavier(link="pole", factor=factor))
    effects = (ViscousFriction(joint="slide", b=friction),) if friction else ()
    return Simulator(robot, effects, step=0.01)


def _run(simulator: Simulator, rng: np.random.Generator, *, seconds: float = 2.0) -> Run:
    """Return a noisy run under random commands."""
    periods, every = round(seconds / PERIOD), round(PERIOD / simulator.step)
    model = simulator.model
    told = rng.uniform(-5.0, 5.0, size=(periods, model.nu))
    moved = simulator.trajectory(
        seconds=seconds,
        command={
            each.name: (lambda t, at=at: told[np.floor(t / PERIOD + 1e-6).astype(int), at])
            for at, each in enumerate(simulator.robot.actuators)
        },
    )
    off = NOISE * rng.normal(size=(2, periods + 1, model.nv))
    return Run(
        position=moved_by(model, moved.position[::every], off[0]),
        velocity=moved.velocity[::every] + off[1],
        command=told,
        period=PERIOD,
    )


def _ensemble(*factors: float) -> Ensemble:
    return Ensemble(
        candidates=tuple(Candidate.of(f"pole x{each:g}", _simulator(each)) for each in factors),
        noise=np.full(4, NOISE),
    )


def test_the_right_model_stands_out_whatever_the_order_of_the_runs() -> None:
    rng = np.random.default_rng(1)
    runs = [_run(_simulator(1.0), rng), _run(_simulator(1.0), rng)]
    before = _ensemble(0.5, 1.0, 2.0)
    assert before.probability == pytest.approx(np.full(3, 1.0 / 3.0))
    assert before.entropy == pytest.approx(np.log(3.0))
    assert before.standing_out() is None
    after = before.after(runs)
    assert after.best.name == "pole x1"
    assert after.standing_out() is after.best
    assert after.entropy < 0.05
    assert after.none < 0.02
    turned = before.after(runs[1:]).after(runs[:1])
    assert turned.probability == pytest.approx(after.probability, abs=1e-9)


def test_models_that_are_alike_share_the_probability_by_their_priors() -> None:
    run = _run(_simulator(1.0), np.random.default_rng(2))
    twins = _ensemble(1.0, 2.0)
    more = replace(twins.candidates[0], name="twin", prior=3.0)
    told = replace(twins, candidates=(*twins.candidates, more)).after([run])
    # The same evidence, so the odds stay as they were: 1 to 3.
    assert told.probability[2] / told.probability[0] == pytest.approx(3.0)
    assert told.probability[1] < 0.01
    assert told.standing_out() is None


def test_where_all_fit_badly_none_stands_out() -> None:
    # Against some 10 N s/m a cart of about 1 kg stops within 0.1 s: no model knows why.
    run = _run(_simulator(1.0, friction=10.0), np.random.default_rng(3))
    told = _ensemble(1.0, 1.2).after([run])
    assert told.none > 0.95
    assert told.standing_out() is None


def test_a_figure_in_doubt_is_taken_for_unknown() -> None:
    run = _run(_simulator(1.0), np.random.default_rng(4))
    sure = Ensemble(
        candidates=(
            Candidate.of("light", _simulator(0.8)),
            Candidate.of("right", _simulator(1.0)),
        ),
        noise=np.full(4, NOISE),
    )
    doubtful = Candidate.of("light", _simulator(0.8), doubts=[_simulator(1.0)])
    right = replace(sure.candidates[1], doubts=(sure.candidates[1].variant,))
    both = replace(sure, candidates=(doubtful, right)).after([run])
    # It pays for its doubt, by how much narrower the run makes it, but not for being wrong.
    assert sure.after([run]).probability[0] < 1e-6 * both.probability[0] < 1e-6
    assert both.weighed is not None
    assert both.weighed.doubt[0, 0] == pytest.approx(1.0, abs=0.3)


def test_a_hypothesis_is_a_candidate_with_its_covariance_as_doubts() -> None:
    robot = load("cartpole")
    hypothesis = Hypothesis(robot=robot, step=0.01, knobs=knobs(robot))
    size = hypothesis.size
    covariance = 1e-4 * (np.eye(size) + 0.5)
    found = Candidate.at("as described", hypothesis, hypothesis.start, covariance=covariance)
    assert len(found.doubts) == size
    told = Ensemble(candidates=(found,), noise=np.full(4, NOISE)).after(
        [_run(_simulator(1.0), np.random.default_rng(5))]
    )
    assert told.none < 0.05


def test_a_mixture_predicts_between_its_models_and_says_how_far_they_are_apart() -> None:
    light, heavy = (Simulator(load("hexapod_swimmer"), step=0.01) for _ in range(2))
    heavy.model.opt.gravity[2] = -19.62
    mixed = Ensemble(
        candidates=(
            Candidate.of("g", light, prior=1.0),
            Candidate.of("2 g", heavy, prior=3.0),
        ),
        noise=np.full(24, NOISE),
    )
    command = np.zeros((50, light.model.nu))
    found = mixed.predict(light.model.qpos0, np.zeros(12), command)
    position, velocity = found.mean
    # After 0.5 s speeds of the whole are -g t and -2 g t: 4.905 apart, mean 1.75 of the first.
    assert velocity[-1, 2] == pytest.approx(-1.75 * 4.905, rel=1e-2)
    # A quarter and three quarters, 4.905 apart: a standard deviation of 4.905 sqrt(3) / 4.
    assert found.spread[-1, 12 + 2] == pytest.approx(4.905 * np.sqrt(3.0) / 4.0, rel=1e-2)
    assert np.linalg.norm(position[-1, 3:7]) == pytest.approx(1.0, abs=1e-9)
    assert mixed.expected(lambda each: 1.0 if each.name == "g" else 5.0) == pytest.approx(4.0)
    drawn = mixed.draw(4000, np.random.default_rng(0))
    # Binomial: standard error sqrt(0.75 * 0.25 / 4000) = 0.007.
    assert drawn.mean() == pytest.approx(0.75, abs=0.03)


def test_what_cannot_be_an_ensemble_is_refused() -> None:
    one, other = Candidate.of("a", _simulator()), Candidate.of("b", _simulator(2.0))
    noise = np.full(4, NOISE)
    with pytest.raises(EvidenceError, match="its models are none"):
        Ensemble(candidates=(), noise=noise)
    with pytest.raises(EvidenceError, match="its models are a, a"):
        Ensemble(candidates=(one, one), noise=noise)
    with pytest.raises(EvidenceError, match=r"its priors are \[1\.0, -1\.0\]"):
        Ensemble(candidates=(one, replace(other, prior=-1.0)), noise=noise)
    with pytest.raises(EvidenceError, match="no positive number for each of 4 entries"):
        Ensemble(candidates=(one, other), noise=np.zeros(4))
    pendulum = Candidate.of("c", Simulator(load("pendulum"), step=0.01))
    with pytest.raises(EvidenceError, match="differ in their numbers of joints"):
        Ensemble(candidates=(one, pendulum), noise=noise)
    with pytest.raises(EvidenceError, match="not as many figures in doubt"):
        Ensemble(candidates=(one, replace(other, doubts=(one.variant,))), noise=noise)
    ready = Ensemble(candidates=(one, other), noise=noise)
    with pytest.raises(DiagnosisError, match="the body has 2, 2 and 1"):
        ready.after([_run(Simulator(load("pendulum"), step=0.01), np.random.default_rng(0))])
