"""The figures of the viewer, small; what needs a browser is tested with the viewer itself."""

from __future__ import annotations

import io
import json
from typing import ClassVar

import numpy as np
import pytest
from PIL import Image

from experiments import bench_viewer
from experiments.pictures import WIDE, film, small
from experiments.viewed.browser import free_port
from experiments.viewed.leaks import slope
from experiments.viewed.listener import listened
from experiments.viewed.served import serving
from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import posed
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.body.load import load
from morph.errors import OutputError


def test_a_leak_is_seen_and_a_pool_that_fills_is_not() -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(0.0, 0.1, 100)
    # 0.2 MB a page; the slope of 50 points has a spread of 0.1 sqrt(12 / 50^3) = 0.001 MB.
    leaking = 200.0 + 0.2 * np.arange(100) + noise
    assert slope(list(leaking)) == pytest.approx(0.2, abs=0.005)
    filling = 200.0 + 20.0 * (1.0 - np.exp(-np.arange(100) / 8.0)) + noise
    # After fifty pages 20 exp(-50 / 8) = 0.04 MB of it are still to come.
    assert slope(list(filling)) == pytest.approx(0.0, abs=0.006)


def test_what_is_sent_is_counted_from_the_command_on(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench_viewer, "bodies", lambda quick: ("pendulum",))
    assert bench_viewer.main(["--quick", "--only", "sent", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["sent"]
    assert 0.0 < found["told_s"] < found["sent_s"]
    assert found["shapes"] >= 1
    assert found["sent_mb"] > 1e-3


class Standing(View):
    """Bodies that stand still, and nothing that comes later."""

    name: ClassVar[str] = "standing"
    title: ClassVar[str] = "Standing"

    def __init__(self, actors: tuple[Actor, ...]) -> None:
        self._actors = actors

    def content(self) -> Content:
        return Content(actors=self._actors)


def test_two_bodies_are_two_bodies_shapes() -> None:
    drawn, shapes = figure(load("pendulum")), []
    actor = Actor(figure=drawn, motion=posed(drawn.model, drawn.model.qpos0[None]))
    for actors in ((actor,), (actor, actor)):
        viewer = Viewer(lambda actors=actors: [Standing(actors)], port=free_port())
        try:
            shapes.append(listened(viewer.address, quiet=0.5).shapes)
        finally:
            viewer.close()
    assert shapes[1] == 2 * shapes[0] > 0


def test_a_command_that_serves_nothing_is_told() -> None:
    with pytest.raises(OutputError, match=r"no_such_body"), serving("no_such_body"):
        pass


def test_a_picture_is_small_and_has_its_colours() -> None:
    rng = np.random.default_rng(0)
    noisy = np.kron(rng.integers(0, 256, (60, 100, 3), dtype=np.uint8), np.ones((8, 8, 1)))
    noisy[:80, :80] = (200, 30, 20)
    png = io.BytesIO()
    Image.fromarray(noisy.astype(np.uint8)).save(png, "PNG")
    packed = small(png.getvalue(), 150_000)
    assert len(packed) <= 150_000
    with Image.open(io.BytesIO(packed)) as read:
        assert read.size == (800, 480)
        middle = np.array(read)[20:60, 20:60].mean(axis=(0, 1))
    # A JPEG keeps the mean of a plain patch within a step or two of 255.
    assert np.abs(middle - (200, 30, 20)).max() < 4
    with pytest.raises(OutputError, match=r"more than 1000 bytes"):
        small(png.getvalue(), 1000)


def test_a_film_has_its_pictures_in_order_and_begins_anew() -> None:
    shots = []
    for level in (0, 100, 200):
        held = io.BytesIO()
        Image.fromarray(np.full((90, 160, 3), level, dtype=np.uint8)).save(held, "PNG")
        shots.append(held.getvalue())
    with Image.open(io.BytesIO(film(shots))) as made:
        assert (made.n_frames, made.size, made.info["loop"]) == (3, (WIDE, WIDE * 90 // 160), 0)
        for at, level in enumerate((0, 100, 200)):
            made.seek(at)
            # Lossy: a level of plain grey comes back within a few.
            assert np.asarray(made.convert("L")).mean() == pytest.approx(level, abs=5)
    with pytest.raises(OutputError, match="a film has more than 10 bytes"):
        film(shots, most=10)
