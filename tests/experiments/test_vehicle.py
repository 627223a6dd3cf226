from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from experiments.vehicle import DESCRIPTION, PARTS, parts_of, surge
from morph.body.load import load
from morph.body.spec import spec_of
from morph.record.recording import Channel, Recording


def test_a_session_is_cut_into_parts_that_are_told_apart() -> None:
    time = np.linspace(3.0, 13.0, 101)
    whole = Recording(name="s", channels={"a": Channel(time=time, value=time)}, sha256="one")
    parts = parts_of(whole)
    assert [part.name for part in parts] == [f"s_{number}" for number in range(PARTS)]
    assert {part.sha256 for part in parts} == {""}
    assert parts[1].channel("a").time[[0, -1]] == pytest.approx([5.0, 7.0], abs=1e-12)


def test_surge_is_along_the_hull_wherever_it_points() -> None:
    # 0.4 m/s along a hull that is turned about all axes and measured a little otherwise.
    turn = Rotation.from_rotvec([0.3, -0.5, 1.1])
    off = Rotation.from_rotvec([0.02, -0.01, 0.03])
    steps = np.arange(20)
    place = 0.4 * 0.1 * steps[:, None] * (off * turn).apply([1.0, 0.0, 0.0])
    reading = np.concatenate([place, np.tile(off.as_rotvec(), (20, 1))], axis=1)[None]
    attitude = np.tile(turn.as_quat(scalar_first=True), (1, 20, 1, 1))
    rows = type("Rows", (SimpleNamespace,), {"__len__": lambda self: 1})
    segments = rows(
        attitude=attitude,
        step=0.1,
        before=steps[None],
        part=np.zeros((1, 20)),
        valid=np.ones((1, 20, 6), dtype=bool),
    )
    found = surge(segments, reading)
    assert found == pytest.approx(np.full((1, 20), 0.4), rel=1e-12)


def test_the_described_vehicle_floats_level_and_returns() -> None:
    model = spec_of(load(DESCRIPTION)).compile()
    assert model.body_mass.sum() == pytest.approx(13.5, rel=1e-12)
    # The lift of the foam is all the weight: 13.5 times what its own 1 kg weighs.
    assert model.body_gravcomp @ model.body_mass == pytest.approx(13.5, rel=1e-12)
