"""A real Chromium that looks at the real viewer."""

from __future__ import annotations

import io
import os
import re
import shutil
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import makers
from morph.body.load import load

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = ("--no-sandbox", "--use-angle=gl-egl", "--ignore-gpu-blocklist")
"""With these WebGL is drawn without a graphics card and without a display."""

VIEWPORT: Any = {"width": 800, "height": 480}
"""As small as a page is that one still works with: the processor draws every pixel."""

UNHURRIED = """
(() => {
  const draw = window.requestAnimationFrame.bind(window), gone = new Set();
  window.requestAnimationFrame = (what) => {
    const number = setTimeout(() => draw((now) => gone.delete(number) || what(now)), 200);
    return number;
  };
  window.cancelAnimationFrame = (number) => (clearTimeout(number), gone.add(number));
})();
"""
"""Five pictures a second are as many as a test looks at, a twelfth of what a page would draw."""

PATIENCE = 60.0
"""s; a picture takes seconds where the processor draws it, and two tests may share it."""

HARMLESS = re.compile(
    r"THREE\.Clock|\[Performance\]|GPU stall due to ReadPixels|\(OK\) Tried to remove"
    r"|Tried to update non-existent component"
)
"""What viser's client and the browser say of themselves.

The client applies a picture's updates after its removals (`MessageHandler.tsx`): what was set and
then removed between two pictures of a slow page is said not to exist.
"""


def differs(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two pictures of the canvas differ by more than the edges of a line or two."""
    # Viser draws more coarsely while it is slow, which moves edges by a part of a pixel.
    far = np.abs(one.astype(int) - other.astype(int)).max(axis=2) > 40
    return bool(far.mean() > 5e-4)


def number_of_colours(picture: np.ndarray) -> int:
    """Return how many colours a picture has, uint8, shape (rows, columns, 3)."""
    # One number for each colour: rows of three are sorted fifty times as slowly.
    red, green, blue = np.moveaxis(picture.astype(np.uint32), -1, 0)
    return len(np.unique(red << 16 | green << 8 | blue))


class Look:
    """One person at one page."""

    def __init__(self, page: Any, last: Path) -> None:
        self.page = page
        self.last = last
        """Where the last picture is left when something does not come."""
        self.canvas = page.locator("canvas").first
        """What is looked at."""
        self.said: list[str] = []
        """All that the console said."""
        self.wrong: list[str] = []
        """Errors of it, and of scripts."""
        self.requests: list[str] = []
        """Addresses that the page asked for."""
        page.on("console", self._hears)
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("websocket", lambda socket: self.requests.append(socket.url))

    def until(self, holds: Callable[[], Any], what: str) -> Any:
        """Wait until something holds, and return it."""
        end = time.monotonic() + PATIENCE
        while not (found := holds()):
            if time.monotonic() > end:
                self.page.screenshot(path=self.last)
                pytest.fail(
                    f"after {PATIENCE:.0f} s still not: {what}; {self.wrong}; see {self.last}"
                )
            self.page.wait_for_timeout(50)
        return found

    def picture(self) -> np.ndarray:
        """What the canvas shows, uint8, shape (rows, columns, 3), without panel and messages."""
        from PIL import Image

        box = self.canvas.bounding_box()
        # The top holds the messages of viser, the lower edge its buttons.
        clip = {
            "x": box["x"],
            "y": box["y"] + 0.15 * box["height"],
            "width": box["width"],
            "height": 0.75 * box["height"],
        }
        shot = self.page.screenshot(clip=clip)
        return np.array(Image.open(io.BytesIO(shot)).convert("RGB"))

    def changes(self, since: np.ndarray) -> bool:
        """Whether the canvas shows something else than in an earlier picture."""
        return differs(since, self.picture())

    def settled(self) -> np.ndarray:
        """The picture of a scene in which nothing moves any more."""
        last = self.picture()
        end = time.monotonic() + PATIENCE
        while differs(last, now := self.picture()):
            if time.monotonic() > end:
                self.page.screenshot(path=self.last)
                pytest.fail(f"the picture never comes to rest; {self.wrong}; see {self.last}")
            last = now
        return now

    def point(self) -> None:
        """Click on the canvas, so that keys go to the page and to no control of its panel."""
        box = self.canvas.bounding_box()
        self.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])

    def colours(self) -> int:
        """How many colours the canvas has."""
        return number_of_colours(self.picture())

    def text(self) -> str:
        """All the text that is to be read."""
        return str(self.page.inner_text("body"))

    def press(self, name: str) -> None:
        """Press the button of this name."""
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def _hears(self, message: Any) -> None:
        self.said.append(message.text)
        if message.type in ("error", "warning") and not HARMLESS.search(message.text):
            self.wrong.append(message.text)


@pytest.fixture(scope="session")
def chromium() -> str:
    """The browser's command; CI must have it, elsewhere its tests are skipped."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    reason = f"there is no browser ({', '.join(NAMES)}); `make test` installs one as root"
    if os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)


