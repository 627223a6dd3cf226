"""Bodies that fall, slide, roll and stand."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.body.load import load
from morph.body.robot import Robot

Made = Callable[..., Robot]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A robot from what stands in its `worldbody`."""

    def make(inside: str, rest: str = "") -> Robot:
        path = tmp_path_factory.mktemp("made") / "made.xml"
        path.write_text(f'<mujoco model="made"><worldbody>{inside}</worldbody>{rest}</mujoco>')
        return load(path)

    return make


@pytest.fixture(scope="module")
def block(made: Made) -> Robot:
    """A flat box of 1 kg, 0.2 x 0.2 x 0.1 m, that stands on z = 0."""
    return made(
        '<body name="block" pos="0 0 0.05"><freejoint/>'
        '<geom type="box" size="0.1 0.1 0.05" mass="1"/></body>'
    )


@pytest.fixture(scope="module")
def ball(made: Made) -> Robot:
    """A ball of 1 kg with a radius of 0.05 m that touches z = 0."""
    return made('<body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05" mass="1"/></body>')
