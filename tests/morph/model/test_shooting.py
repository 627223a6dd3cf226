from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.model.measurement import Measurement
from morph.model.segments import Segments
from morph.model.shooting import Sensitivity, loss, quadratic


def made_up(rng: np.random.Generator) -> tuple[Segments, Sensitivity]:
    """Return 5 segments of 12 readings of one joint, and 3 parameters, all random."""
    start = rng.normal(size=(5, 2))
    segments = Segments(
        measurement=Measurement.of(load("pendulum")),
        attitude=np.zeros((5, 12, 0, 4)),
        episodes=(),
        episode=np.zeros(5, dtype=int),
        first=np.arange(5),
        steps=12,
        before=np.zeros((5, 12), dtype=int),
        part=np.zeros((5, 12)),
        valid=(np.arange(12) < np.array([[12], [12], [12], [12], [7]]))[..., None],
        reading=rng.normal(size=(5, 12, 1)),
        start=start,
        start_trust=np.array([3.0, 0.5]),
        noise=np.ones(1),
        guess=np.zeros(1),
    )
    around = Sensitivity(
        error=rng.normal(size=(5, 12)),
        by_point=rng.normal(size=(5, 12, 3)),
        by_start=rng.normal(size=(5, 12, 2)),
        start=start + rng.normal(size=(5, 2)),
    )
    return segments, around


@pytest.mark.parametrize("seed", range(5))
def test_the_loss_with_starts_eliminated_is_the_least_over_all_starts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    segments, around = made_up(rng)
    weight = rng.uniform(0.1, 1.0, 5)
    curve = quadratic(segments, around, weight)
    root = np.sqrt(segments.start_trust)
    for change in (np.zeros(3), rng.normal(size=3)):
        losses = curve.loss - 2.0 * curve.slope @ change
        losses += np.einsum("p,spq,q->s", change, curve.hessian, change)
        moved = around.start + curve.start_change(change)
        for s in range(5):
            # Readings and the trust in the measured start, as one least-squares problem.
            matrix = np.concatenate([around.by_start[s], np.diag(root)])
            off = segments.start[s] - around.start[s]
            right = np.concatenate([around.error[s] - around.by_point[s] @ change, root * off])
            best, squares, _, _ = np.linalg.lstsq(matrix, right)
            assert losses[s] == pytest.approx(weight[s] * float(squares[0]), rel=1e-9)
            assert moved[s] == pytest.approx(around.start[s] + best, abs=1e-9)


def test_a_share_of_a_step_takes_that_share_of_the_starts_own_step() -> None:
    rng = np.random.default_rng(7)
    segments, around = made_up(rng)
    curve = quadratic(segments, around, np.ones(5))
    change = rng.normal(size=3)
    whole, half = curve.start_change(change), curve.start_change(0.5 * change, 0.5)
    assert half == pytest.approx(0.5 * whole, abs=1e-12)


def test_padded_readings_and_trusted_starts_count_as_they_should() -> None:
    segments, _ = made_up(np.random.default_rng(8))
    predicted = segments.reading + 2.0
    moved = segments.start + np.array([1.0, 2.0])
    # Each reading is 2 off, in units of 4: 0.25. Starts: 3 * 1^2 + 0.5 * 2^2 = 5.
    due = 0.25 * np.array([12, 12, 12, 12, 7]) + 5.0
    assert loss(segments, predicted, moved, np.array([4.0])) == pytest.approx(due, rel=1e-12)


def test_derivatives_after_a_step_tell_what_it_changed_and_no_more() -> None:
    rng = np.random.default_rng(9)
    _, around = made_up(rng)
    error, moved = rng.normal(size=(5, 12)), rng.normal(size=(5, 2))
    change = rng.normal(size=3)
    found = around.after(change, error, around.start + moved, moved)
    whole = np.concatenate([around.by_point, around.by_start], axis=2)
    new = np.concatenate([found.by_point, found.by_start], axis=2)
    step = np.concatenate([np.tile(change, (5, 1)), moved], axis=1)
    assert (found.exact, found.error is error) == (False, True)
    assert np.einsum("smp,sp->sm", new, step) == pytest.approx(around.error - error, abs=1e-12)
    # In units of the columns' sizes, steps at right angles to this one are told as before.
    for s in range(5):
        square = (whole[s] ** 2).sum(axis=0)
        across = rng.normal(size=5)
        across -= step[s] * (square * step[s] @ across) / (square * step[s] @ step[s])
        assert new[s] @ across == pytest.approx(whole[s] @ across, abs=1e-12)


def test_what_did_not_move_keeps_its_derivatives() -> None:
    _, around = made_up(np.random.default_rng(10))
    found = around.after(np.zeros(3), around.error, around.start, np.zeros((5, 2)))
    assert (found.by_point == around.by_point).all()
    assert (found.by_start == around.by_start).all()