RUNNING = pytest.StashKey[tuple[Any, Any]]()
"""The browser that runs, and playwright, which drives it."""


@pytest.fixture
def browser(request: pytest.FixtureRequest, chromium: str) -> Any:
    """A running browser, one for all tests of this folder; each has pages of its own in it."""
    stash = request.session.stash
    if RUNNING not in stash:
        from playwright.sync_api import sync_playwright

        play = sync_playwright().start()
        stash[RUNNING] = play.chromium.launch(executable_path=chromium, args=list(FLAGS)), play
    return stash[RUNNING][0]


# While playwright runs in a thread, nothing else there can run an event loop: tests elsewhere may.
@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """End the browser after the last test in a row that looks with it."""
    try:
        return (yield)
    finally:
        stays = nextitem is not None and nextitem.path.is_relative_to(Path(__file__).parent)
        if RUNNING in item.session.stash and not stays:
            running, play = item.session.stash[RUNNING]
            del item.session.stash[RUNNING]
            running.close()
            play.stop()


@pytest.fixture
def blank(browser: Any, tmp_path: Path) -> Iterator[Callable[..., Look]]:
    """Makes a person with an empty page; what went wrong on a page fails the test."""
    people: list[tuple[Any, Look]] = []

    def made(*, hurried: bool = False, viewport: Any = VIEWPORT, **how: Any) -> Look:
        context = browser.new_context(viewport=viewport, accept_downloads=True, **how)
        if not hurried:
            context.add_init_script(UNHURRIED)
        page = context.new_page()
        page.set_default_timeout(1e3 * PATIENCE)
        people.append((context, Look(page, tmp_path / f"last_{len(people)}.png")))
        return people[-1][1]

    yield made
    wrong = [each for _, person in people for each in person.wrong]
    for context, _ in people:
        context.close()
    assert wrong == []


@pytest.fixture
def look(blank: Callable[..., Look]) -> Callable[[str], Look]:
    """Opens a page of the viewer, and waits until its canvas shows something."""

    def opened(address: str) -> Look:
        person = blank()
        person.page.goto(address)
        person.until(lambda: person.page.locator("canvas").count(), "there is a canvas")
        person.until(
            lambda: person.page.get_by_role("slider").count(), "the controls of the clock are there"
        )
        person.until(lambda: person.colours() > 200, "the canvas shows something")
        # Viser warns where the processor draws; that would lie over what is looked at.
        for close in person.page.locator(".mantine-Notification-closeButton").all():
            close.click()
        return person

    return opened


def free_port() -> int:
    """Return a port that nobody has."""
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        return int(asked.getsockname()[1])


@pytest.fixture
def served(caplog: pytest.LogCaptureFixture) -> Iterator[Callable[..., Viewer]]:
    """Serves views: those given, or what `morph view` would show of bodies."""
    viewers: list[Viewer] = []

    def opened(
        *names: str,
        views: Callable[[], Sequence[View]] | None = None,
        first: str | None = None,
        **given: Any,
    ) -> Viewer:
        begin = 0
        if views is None:
            robots = tuple(load(name) for name in names)
            found, begin = makers(ViewRequest(robots=robots, asked=names, **given), first)
            views = lambda: [make() for make in found]  # noqa: E731
        viewers.append(Viewer(views, first=begin, port=free_port()))
        return viewers[-1]

    yield opened
    for viewer in viewers:
        viewer.close()
    # A session outlives its faults and only logs them.
    records = caplog.get_records("call")
    assert [each.exc_text or each.message for each in records if each.levelname == "ERROR"] == []


@pytest.fixture(scope="session")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What all views together need, made by the commands that people give."""
    folder = tmp_path_factory.mktemp("inputs")
    aligned, run = folder / "aligned", folder / "run.parquet"
    assert main(["align", "cartpole", "rider_rigid_driven", "--out", str(aligned), "--quiet"]) == 0
    swings = ["simulate", "pendulum", "--start", "hinge=0.5", "--seconds", "3", "--out", str(run)]
    assert main(swings) == 0
    return {"transfer": aligned, "recordings": (run,)}
