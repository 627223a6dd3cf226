from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.model.latent.unknowns import turned
from morph.policy_transfer.live.actuator_gain_check import Heed, heed_of
from morph.policy_transfer.live.callable_target import Called
from morph.policy_transfer.live.live import Live
from morph.policy_transfer.live.wiring import hello_for
from morph.search.target import Simulated
from morph.task.task import Task
from morph.task.tasks import task

Factors = dict[str, float]
PUSHES = 8.0 * np.sign(np.sin(0.7 * np.arange(60)))[:, None]


@pytest.fixture(scope="module")
def whole() -> Task:
    return task("swing-up", load("cartpole"))


def heed(whole: Task, obeys: float, seed: int = 100, factors: Factors | None = None) -> Heed:
    """Return what is found where the body is told pushes and does a multiple of them."""
    body = task("swing-up", turned(whole.robot, factors)) if factors else whole
    target = Simulated(task=body, simulator=body.simulator())
    run = target.trial(obeys * PUSHES, np.random.default_rng(seed))
    found = heed_of(whole.simulator(), run.position, run.velocity, PUSHES, run.period)
    assert found is not None
    return found


@pytest.mark.parametrize("obeys", [1.0, 0.3])
def test_the_share_is_that_of_the_commands_that_the_body_does(whole: Task, obeys: float) -> None:
    found = heed(whole, obeys)
    # Noise of 0.01 beside pushes of 8 N: a standard error of 0.005, three of them and 5 ms late.
    assert found.share == pytest.approx(obeys, abs=0.04)
    assert not found.ignored
    assert not found.opposite


@pytest.mark.parametrize("seed", range(100, 105))
def test_a_body_that_does_nothing_it_is_told_is_found_out(whole: Task, seed: int) -> None:
    assert heed(whole, 0.0, seed).ignored


def test_a_body_that_does_the_opposite_is_found_out_as_that(whole: Task) -> None:
    found = heed(whole, -1.0)
    assert found.opposite
    assert not found.ignored


@pytest.mark.parametrize(
    "factors",
    [{"weight:cart": 10.0, "weight:pole": 10.0}, {"damping:slide": 50.0}, {"length:pole": 0.4}],
)
def test_a_body_other_than_described_still_heeds(whole: Task, factors: Factors) -> None:
    found = heed(whole, 1.0, factors=factors)
    assert not found.ignored
    assert not found.opposite


def test_a_body_that_is_told_nothing_tells_nothing(whole: Task) -> None:
    target = Simulated(task=whole, simulator=whole.simulator())
    run = target.trial(0.0 * PUSHES, np.random.default_rng(100))
    told = (whole.simulator(), run.position, run.velocity, run.command, run.period)
    assert heed_of(*told) is None


@pytest.mark.parametrize(
    ("does", "said"), [(0.0, "seems not to follow"), (-1.0, "moves against"), (1.0, "")]
)
def test_a_trial_notes_whether_the_target_follows(whole: Task, does: float, said: str) -> None:
    target = Simulated(task=whole, simulator=whole.simulator())
    run = target.trial(does * PUSHES, np.random.default_rng(100))
    names = [each.name for each in hello_for(whole.robot, whole.period).channels]
    states = iter(np.concatenate([run.position, run.velocity], axis=1).tolist())

    def step(command: Array | None) -> dict[str, float]:
        return dict(zip(names, next(states), strict=True))

    called = Called(step, hello_for(whole.robot, whole.period), stopped=lambda: None)
    live = Live(whole, called)
    live.trial(PUSHES, np.random.default_rng(100))
    live.close()
    assert live.conduct is not None
    notes = " ".join(live.conduct.notes)
    assert said in notes
    assert ("commands" in notes) is bool(said)
