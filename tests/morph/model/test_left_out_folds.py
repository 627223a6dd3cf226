"""Folds that are left out of a fit, on a loss that bends as its quadratic does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.arrays import Array
from morph.model import crossvalidate


@pytest.mark.parametrize(("steep", "share"), [(0.0, 1.0), (100.0, 0.5), (1000.0, 0.5)])
def test_training_segments_choose_the_share_of_a_step_that_is_scored(
    monkeypatch: pytest.MonkeyPatch, steep: float, share: float
) -> None:
    def loss(segments: None, point: Array, start: None, scale: None) -> Array:
        """Return (x - 1)^2 of six segments, and far more beyond 0.6."""
        x = float(point[0])
        return np.full(6, (x - 1.0) ** 2 + steep * max(x - 0.6, 0.0) ** 2)

    monkeypatch.setattr(crossvalidate, "predict", lambda h, segments, points, starts: points)
    monkeypatch.setattr(crossvalidate, "loss", loss)
    hypothesis = SimpleNamespace(
        low=np.array([-9.0]), high=np.array([9.0]), trust=np.array([1e-9]), likely=np.array([0.0])
    )
    # About 0 the loss is 1 - 2 x + x^2: curvature 1 and slope 1, whose best is at 1.
    curve = SimpleNamespace(
        hessian=np.ones((6, 1, 1)), slope=np.ones((6, 1)), starts_after=lambda *arguments: None
    )
    found = SimpleNamespace(
        hypothesis=hypothesis,
        point=np.zeros(1),
        start=None,
        scale=None,
        weight=1.0,
        quadratic=curve,
    )
    fold = np.array([0, 0, 1, 1, 2, 2])
    left = crossvalidate.validated(cast(Any, found), cast(Any, None), fold)
    # Of the shares 1, 0.5, 0.2 and 0 of the step to 1: where it is steep, half of it is best.
    assert left == pytest.approx(loss(None, np.array([share]), None, None), abs=1e-6)
    assert (1.0 - 0.5) ** 2 < (1.0 - 0.2) ** 2 < steep * 0.4**2 or steep == 0.0
