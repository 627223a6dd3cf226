from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image

from morph.app.picture import video
from morph.app.picture.canvas import canvas
from morph.app.picture.scene import scene_model
from morph.app.picture.video import film, picture
from morph.body.load import load
from morph.errors import OutputError
from morph.sim.simulator import Simulator, Trajectory


@pytest.fixture(autouse=True, scope="module")
def screenless() -> None:
    try:
        with canvas(scene_model(load("pendulum"), (), (32, 18)), (32, 18)):
            pass
    except OutputError as error:
        pytest.skip(error.what)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(video, "FILMS", {".mp4": (10.0, (160, 96)), ".gif": (10.0, (160, 96))})


@pytest.fixture(scope="module")
def swing() -> Trajectory:
    return Simulator(load("pendulum")).trajectory(seconds=0.5, start={"hinge": 1.2})


def orange(seen: Any) -> Any:
    """Return the middle, in columns and rows, of what is orange: the pendulum's bob."""
    red, green, blue = (seen[..., at].astype(int) for at in range(3))
    rows, columns = np.nonzero((red > 150) & (green < 0.75 * red) & (blue < 0.5 * red))
    return np.array([columns.mean(), rows.mean()])


@pytest.mark.usefixtures("small")
def test_a_gif_shows_the_motion_in_real_time(swing: Trajectory, tmp_path: Path) -> None:
    shares: list[float] = []
    path = film(
        load("pendulum"), (), swing.time, swing.position, tmp_path / "a.gif", progress=shares.append
    )
    with Image.open(path) as image:
        assert (image.n_frames, image.size) == (6, (160, 96))
        assert image.info["duration"] == 100
        middles = []
        for at in range(6):
            image.seek(at)
            middles.append(orange(np.asarray(image.convert("RGB"))))
    # From 1.2 rad it swings down and back: each picture further to the left than the last.
    assert (np.diff([middle[0] for middle in middles]) < 0).all()
    assert shares == pytest.approx(np.arange(1, 7) / 6)
    assert list(tmp_path.iterdir()) == [path]


def test_a_picture_shows_the_pose_that_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(video, "PICTURES", {".png": (160, 96)})
    middles = []
    for angle in (-0.8, 0.8):
        path = picture(load("pendulum"), (), np.array([angle]), tmp_path / "a.png")
        with Image.open(path) as image:
            assert (image.format, image.size) == ("PNG", (160, 96))
            middles.append(orange(np.asarray(image.convert("RGB"))))
    # As in the film, what has swung further stands further to the right.
    assert middles[1][0] > middles[0][0] + 10
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.usefixtures("small")
def test_an_mp4_holds_every_picture(swing: Trajectory, tmp_path: Path) -> None:
    path = film(load("pendulum"), (), swing.time, swing.position, tmp_path / "a.mp4")
    decoded = subprocess.run(
        [get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    )
    assert b" 160x96" in decoded.stderr
    assert b" 10 fps" in decoded.stderr
    pictures = np.frombuffer(decoded.stdout, dtype=np.uint8).reshape(-1, 96, 160, 3)
    assert len(pictures) == 6
    assert (np.diff([orange(picture)[0] for picture in pictures]) < 0).all()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.usefixtures("small")
def test_what_the_encoder_refuses_is_said_and_leaves_nothing(
    swing: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.app.picture.encode.QUALITY", ("-c:v", "no_such"))
    with pytest.raises(OutputError, match=r"ffmpeg cannot write the film: .*ncoder") as caught:
        film(load("pendulum"), (), swing.time, swing.position, tmp_path / "a.mp4")
    assert ".gif" in caught.value.fix
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("name", ["a.gif", "a.mp4"])
def test_an_interrupted_film_leaves_the_old_one(
    name: str, swing: Trajectory, tmp_path: Path
) -> None:
    def interrupt(share: float) -> None:
        if share > 0.4:
            raise KeyboardInterrupt

    (tmp_path / name).write_text("old")
    with pytest.raises(KeyboardInterrupt):
        film(load("pendulum"), (), swing.time, swing.position, tmp_path / name, progress=interrupt)
    assert (tmp_path / name).read_text() == "old"
    assert list(tmp_path.iterdir()) == [tmp_path / name]


def test_no_opengl_is_said_with_what_to_install(
    swing: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.app.picture.canvas._backends", lambda: ("nowhere",))
    with pytest.raises(OutputError, match="there is no OpenGL to draw with") as caught:
        film(load("pendulum"), (), swing.time, swing.position, tmp_path / "a.gif")
    assert "libegl1" in caught.value.fix
    assert list(tmp_path.iterdir()) == []


def test_an_opengl_that_wants_a_screen_is_no_traceback_where_there_is_none(
    swing: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    # glfw only warns; what fails is the buffer that is made without a context.
    monkeypatch.setattr("morph.app.picture.canvas._backends", lambda: ("glfw",))
    with pytest.raises(OutputError, match=r"there is no OpenGL to draw with \(glfw: "):
        film(load("pendulum"), (), swing.time, swing.position, tmp_path / "a.gif")
