"""What becomes of an unstable simulation whose fluid runs in numpy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SimulationFailed
from morph.physics.fluid import kernel
from morph.physics.fluid.linear_drag import LinearDrag
from morph.sim.rollout import Variant, rollout
from morph.sim.simulator import Simulator


@pytest.fixture
def _by_numpy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Do without the compiled fluid, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    held = mujoco.get_mjcb_passive()
    monkeypatch.setattr(kernel, "_kernel", lambda: None)
    mujoco.set_mjcb_passive(None)
    yield
    mujoco.set_mjcb_passive(held)


@pytest.mark.usefixtures("_by_numpy")
def test_it_repeats_its_last_state_or_is_an_error_and_leaves_no_file(tmp_path: Path) -> None:
    # Drag of 1000 N s/m on 17 kg is explicit: a step of 0.1 s turns the speed round to 5 times.
    drag = LinearDrag(body="hull", x=1000.0, y=1000.0, z=1000.0)
    model = Simulator(load("hexapod_swimmer"), (drag,), step=0.1).model
    variants = [Variant(model=model, effects=(drag,))]
    start = np.tile(model.qpos0, (2, 1))
    speed = np.zeros((2, model.nv))
    speed[0, 0] = 1.0
    told = np.zeros((2, 60, model.nu))
    model.opt.gravity[:] = 0.0
    q, v = rollout(variants, np.zeros(2, int), start, speed, told)
    ended = int(np.argmax((v[0] == v[0, -1]).all(axis=1)))
    assert 1 < ended < 50
    assert np.isfinite(q).all()
    assert (q[0, ended:] == q[0, -1]).all()
    # The other row has no speed to be turned round.
    assert np.abs(v[1]).max() < 1e-6
    with pytest.raises(SimulationFailed, match="the simulation became unstable"):
        rollout(variants, np.zeros(2, int), start, speed, told, strict=True)
    assert list(tmp_path.iterdir()) == []
