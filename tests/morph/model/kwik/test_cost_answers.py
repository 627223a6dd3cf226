"""From costs on drawn targets to an answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.model.kwik import cost


@pytest.mark.parametrize(
    ("near", "off", "answer"),
    [
        # 23 of 24 are 95.8 %, 22 are 91.7 %; 1 is 4.2 %, 2 are 8.3 %.
        (24, 1.2, "good"),
        (23, 1.2, "good"),
        (22, 1.2, "cannot say"),
        (2, 1.2, "cannot say"),
        (1, 1.2, "not good"),
        # A target that costs far less is foretold as badly as one that costs far more.
        (1, 0.8, "not good"),
        (12, 0.8, "cannot say"),
    ],
)
def test_a_cost_is_good_if_nineteen_targets_of_twenty_are_within_the_tolerance(
    monkeypatch: pytest.MonkeyPatch, near: int, off: float, answer: str
) -> None:
    # The model's own cost of 10 comes first; a tenth of it is allowed either way.
    losses = 10.0 * np.concatenate([[1.0], np.where(np.arange(24) < near, 1.05, off)])
    monkeypatch.setattr(cost, "_losses", lambda *arguments: losses)
    task = cast(Any, SimpleNamespace(noise=0.01, name="toy"))
    none = cast(Any, None)
    found = cost.foretell(none, [], task, none, rng=np.random.default_rng(0))
    assert found.verdict == answer
    assert found.probability == pytest.approx(near / 24.0)
    assert (found.model, len(found.targets)) == (10.0, 24)
