"""Where defects go: on enough robots, at different places, the same ones for one seed."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.plant import DEFECTS
from experiments.plant.defect import Defect
from experiments.plant.draw import draw
from experiments.plant.originals import PACKAGED, originals, packaged_root


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda one: one.name)
def test_published_robots_have_ten_places_of_each_class_on_four_of_them(defect: Defect) -> None:
    if not packaged_root().is_dir():
        pytest.skip("example-robot-data is not installed")
    packaged = [one for one in originals() if one.name in PACKAGED]
    found = draw(defect, packaged, 10, np.random.default_rng(7))
    assert len(found) == 10
    assert len({one.original.name for one in found}) >= 4
    assert len({(one.original.name, one.variant, one.site) for one in found}) == 10
    assert found == draw(defect, packaged, 10, np.random.default_rng(7))
