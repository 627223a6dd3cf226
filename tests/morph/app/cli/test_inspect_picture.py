"""Pictures of `morph inspect`: which pose they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tyro

from morph.app.cli.arguments import Inspect
from morph.app.cli.inspect import run_inspect
from morph.app.cli.main import main
from morph.arrays import Array
from morph.body.load import load
from morph.body.postures import postured
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MorphError


def test_a_picture_is_drawn_in_the_posture_that_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Array] = []

    def draw(robot: Robot, effects: object, position: Array, path: Path) -> None:
        drawn.append(position)

    monkeypatch.setattr("morph.app.picture.video.picture", draw)
    file = str(tmp_path / "biped.png")
    for posture in ((), ("--posture", "standing"), ("--posture", "rest")):
        assert main(["inspect", "biped", "--picture", file, *posture]) == 0
    ready, standing, rest = drawn
    np.testing.assert_array_equal(rest, spec_of(load("biped")).compile().qpos0)
    # It has no keyframe, and therefore starts on its feet, on bent legs.
    np.testing.assert_array_equal(ready, standing)
    knees = postured(load("biped"), "standing").posture
    assert knees is not None
    assert sorted(np.abs(standing - rest)[7:])[-1] == max(
        abs(value) for name, value in knees.items() if "." not in name
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--posture", "rest"), "there is no picture to draw in it"),
        (("--picture", "biped.bmp"), "does not say which kind of file"),
        (("--picture", "biped.png", "--posture", "resting"), "no posture 'resting'"),
    ],
)
def test_a_picture_that_cannot_be_drawn_is_refused_before(
    options: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MorphError, match=message):
        run_inspect(tyro.cli(Inspect, args=["biped", *options]))
    assert list(tmp_path.iterdir()) == []
