"""Pictures of the viewer for the pages of the documentation, from the real viewer in a browser.

Each shows what `morph view` shows of the words beside it; the commands that make what it reads
run first. `python -m experiments.pictures --out docs/pictures` makes those of the README.
"""

from __future__ import annotations

import argparse
import io
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.viewed.browser import browsing, first_frame, page_of
from experiments.viewed.served import serving
from morph.errors import MorphError, OutputError
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.pictures --out docs/pictures
  python -m experiments.pictures --out out/pictures --only compare"""

MORPH = (sys.executable, "-c", "from morph.app.cli.main import entry; entry()")

MOST_BYTES = 150_000
"""Of one picture: a page with four of them still opens at once."""
MOST_FILM, WIDE, RATE = 900_000, 840, 12.0
"""Bytes of a film, its width, and its pictures a second."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """One view, and the moment at which it is taken."""

    name: str
    """Of its file."""
    words: str
    """What `morph view` is told; `{folder}` is where the commands before wrote."""
    before: tuple[str, ...] = ()
    """What `morph` is told before."""
    wait: float = 6.0
    """How long it plays before it is taken, s: policies are found and simulations made."""
    keys: tuple[str, ...] = ()
    """What is pressed then on the keyboard, such as to go to a moment."""
    frames: int = 0
    """Pictures of a film from there on, `stride` steps of the player apart; 0: there is none."""
    stride: int = 4
    """Steps of the player between two pictures of the film."""


PICTURES = (
    Picture(
        name="compare",
        words="cartpole rider_rigid_driven cart_two_links --task balance --policy learned",
        wait=10.0,
        # Early on they are still being caught, and one sees what the motors do.
        keys=("Home", *("ArrowRight",) * 9),
        frames=30,
        stride=2,
    ),
    Picture(name="design", words="quadruped_printed --first design"),
    Picture(
        name="align",
        before=(
            "transfer --from learned --chain cartpole rider_rigid_driven rider_three_links_driven "
            "--out {folder}/chain --quiet",
        ),
        words="--transfer {folder}/chain",
        wait=10.0,
    ),
    Picture(
        name="mismatch",
        before=(
            "simulate double_pendulum --effect coulomb_friction@elbow:c=0.1 --start shoulder=1.0 "
            "--seconds 10 --out {folder}/run.parquet",
        ),
        words="double_pendulum --recording {folder}/run.parquet",
        wait=10.0,
        # A stretch in which the ghost has left the recording.
        keys=("Home", *("Shift+ArrowRight",) * 4, *("ArrowRight",) * 48),
        frames=36,
    ),
    Picture(
        name="print",
        before=(
            "print so101 --printer mk4 --material pla --slicer none --out {folder}/package --quiet",
        ),
        words="--package {folder}/package",
        # The body is apart at two seconds.
        keys=("Home", *("Shift+ArrowRight",) * 2),
    ),
)
"""Every picture, in the order of the views."""


def taken(browser: Any, picture: Picture, folder: Path) -> list[bytes]:
    """Return what the screen shows, as PNG, and then the pictures of the film.

    Raises:
        MorphError: A command failed, or nothing is shown.
    """
    for words in picture.before:
        _command(words.format(folder=folder))
    told = shlex.split(picture.words.format(folder=folder))
    with serving(*told) as served, page_of(browser) as page:
        first_frame(page, served.address)
        page.wait_for_timeout(1e3 * picture.wait)
        for busy in ("looking for a policy", "simulating ..."):
            page.get_by_text(busy).first.wait_for(state="detached", timeout=6e5)
        for each in page.locator(".mantine-Notification-closeButton").all():
            each.click()
        # A pause lets the last frame come; a view without a motion has none.
        if (pause := page.get_by_role("button", name="Pause")).count():
            pause.first.click()
        for key in picture.keys:
            page.keyboard.press(key)
        page.wait_for_timeout(2500)
        shots = [bytes(page.screenshot())]
        for _ in range(picture.frames):
            for _ in range(picture.stride):
                page.keyboard.press("ArrowRight")
            page.wait_for_timeout(700)
            shots.append(bytes(page.screenshot()))
        return shots


def _command(words: str) -> None:
    ran = subprocess.run([*MORPH, *shlex.split(words)], capture_output=True, text=True, check=False)
    # 3: it stopped short or found no gain, and wrote what there is.
    if ran.returncode not in {0, 3}:
        raise OutputError(
            f"exit status {ran.returncode}: {ran.stderr.strip()}",
            where=f"morph {words}",
            fix="give the command by hand",
        )


def small(screen: bytes, most: int = MOST_BYTES) -> bytes:
    """Return a JPEG of at most so many bytes, as good as that allows.

    Raises:
        OutputError: It does not fit without being spoilt.
    """
    from PIL import Image

    with Image.open(io.BytesIO(screen)) as opened:
        whole = opened.convert("RGB")
    for quality in (92, 88, 84, 80, 75, 70):
        packed = io.BytesIO()
        # Coloured lines of a point's width stay sharp only if colours are not thinned out.
        whole.save(packed, "JPEG", quality=quality, subsampling=0, optimize=True)
        if len(packed.getvalue()) <= most:
            return packed.getvalue()
    raise OutputError(
        f"a picture has more than {most} bytes",
        where="experiments.pictures",
        fix="show less in it",
    )


def film(shots: Sequence[bytes], most: int = MOST_FILM) -> bytes:
    """Return pictures as an animated WebP of at most so many bytes, which begins anew at its end.

    Raises:
        OutputError: It does not fit without being spoilt.
    """
    from PIL import Image

    frames = []
    for shot in shots:
        with Image.open(io.BytesIO(shot)) as opened:
            tall = round(WIDE * opened.height / opened.width)
            frames.append(opened.convert("RGB").resize((WIDE, tall), Image.Resampling.LANCZOS))
    for quality in (80, 70, 60, 50):
        packed = io.BytesIO()
        frames[0].save(
            packed, "WEBP", save_all=True, append_images=frames[1:], duration=round(1e3 / RATE),
            loop=0, quality=quality, method=6,
        )  # fmt: skip
        if len(packed.getvalue()) <= most:
            return packed.getvalue()
    raise OutputError(
        f"a film has more than {most} bytes", where="experiments.pictures", fix="show less of it"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures and return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.pictures",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="where to")
    known = tuple(picture.name for picture in PICTURES)
    parser.add_argument("--only", nargs="+", choices=known, help="these alone")
    asked = parser.parse_args(arguments)
    try:
        with browsing() as browser:
            for picture in PICTURES:
                if picture.name not in (asked.only or known):
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    shots = taken(browser, picture, Path(folder))
                asked.out.mkdir(parents=True, exist_ok=True)
                made = {"jpg": small(shots[0])} | ({"webp": film(shots)} if shots[1:] else {})
                for ending, content in made.items():
                    path = write_whole(asked.out / f"{picture.name}.{ending}", content)
                    print(f"{path}: {len(content)} bytes; morph view {picture.words}")
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
