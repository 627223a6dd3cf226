"""The hexapod swimmers float, and lie, as their cards say: from their shapes alone."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of

DRAWN = ("deck", "eye", "root", "ballast")
"""Shapes that displace nothing of their own."""


def volumes(model: object) -> tuple[float, np.ndarray]:
    """Return the volume of all shapes that displace water and its first moment."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    total, moment = 0.0, np.zeros(3)
    for index in range(model.ngeom):
        name, size = model.geom(index).name, model.geom_size[index]
        if any(word in name for word in DRAWN):
            continue
        box = model.geom_type[index] == mujoco.mjtGeom.mjGEOM_BOX
        volume = 8 * math.prod(size) if box else math.pi * size[0] ** 2 * 2 * size[1]
        total += volume
        moment += volume * data.geom_xpos[index]
    return total, moment / total


@pytest.mark.parametrize(
    ("name", "density", "nose_down_deg"),
    [
        ("hexapod_swimmer", 1000.0, 0.0),
        ("hexapod_swimmer_salt", 1025.0, 0.0),
        ("hexapod_swimmer_ballast", 1000.0, 20.0),
    ],
)
def test_it_weighs_what_it_displaces_and_lies_as_it_should(
    name: str, density: float, nose_down_deg: float
) -> None:
    robot = load(name)
    model = spec_of(robot).compile()
    volume, centre = volumes(model)
    assert robot.card is not None
    assert robot.card.water is not None
    # The card's volume has nine digits after the point: 5e-10 m3.
    assert robot.card.water.displaced_volume_m3 == pytest.approx(volume, abs=1e-9)
    assert robot.mass == pytest.approx(density * volume, abs=1e-6 * density)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = model.body_mass[1:] @ data.xipos[1:] / robot.mass
    # At rest the centre of buoyancy is straight above that of mass. The ballast stands to
    # 0.1 mm, 1.5 micrometres of the whole robot's centre, against 0.8 mm from centre to centre.
    lean = math.degrees(math.atan2(mass[0] - centre[0], centre[2] - mass[2]))
    assert lean == pytest.approx(nose_down_deg, abs=0.15)
    assert mass[1] == pytest.approx(centre[1], abs=1e-9)


def test_the_paddles_of_one_side_never_meet() -> None:
    # Blades reach 0.168 m from hips 0.254 m apart, so only the middle one's own plane keeps
    # them clear: it stands 0.05 m further out, as much as a blade is wide.
    model = spec_of(load("hexapod_swimmer")).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for side in ("left", "right"):
        ends = abs(data.geom(f"{side}_front_paddle").xpos[1])
        middle = abs(data.geom(f"{side}_middle_paddle").xpos[1])
        assert middle - ends == pytest.approx(0.05, abs=1e-12)
