"""The study of figure 1, small."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.figure_one import headline, summary
from experiments.walkers import DISTANCE, _walked


def test_a_loss_tells_a_distance() -> None:
    # Half the distance: ((1.5 - 0.5) D / (D / 2))^2 / 2 = 2. A fall costs more than 4.5.
    found = _walked(np.array([2.0, 2.0, 25.0, 25.0]))
    assert found == pytest.approx(0.25 * DISTANCE)


def test_ways_that_were_not_solved_count_as_never() -> None:
    one = {"share": 1.0, "runs": 120.0, "first": 0.0, "walked": 0.5}
    other = {"share": 0.0, "runs": np.inf, "first": 0.0, "walked": 0.1}
    rows = [{"biped": {}, "humanoid": {"carried": each}} for each in (one, other)]
    found = summary(rows)["humanoid: carried"]
    assert found["solved"] == 0.5
    assert found["runs"] == np.inf


def test_every_start_but_the_carried_gait_is_a_control() -> None:
    one = {"share": 1.0, "runs": np.inf, "first": 0.0, "walked": 0.5}
    ways = {"carried": one, "from nothing": one | {"share": 0.25}}
    saved = headline(summary([{"biped": ways | {"stand": one}, "humanoid": ways}]))
    assert set(saved["controls"]) == {"biped from nothing", "humanoid from nothing"}
    assert saved["controls"]["humanoid from nothing"]["share"] == 0.25
    assert saved["figures"]["humanoid_carried_share"] == 1.0
    # Runs until it was solved: never.
    assert "humanoid_carried_runs" not in saved["figures"]
