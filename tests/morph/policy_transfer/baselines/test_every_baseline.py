from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.policy_transfer.baselines.baseline import Baseline
from morph.policy_transfer.baselines.baselines import BASELINES
from morph.policy_transfer.baselines.ladder import Ladder
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.plans import TrialBudget
from morph.search.search import Trial
from morph.search.target import Experience, Simulated, Target

SMALL = TrialBudget(rows=48, keep=1, most=4, margins=(0.1,), rhos=(10.0,), bodies=(8, 16), best=2)
TRIALS = 2


@dataclass(frozen=True, kw_only=True)
class Counted(Target):
    """A target that keeps what it was asked."""

    real: Simulated
    """What trials are made on."""
    asked: list[Policy | Array] = field(default_factory=list)
    """What was tried."""

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Return one run, and keep what was asked."""
        self.asked.append(policy)
        return self.real.trial(policy, rng)


Record = tuple[Baseline, tuple[Trial, ...], Counted]


@pytest.fixture(scope="module", params=BASELINES, ids=lambda kind: kind.__name__)
def record(request: pytest.FixtureRequest, source: Source) -> Record:
    kind: Any = request.param
    rival: Baseline = kind(effort=SMALL)
    target = Counted(real=source.target)
    return rival, rival.run(source, target, trials=TRIALS, seed=100), target


def test_each_trial_has_a_line_and_costs_one_run(record: Record) -> None:
    _, lines, target = record
    assert [line.number for line in lines] == [1, 2]
    assert len(target.asked) == TRIALS
    # A run lasts 3 s; hanging still all along costs 61, one for each sample.
    assert [line.experience for line in lines] == pytest.approx([3.0, 6.0])
    assert all(0.0 < line.loss <= 61.0 for line in lines)
    assert {line.success for line in lines} <= {0.0, 1.0}


def test_the_first_trial_is_the_sources_policy_unless_nothing_is_kept(
    record: Record, source: Source
) -> None:
    rival, _, target = record
    assert (target.asked[0] is source.policy) == (rival.name != "from scratch")


def test_trials_meet_the_same_chance_whoever_tries(record: Record, source: Source) -> None:
    _, lines, target = record
    for number, (line, policy) in enumerate(zip(lines, target.asked, strict=True), 1):
        again = source.target.trial(policy, np.random.default_rng([100, number, 1]))
        assert again.loss == line.loss


def test_the_same_seed_gives_the_same_trials_and_fewer_are_their_beginning(
    record: Record, source: Source
) -> None:
    rival, lines, _ = record
    # One that learns is repeated whole; of the others the first trial must do.
    trials = TRIALS if rival.name == "pooled data" else 1
    again = rival.run(source, source.target, trials=trials, seed=100)
    assert [(x.loss, x.note) for x in again] == [(x.loss, x.note) for x in lines[:trials]]


def test_a_target_without_surprise_asks_no_simulation(record: Record) -> None:
    rival, lines, _ = record
    counts = [line.note.rpartition(" before it: ")[2] for line in lines]
    assert counts == ["0"] * TRIALS or not isinstance(rival, Ladder)


def test_no_trial_is_refused(record: Record, source: Source) -> None:
    with pytest.raises(TransferError, match=r"it is given 0 trials"):
        record[0].run(source, source.target, trials=0, seed=100)


def test_names_differ() -> None:
    assert len({kind.name for kind in BASELINES}) == len(BASELINES)


@pytest.mark.parametrize("name", ["pooled data", "samples carried over", "ladder of fidelities"])
def test_who_carries_samples_refuses_a_source_without(name: str, source: Source) -> None:
    (kind,) = (each for each in BASELINES if each.name == name)
    bare = replace(source, experience=())
    with pytest.raises(TransferError, match=r"brings no experience"):
        kind().run(bare, source.target, trials=1, seed=100)
