from __future__ import annotations

import pytest

from morph.body.load import load
from morph.physics.world.ground import Ground
from morph.sim.initial_penetration import buried
from morph.sim.simulator import Simulator


@pytest.mark.parametrize(("height", "deep"), [(0.0, 60.0), (0.04, 20.0)])
def test_a_hull_that_begins_in_the_floor_is_told_with_its_depth(height: float, deep: float) -> None:
    # The hull's box is 0.12 m high, so that half of it is below its middle.
    model = Simulator(load("hexapod_swimmer"), (Ground(),)).model
    start = model.qpos0.copy()
    start[2] = height
    assert f"with hull and floor {deep:g} mm within each other" in buried(model, start)


def test_what_stands_or_flies_is_not_told() -> None:
    model = Simulator(load("hexapod_swimmer"), (Ground(),)).model
    start = model.qpos0.copy()
    # 0.06 m is where the hull touches; a contact of less than 5 mm is that of standing feet.
    for height in (0.056, 0.0601, 1.0):
        start[2] = height
        assert buried(model, start) == ""
