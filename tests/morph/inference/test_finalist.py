"""Which of two refitted sets of effects is better."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from morph.inference.finalist import better, gains


@pytest.mark.parametrize(("more", "gain", "taken"), [
    (0, 4.0, True), (0, 2.0, False), (1, 12.0, False), (1, 25.0, True),
])  # fmt: skip
def test_another_law_in_the_place_of_one_needs_less_evidence_than_one_more(
    monkeypatch: pytest.MonkeyPatch, more: int, gain: float, taken: bool
) -> None:
    monkeypatch.setattr("morph.inference.finalist.evidence_decides", lambda runs: True)
    judge: Any = SimpleNamespace(sure=lambda a, b: False, worse=lambda a, b: False)
    refit = SimpleNamespace(runs=())
    before: Any = SimpleNamespace(evidence=0.0, losses=None, effects=(1,))
    effects = (1,) * (1 + more)
    after: Any = SimpleNamespace(
        evidence=gain, losses=None, fitted=None, refit=refit, effects=effects
    )
    assert gains(before, after, judge) == taken


def test_what_one_run_alone_determines_is_not_refuted_by_leaving_it_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("morph.inference.finalist.evidence_decides", lambda runs: True)
    judge: Any = SimpleNamespace(sure=lambda a, b: b < a - 0.1, worse=lambda a, b: b > a + 0.1)
    refit = SimpleNamespace(runs=())

    def one(evidence: float, losses: float, fitted: float) -> Any:
        return SimpleNamespace(
            evidence=evidence, losses=losses, fitted=fitted, refit=refit, effects=(1,)
        )

    before, right, wrong = one(0.0, 2.8, 2.7), one(900.0, 3.4, 1.0), one(900.0, 3.4, 3.3)
    assert gains(before, right, judge)
    assert not gains(before, wrong, judge)
    assert better(before, right, judge) is right
    assert better(before, wrong, judge) is before
