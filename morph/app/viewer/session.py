"""One person's page: a clock, a stage and views of their own, run in one thread."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

from morph.app.viewer.clock import PlaybackClock
from morph.app.viewer.content import Content
from morph.app.viewer.controls import Controls
from morph.app.viewer.motion import RATE
from morph.app.viewer.opening import Opening
from morph.app.viewer.stage import Stage
from morph.app.viewer.view import View
from morph.errors import MorphError

LOG = logging.getLogger(__name__)

Found = TypeVar("Found")

LATE = 3e-4
"""How long after a picture is due the session wakes, s: rounding must not make it wake before."""

SLOW = 0.1
"""Numbers and tables are told every so many seconds: nobody reads faster."""

NOTICED, READ = 3.0, 15.0
"""A message is noticed within so many seconds, and so many of its characters are read in one."""

AGAIN = 1.0
"""The same fault is told again after so many seconds."""


class Session:
    """What one person sees and does.

    Everything happens in the session's thread; what viser calls from other threads only asks
    for it by `do`. So two people never wait for each other, nor share a clock.

    Args:
        client: The `viser.ClientHandle`.
        views: This person's views.
        first: Which of them is shown first.
        opening: With what it begins.
    """

    def __init__(
        self,
        client: Any,
        views: Sequence[View],
        first: int = 0,
        opening: Opening | None = None,
    ) -> None:
        """Prepare; `start` begins."""
        self.client, self.views = client, tuple(views)
        self.opening = opening or Opening()
        self.clock, self.stage = PlaybackClock(), Stage(client.scene)
        self.view, self.content = self.views[first], Content(actors=())
        self.keeping = False
        """Whether a page is being made for this person to keep."""
        self._asked: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._over = threading.Event()
        self._controls = Controls(self)
        self._aimed = False
        self._shown, self._told, self._wrong = -1, 0.0, ("", 0.0)
        self._thread = threading.Thread(target=self._run, name="morph-session", daemon=True)

    def start(self) -> None:
        """Begin to show."""
        self._thread.start()

    def close(self) -> None:
        """End; the page is gone. What is still being computed for it is not shown."""
        self._over.set()

    def join(self, seconds: float) -> None:
        """Wait until nothing of it runs any more, at most so many seconds."""
        if self._thread.is_alive():
            self._thread.join(seconds)

    @property
    def over(self) -> bool:
        """Whether the page is gone; long work may ask, and stop."""
        return self._over.is_set()

    def do(self, what: Callable[[], None]) -> None:
        """Have something done in the session's thread, soon; may be called from any."""
        self._asked.put(what)

    def later(self, work: Callable[[], Found], then: Callable[[Found], None]) -> None:
        """Have something long done beside the session, and what comes of it in its thread.

        What goes wrong is told on the page.
        """

        def run() -> None:
            try:
                result = work()
            except Exception as error:
                self.do(partial(self._tell, error))
                return
            self.do(lambda: then(result))

        threading.Thread(target=run, name="morph-work", daemon=True).start()

    def show(self, content: Content | None = None, *, still: bool = False) -> None:
        """Show something else, by default what the view has now; the clock goes on.

        Args:
            content: What is shown.
            still: Whether the first actor stays where it stands.
        """
        self.content = self.view.content() if content is None else content
        with self.client.atomic():
            self.stage.show(self.content, still=still)
            self.clock.lasts(self.content.seconds)
            self.stage.pose(self.clock.time)
            self._controls.show()
        if not self._aimed:
            self.stage.aim(self.client.camera)
            self._aimed = True

    def turn_to(self, view: View) -> None:
        """Show another view, with its controls."""
        self.view, self._aimed = view, False
        # A view that wants to know what is clicked says so in its panel.
        self.stage.picked = None
        self._controls.open_view()
        self.clock.seek(0.0)
        self.show()

    def jump(self, to: float) -> None:
        """Pause at a time, s."""
        self.clock.playing = False
        self.clock.seek(to)

    def say(self, text: str, *, bad: bool = False) -> None:
        """Show a message until it is read; it is plain text."""
        self.client.add_notification(
            "That did not work" if bad else "morph",
            text,
            color="red" if bad else "blue",
            # Left to themselves messages stay for good, and pile up over the bodies.
            auto_close_seconds=(2.0 if bad else 1.0) * (NOTICED + len(text) / READ),
        )

    def _restore(self) -> None:
        """Have each view choose what was saved; what does not fit keeps no other from it."""
        saved = self.opening.saved
        for view in self.views:
            if saved is not None and view.name in saved.views:
                self._safely(partial(view.restore, saved.views[view.name]))

    def _resume(self) -> None:
        """Go on from where somebody was."""
        saved, clock = self.opening.saved, self.clock
        if saved is None:
            return
        clock.looping, clock.speed, clock.playing = saved.repeat, saved.speed, saved.playing
        clock.seek(saved.time)
        stage = self.stage
        stage.following = saved.follow
        stage.shown_arrows = (stage.shown_arrows | stage.hidden_arrows) - set(saved.hidden)
        if saved.camera is not None:
            saved.camera.turn(self.client.camera)
        self._controls.resume()

    def _run(self) -> None:
        self._safely(self._controls.build)
        self._restore()
        self._safely(partial(self.turn_to, self.view))
        self._safely(self._resume)
        before = time.monotonic()
        while not self._over.is_set():
            now = time.monotonic()
            self.clock.tick(now - before)
            before = now
            self._answer()
            if not self._safely(partial(self._picture, now)):
                # Whoever looks decides whether to try again; it must not fail 60 times a second.
                self.clock.playing = self._controls.stale = False
            # Just after the next picture is due: to wake at a rate of one's own would miss some.
            time.sleep(max(0.0, self.clock.due(RATE) + LATE - (time.monotonic() - now)))

    def _picture(self, now: float) -> None:
        """Show where the clock is, unless it is shown already."""
        self.stage.refit(self.client.camera)
        picture = int(self.clock.time * RATE + 1e-6)
        # A change of content, a switch or a hand on the slider shows the same picture anew.
        if picture == self._shown and not self._controls.stale:
            return
        self._shown = picture
        with self.client.atomic():
            self.stage.pose(self.clock.time)
        if now - self._told >= SLOW or not self.clock.playing:
            # Not before: what changed since the last telling would never be told.
            self._told, self._controls.stale = now, False
            self._controls.tell()
            self.view.picture(self.clock.time)

    def _answer(self) -> None:
        while not self._over.is_set():
            try:
                requested = self._asked.get_nowait()
            except queue.Empty:
                return
            # What is asked for is sent when all of it is done.
            with self.client.atomic():
                self._safely(requested)
            self._controls.stale = True

    def _safely(self, what: Callable[[], None]) -> bool:
        """Do something and return whether it could be done; if not, it is told on the page.

        A fault of the viewer's own must end neither the page nor those of other people.
        """
        try:
            what()
        except Exception as error:
            if not self._over.is_set():
                self._tell(error)
            return False
        return True

    def _tell(self, error: Exception) -> None:
        """Tell what went wrong, once: what fails with every picture is not news each time."""
        now, what = time.monotonic(), f"{type(error).__name__}: {error}"
        if what == self._wrong[0] and now - self._wrong[1] < AGAIN:
            return
        self._wrong = what, now
        if isinstance(error, MorphError):
            self.say(f"{error.where}: {error.what}. {error.fix}", bad=True)
            return
        LOG.error("a page could not be shown as asked", exc_info=error)
        self.say(
            f"The viewer itself failed at this ({type(error).__name__}: {error}). What is shown "
            "may lack something; load the page again if it does. Where morph was started stands "
            "what went wrong.",
            bad=True,
        )
