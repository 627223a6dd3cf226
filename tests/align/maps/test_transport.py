"""A transport plan between a cloud and the same cloud turned."""

from __future__ import annotations

import numpy as np

from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.transport import Transport
from morph.alignment.samples import Transitions


def test_a_turned_cloud_is_mapped_back_in_its_whole_width() -> None:
    # Lopsided, so that no mirror image is as good; turned by 90 degrees and moved.
    rng = np.random.default_rng(0)
    cloud = rng.exponential(size=(60, 2)) ** 1.5 * np.array([2.0, 1.0])
    turned = np.stack([-cloud[:, 1], cloud[:, 0]], axis=1) + 3.0
    level, told = np.array([False, False]), np.zeros((60, 1))
    source, target = (
        Transitions(state=each, command=told, after=each, turns=level) for each in (cloud, turned)
    )
    law = Transport().states(MapData(source=source, target=target), np.random.default_rng(1))
    found = law(turned)
    # Each point comes back near its own; a plan that takes points elsewhere leaves a map to the
    # middle, and that errs by one spread.
    assert np.sqrt(np.square((found - cloud) / cloud.std(axis=0)).mean()) < 0.5
