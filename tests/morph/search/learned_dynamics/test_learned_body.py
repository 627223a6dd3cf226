"""A learned body stands in for the body, and plans are judged by what the data leave open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SearchError
from morph.model.jointed.draws import draw
from morph.model.jointed.fit import fit
from morph.model.jointed.transition import transitions
from morph.search.evaluate import evaluate
from morph.search.learned_dynamics.learned_body import Dream, known, settings_of
from morph.search.learned_dynamics.plan_choice import Plans, foreseen
from morph.search.learned_dynamics.rest_feedback import aim
from morph.search.target import Simulated
from morph.task.task import Task
from morph.task.tasks import task

NOISE = np.full(4, 0.01)


@pytest.fixture(scope="module")
def swing() -> Task:
    return task("swing-up", load("cartpole"))


@pytest.fixture(scope="module")
def dream(swing: Task) -> Dream:
    """The cart-pole as two trials with random commands show it."""
    rng = np.random.default_rng(0)
    target = Simulated(task=swing, simulator=swing.simulator())
    runs = []
    for _ in range(2):
        command = np.repeat(rng.uniform(-10.0, 10.0, (15, 1)), 4, axis=0)
        shown = target.trial(command, rng)
        runs.append((shown.position, shown.velocity, shown.command))
    model, bounds = known(swing)
    learned = fit(
        transitions(runs, swing.period), settings_of(model, bounds, slides=False, lawful=True)
    )
    return Dream(swing, model, bounds, learned)


def test_rows_are_stepped_as_they_would_be_alone(dream: Dream) -> None:
    rng = np.random.default_rng(1)
    q, v, u = rng.normal(size=(5, 2)), rng.normal(size=(5, 2)), rng.normal(size=(5, 1))
    together = dream.advance(q, v, u)
    for at in range(5):
        alone = dream.advance(q[at : at + 1], v[at : at + 1], u[at : at + 1])
        assert alone[0][0] == pytest.approx(together[0][at], abs=1e-10)
        assert alone[1][0] == pytest.approx(together[1][at], abs=1e-10)


def test_a_row_beyond_all_that_was_seen_is_no_number(dream: Dream) -> None:
    q, v = np.zeros((2, 2)), np.array([[0.0, 0.0], [0.0, 1e4]])
    after = dream.advance(q, v, np.zeros((2, 1)))
    assert np.isfinite(after[0][0]).all()
    assert np.isnan(after[0][1]).all()
    assert np.isnan(after[1][1]).all()


def test_the_goal_is_found_by_kinematics_alone(swing: Task, dream: Dream) -> None:
    still = aim(swing, dream).still
    # The pull towards the start, 1e-3 against 1 / 0.15 and 1 / 0.17, moves it by 1e-7.
    assert still.position[0] == pytest.approx(0.0, abs=1e-5)
    assert np.cos(still.position[1]) == pytest.approx(-1.0, abs=1e-9)


def test_what_cannot_be_held_as_far_as_is_known_is_not_held(swing: Task, dream: Dream) -> None:
    aims = aim(swing, dream)
    A, B = aims.slopes
    # Without commands nothing keeps a pole up.
    helpless = replace(aims, slopes=(A, 0.0 * B))
    assert (helpless.regulator(10.0).gain == 0.0).all()
    assert (aims.regulator(10.0).gain != 0.0).any()


def hanging(swing: Task, command: Array) -> Plans:
    """Return plans without feedback from the start; one row of commands each."""
    rows = len(command)
    return Plans(
        state=np.zeros((rows, swing.samples, 4)),
        command=command,
        gain=np.zeros((rows, swing.samples, 1, 4)),
    )


def pushed(swing: Task) -> Array:
    """Return pushes in time with the pole, that swing it high; (samples, 1)."""
    return 4.0 * np.sin(5.0 * swing.period * np.arange(swing.samples))[:, None]


def imagined(dream: Dream, command: Array) -> Array:
    """Return the states of the dream from rest below, (samples, 4)."""
    q, v = np.zeros((1, 2)), np.zeros((1, 2))
    states = [np.concatenate([q, v], axis=1)]
    for each in command[:-1]:
        q, v = dream.advance(q, v, each[None])
        states.append(np.concatenate([q, v], axis=1))
    return np.concatenate(states)


def test_a_high_swing_is_imagined_as_it_happens(swing: Task, dream: Dream) -> None:
    exact = replace(swing, noise=0.0, start=replace(swing.start, spread=0.0))
    command = pushed(swing)
    target = Simulated(task=exact, simulator=exact.simulator())
    shown = target.trial(command[:-1], np.random.default_rng(0))
    true = np.concatenate([shown.position, shown.velocity], axis=1)
    off = np.abs(imagined(dream, command) - true).max(axis=0)
    far = np.abs(true).max(axis=0)
    assert far[1] > 2.0
    # Two trials with noise leave an eighth of the way at most open after 3 s; a body without
    # accelerations stays at rest and is off by all of it.
    assert (off < 0.2 * far).all()


def test_what_is_foreseen_is_what_happens(swing: Task, dream: Dream) -> None:
    # Beyond its width the task's own cost is 1 whatever the body does; a quadratic one tells.
    terms = tuple(replace(term, norm="quadratic") for term in swing.terms)
    swing = replace(swing, terms=terms)
    command = pushed(swing)[None]
    plans = hanging(swing, command)
    bodies = draw(dream.learned, 64, np.random.default_rng(2))
    seen = foreseen(swing, dream, bodies, plans, NOISE, np.random.default_rng(3))
    simulator = swing.simulator()
    track = plans.track(0, swing)
    true = evaluate(swing, track, simulator, rng=np.random.default_rng(4), rows=64)
    none = replace(track, command=0.0 * track.command)
    still = evaluate(swing, none, simulator, rng=np.random.default_rng(4), rows=64)
    # Who does not swing costs less than half; two noisy trials know what it costs to a tenth.
    assert still.mean < 0.5 * true.mean
    assert seen.loss[0] == pytest.approx(true.mean, rel=0.15)
    assert seen.success[0] == true.share == 0.0


def test_a_track_does_what_its_plan_says(swing: Task) -> None:
    rng = np.random.default_rng(5)
    plans = Plans(
        state=rng.normal(size=(2, swing.samples, 4)),
        command=rng.normal(size=(2, swing.samples, 1)),
        gain=rng.normal(size=(2, swing.samples, 1, 4)),
    )
    seen = plans.state[1, 7] + 0.1 * rng.normal(size=4)
    said = plans.command[1, 7] + plans.gain[1, 7] @ (seen - plans.state[1, 7])
    told = plans.track(1, swing).act(seen, np.array(7 * swing.period))
    assert told == pytest.approx(np.clip(said, -10.0, 10.0))


def test_a_body_that_floats_is_refused() -> None:
    floating = task("swim", load("hexapod_swimmer"))
    with pytest.raises(SearchError, match="neither hinge nor slide"):
        known(floating)
