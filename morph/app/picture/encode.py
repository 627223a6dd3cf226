"""Pictures one after the other as a file: MP4 by ffmpeg, GIF by pillow."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from morph.app.picture.canvas import Picture
from morph.errors import OutputError

QUALITY = ("-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p")
"""H.264 as every browser and every program for slides plays it."""


def mp4(path: Path, pictures: Iterator[Picture], rate: float, size: tuple[int, int]) -> None:
    """Write pictures as an MP4.

    Args:
        path: Where to.
        pictures: One after the other; each may be written over once the next is asked for.
        rate: Pictures a second.
        size: Their width and height, even numbers.

    Raises:
        OutputError: ffmpeg cannot write it.
    """
    from imageio_ffmpeg import get_ffmpeg_exe

    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{rate:g}")
    command = [get_ffmpeg_exe(), "-y", "-loglevel", "error", *raw, "-i", "-", "-an", *QUALITY]
    # With its index in front a film begins to play before all of it is there.
    command += ["-movflags", "+faststart", str(path.absolute())]
    with (
        tempfile.TemporaryFile() as statement,
        subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=statement
        ) as process,
    ):
        if process.stdin is None:
            raise _failed("it takes no pictures")
        try:
            for picture in pictures:
                process.stdin.write(np.ascontiguousarray(picture).data)
            process.stdin.close()
        except BrokenPipeError:
            # It ended before us, and has said why.
            process.wait()
        except BaseException:
            process.kill()
            raise
        if process.wait() != 0:
            statement.seek(0)
            lines = statement.read().decode(errors="replace").strip().splitlines()
            raise _failed(lines[-1] if lines else f"exit status {process.returncode}")


def _failed(why: str) -> OutputError:
    return OutputError(
        f"ffmpeg cannot write the film: {why}",
        where="--video",
        fix="choose a folder that can be written to and has room, or write a .gif",
    )


def gif(path: Path, pictures: Iterator[Picture], rate: float, size: tuple[int, int]) -> None:
    """Write pictures as a GIF that begins again at its end; see `mp4`."""
    from PIL import Image

    images = [Image.fromarray(np.ascontiguousarray(picture)) for picture in pictures]
    # One palette for all pictures, from the middle one: colours do not flicker, files stay small.
    palette = images[len(images) // 2].quantize(colors=256)
    small = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    small[0].save(
        path, save_all=True, append_images=small[1:], duration=round(1000.0 / rate), loop=0
    )
