"""The knobs of the clock: play, step, scrub, speed, moments to jump to, and their keys."""

from __future__ import annotations

import time
from functools import partial
from typing import TYPE_CHECKING, Any

from morph.app.viewer.clock import SPEEDS
from morph.app.viewer.content import Content, Moment
from morph.app.viewer.motion import RATE
from morph.app.viewer.widget import add_widget, set_value

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

STEPS = {"-1 s": -1.0, "-1": -1.0 / RATE, "+1": 1.0 / RATE, "+1 s": 1.0}
"""The buttons that step, and by how much, s."""

KEYS: dict[str, tuple[str, str | None, str]] = {
    "play": ("space", None, "play or pause"),
    "-1": ("arrowleft", None, "one picture back"),
    "+1": ("arrowright", None, "one picture on"),
    "-1 s": ("arrowleft", "shift", "one second back"),
    "+1 s": ("arrowright", "shift", "one second on"),
    "start": ("home", None, "to the start"),
    "end": ("end", None, "to the end"),
    "slower": ("arrowdown", "shift", "slower"),
    "faster": ("arrowup", "shift", "faster"),
}
"""Keys by what they do: the key, what is held with it, and what the list of commands says."""

HAND = 0.5
"""The slider is left to the hand that moved it for so long, s."""

NOWHERE = "choose a moment"
"""What the choice of moments shows before one is chosen."""

MOST_MOMENTS = 200
"""Moments in the choice."""

LONGEST = 60
"""Characters of a moment's title there."""


class ClockControls:
    """The knobs of one session's clock; every method runs in the session's thread.

    Args:
        session: Whose clock.
    """

    def __init__(self, session: Session) -> None:
        """Add them to the page."""
        gui, self._session = session.client.gui, session
        add = partial(add_widget, session)
        self._touched = 0.0
        self._moments: tuple[Moment, ...] = ()
        self._play = add(
            gui.add_button,
            "Pause",
            icon="player-pause-filled",
            hint="space",
            then=lambda _: self.press("play"),
        )
        self._steps = add(
            gui.add_button_group,
            "step",
            tuple(STEPS),
            hint="A picture or a second: the arrow keys, with shift a second.",
            then=self.press,
        )
        self._slider = add(gui.add_slider, "time (s)", 0.0, 1.0, 1e-3, 0.0, then=self._scrub)
        speeds = tuple(f"{each:g}" for each in SPEEDS)
        self._speed = add(gui.add_dropdown, "speed", speeds, initial_value="1", then=self._hurry)
        self._goal = add(gui.add_dropdown, "go to", (NOWHERE,), visible=False, then=self._go)
        for what, (key, held, statement) in KEYS.items():
            press = partial(self._key, what)
            add(gui.add_command, statement, hotkey=key, modifier=held, then=press)

    def press(self, what: str) -> None:
        """Do what a key or a button says."""
        clock, self._touched = self._session.clock, 0.0
        if what == "play":
            clock.toggle()
        elif what in STEPS:
            clock.step(STEPS[what])
        elif what in ("start", "end"):
            clock.seek(0.0 if what == "start" else clock.seconds)
        else:
            at = SPEEDS.index(clock.speed) + (1 if what == "faster" else -1)
            clock.speed = SPEEDS[min(max(at, 0), len(SPEEDS) - 1)]
            set_value(self._speed, f"{clock.speed:g}")

    def show(self, content: Content) -> None:
        """Fit them to a content: its length and its moments; what stands has none of them."""
        clock = self._session.clock
        moves = clock.seconds > 0.0
        for knob in (self._play, self._steps, self._slider, self._speed):
            knob.visible = moves
        self._moments = content.moments[:MOST_MOMENTS] if moves else ()
        self._slider.max = max(clock.seconds, 1.0 / RATE)
        self._slider._marks = _marks(clock.seconds, self._moments)
        self._goal.visible = bool(self._moments)
        self._goal.options = (NOWHERE, *map(_named, range(1, 1 + MOST_MOMENTS), self._moments))
        self._goal.value = NOWHERE

    def tell(self) -> None:
        """Tell where the clock is."""
        clock = self._session.clock
        # What comes back late from here would pull the slider from under a moving hand.
        if time.monotonic() - self._touched > HAND:
            set_value(self._slider, round(clock.time, 3))
        label = "Pause" if clock.playing else "Play"
        if self._play.label != label:
            self._play.label = label
            self._play.icon = f"player-{label.lower()}-filled"

    def resume(self) -> None:
        """Show how fast the clock runs where something else than a hand said so."""
        set_value(self._speed, f"{self._session.clock.speed:g}")

    def _key(self, what: str, _: None) -> None:
        self.press(what)

    def _scrub(self, to: float) -> None:
        self._touched = time.monotonic()
        self._session.jump(float(to))

    def _hurry(self, speed: str) -> None:
        self._session.clock.speed = float(speed)

    def _go(self, goal: str) -> None:
        # What is shown may have changed since it was chosen.
        at = self._goal.options.index(goal) if goal in self._goal.options else 0
        if at > 0:
            self._touched = 0.0
            self._session.jump(self._moments[at - 1].time)


def _named(number: int, moment: Moment) -> str:
    """Return what the choice calls a moment; its number keeps the names apart."""
    title = moment.title if len(moment.title) <= LONGEST else f"{moment.title[: LONGEST - 1]}…"
    return f"{number}. {moment.time:.2f} s: {title}"


def _marks(seconds: float, moments: tuple[Moment, ...]) -> tuple[Any, ...]:
    """Return the marks of the slider: its ends with their numbers, and every moment."""
    from viser._messages import GuiSliderMark

    ends = (GuiSliderMark(0.0, "0"), GuiSliderMark(seconds, f"{seconds:.4g}"))
    inside = [each.time for each in moments if 0.0 <= each.time <= seconds]
    return (*ends, *(GuiSliderMark(at, None) for at in dict.fromkeys(inside)))
