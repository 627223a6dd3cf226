"""Bodies that come out otherwise every time."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TransferError
from morph.policy_transfer.iterations import Drift, PrintedBody, first_of, iterations, nearby
from morph.task.balance import balance
from morph.task.push import Push


@pytest.fixture(scope="module")
def printed() -> PrintedBody:
    """Return the cart-pole of which no two copies are alike."""
    push = Push(link="pole", impulse=(0.2, 0.0, 0.0))
    return PrintedBody(described=load("cartpole"), pose=balance, push=push, drift=Drift())


def test_a_number_stands_for_each_length_mass_and_motor(printed: PrintedBody) -> None:
    assert printed.numbers == (
        ("length", "pole"),
        ("mass", "cart"),
        ("mass", "pole"),
        ("motor", "slide"),
    )


def test_changes_do_what_their_logarithms_say(printed: PrintedBody) -> None:
    # 1.1 times as long at its density: 1.1^3 times the mass; then half of it.
    made = printed.body(np.log([1.1, 2.0, 0.5, 3.0])).task
    before = {link.name: link.mass for link in printed.described.links}
    after = {link.name: link.mass for link in made.robot.links}
    assert after["pole"] == pytest.approx(0.5 * 1.1**3 * before["pole"])
    assert after["cart"] == pytest.approx(2.0 * before["cart"])


def test_a_motor_that_gives_more_moves_all_speeds_by_as_much(printed: PrintedBody) -> None:
    # B goes with the gain e^w, so dB / dw at 0 is B, and A does not depend on it.
    W, slope = printed.linear(np.zeros(4))
    motor = slope[:, 3].reshape(W.shape)
    # A difference over w = 1e-3 is off by half of that, 5e-4.
    assert motor[:, 4:] == pytest.approx(W[:, 4:], rel=1e-3, abs=1e-6)
    assert np.abs(motor[:, :4]).max() < 1e-5


def test_iterations_walk_from_body_to_body(printed: PrintedBody) -> None:
    changes = np.array(iterations(printed, count=6, rng=np.random.default_rng(0)))
    steps = np.diff(changes, axis=0, prepend=np.zeros((1, 4))) / printed.spread
    # 24 standard normal numbers: their mean square is 1 +- 0.29.
    assert 0.3 < np.square(steps).mean() < 2.0


def test_transitions_go_on_where_the_last_one_ended_or_begin_near_rest(
    printed: PrintedBody,
) -> None:
    seen = nearby(printed.body(np.zeros(4)), 200, np.random.default_rng(0))
    goes_on = (seen.state[1:] == seen.after[:-1]).all(axis=1)
    assert goes_on.sum() > 100
    begun = seen.state[1:][~goes_on]
    # The start's spread 0.02 and the noise 0.01 make 0.022; five times that is never reached.
    assert len(begun) > 0
    assert np.abs(begun).max() < 0.12
    assert len(first_of(seen, 7).state) == 7


def test_a_few_transitions_show_how_a_body_has_changed(printed: PrintedBody) -> None:
    change = np.array([0.1, -0.2, 0.2, -0.3])
    made = printed.body(change)
    before = printed.known().changed(printed.spread)
    after = before.seen(nearby(made, 20, np.random.default_rng(1)), noise=made.task.noise)
    truth = np.concatenate(made.linear, axis=1)
    assert np.abs(after.linear - truth).max() < 0.5 * np.abs(before.linear - truth).max()
    # Four numbers in their own standard deviations: a squared length beyond 18.5 is one in 1000.
    off = after.mean - change
    assert off @ np.linalg.solve(after.covariance, off) < 18.5


def test_a_drift_of_nothing_is_refused() -> None:
    with pytest.raises(TransferError, match=r"masses = 0 is out of range"):
        Drift(masses=0.0)
