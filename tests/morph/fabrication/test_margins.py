"""What motors need, beside what they have."""

from __future__ import annotations

import pytest

from morph.body.load import load
from morph.body.vary import vary
from morph.body.vary.heavier import Heavier
from morph.fabrication.margins import margins
from morph.policy.pattern import Swing, pattern
from morph.task.tasks import task

PENDULUM = load("pendulum")
LIGHTER = vary(PENDULUM, Heavier(link="rod", factor=0.6))


def test_a_lighter_pendulum_is_held_by_less() -> None:
    (found,) = margins(PENDULUM, LIGHTER)
    # 1 kg at 0.5 m: at most 4.905 N m of 10. Of 200 angles drawn evenly the nearest to level is
    # off by about pi / 200 at most times 3, which costs 1 - cos 0.05 = 0.12 %.
    assert found.designed == pytest.approx(4.905, rel=2e-3)
    assert found.printed == pytest.approx(0.6 * found.designed, rel=1e-9)
    assert (found.limit, found.unit) == (10.0, "N m")
    assert found.left == pytest.approx(1.0 - found.printed / 10.0)
    assert (found.run_designed, found.run_printed) == (None, None)


def test_along_a_run_the_effort_is_what_is_commanded() -> None:
    asked = task("swing-up", PENDULUM)
    swing = pattern(PENDULUM, {"hinge": Swing(offset=1.0, amplitude=2.0, frequency=1.0)})
    swing = type(swing)(swings=swing.swings, action=swing.action, period=asked.period)
    (found,) = margins(PENDULUM, LIGHTER, learned=(swing, asked))
    # 1 + 2 sin at 20 samples a period, one of which is at its top: 3 N m.
    assert found.run_designed == pytest.approx(3.0, abs=1e-9)
    assert found.needed == pytest.approx(found.printed)
