from __future__ import annotations

from typing import Any

import pytest

from morph.errors import TransferError
from morph.model.latent.unknowns import turned
from morph.policy_transfer.baselines.ladder import Ladder
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.plans import TrialBudget
from morph.search.target import Simulated
from morph.task.tasks import task

SMALL = TrialBudget(rows=48, keep=1, most=4, margins=(0.1,), rhos=(10.0,), bodies=(8, 16), best=2)


def test_a_surprise_sends_the_search_down(source: Source) -> None:
    # Three times the weight accelerates a third as much under the same command.
    heavy = task("swing-up", turned(source.task.robot, {"weight:rod": 3.0}))
    real = Simulated(task=heavy, simulator=heavy.simulator())
    _, second = Ladder(effort=SMALL, most=2).run(source, real, trials=2, seed=100)
    assert 1 <= int(second.note.rpartition(": ")[2]) <= 2


@pytest.mark.parametrize("settings", [{"most": -1}, {"sure": 0.0}, {"sure": 1.5}])
def test_settings_that_say_nothing_are_refused(settings: dict[str, float]) -> None:
    wrong: Any = settings
    with pytest.raises(TransferError, match=r"give 0 runs or more"):
        Ladder(**wrong)
