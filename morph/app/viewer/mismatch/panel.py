"""The knobs of the view: which recording, how it is simulated, and what was found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING, Any

from morph.app.viewer.mismatch.choices import BOTH, MismatchChoices
from morph.app.viewer.mismatch.diagnosed import DiagnosedFinding
from morph.app.viewer.mismatch.missing import link_of
from morph.app.viewer.mismatch.window import MismatchModel
from morph.app.viewer.mismatch.window_content import COLOURINGS
from morph.app.viewer.widget import add_widget, set_value

if TYPE_CHECKING:
    from morph.app.viewer.mismatch.case import MismatchCase
    from morph.app.viewer.session import Session
    from morph.app.viewer.views.mismatch import Mismatch

OPEN_LOOP = "open loop"
"""A simulation that is never restarted."""


class MismatchPanel:
    """The knobs of one person's page; what they do, they do in the session's thread.

    Args:
        view: What they choose for.
        gui: The page's `viser.GuiApi`.
        session: The page.
    """

    def __init__(self, view: Mismatch, gui: Any, session: Session) -> None:
        """Add them."""
        self._view, self._session = view, session
        gui.add_html(_legend(view.case.models))
        case, chosen = view.case, view.chosen
        self._recordings = _distinct(
            [recording.name + _unseen(case, at) for at, recording in enumerate(case.recordings)]
        )
        self._recording = self._list(
            gui, "recording", self._recordings, chosen.ask.episode, self._to_recording
        )
        self._window = self._list(
            gui, "window", self._windows(), chosen.ask.window, self._to_window
        )
        self._window.visible = len(self._windows()) > 1
        self._ways: dict[str, float | None] = {
            f"restarted every {case.horizon:g} s": case.horizon,
            OPEN_LOOP: None,
        }
        if chosen.ask.horizon not in self._ways.values():
            self._ways[f"restarted every {chosen.ask.horizon:g} s"] = chosen.ask.horizon
        ways = list(self._ways)
        way = list(self._ways.values()).index(chosen.ask.horizon)
        self._list(gui, "simulation", ways, way, self._to_way)
        if len(case.models) > 1:
            self._models = {model.title: model.name for model in case.models} | {BOTH: BOTH}
            at = list(self._models.values()).index(chosen.models)
            self._list(gui, "models", list(self._models), at, self._to_models)
        at = COLOURINGS.index(chosen.colouring)
        self._list(gui, "links by", list(COLOURINGS), at, self._to_colouring)
        self._found = case.found
        if self._found:
            gui.add_html(_findings(self._found))
            numbers = tuple(str(number + 1) for number in range(len(self._found)))
            add_widget(
                session,
                gui.add_button_group,
                "show finding",
                numbers,
                then=lambda number: self._show(self._found[int(number) - 1]),
            )

    def _list(
        self, gui: Any, label: str, options: list[str], at: int, then: Callable[[str], None]
    ) -> Any:
        given = (gui.add_dropdown, label, tuple(options))
        return add_widget(self._session, *given, then=then, initial_value=options[at])

    def _show(self, result: DiagnosedFinding) -> None:
        """Go to where a finding shows most, and point at its link."""
        case, chosen = self._view.case, self._view.chosen
        time = case.moment_of(result, case.take(chosen.ask))
        if time is None:
            self._session.say(
                f"Where {result.effect.label} shows cannot be told from this recording.", bad=True
            )
            return
        self._session.jump(time)
        self._session.stage.choose(0, link_of(result.effect, case.robot))

    def _windows(self) -> list[str]:
        case, chosen = self._view.case, self._view.chosen
        return [f"{a:g} to {b:.4g} s" for a, b in case.windows(chosen.ask.episode)]

    def _to(self, chosen: MismatchChoices) -> None:
        """Have something else shown; from another stretch of time the clock begins anew."""
        before = self._view.chosen.ask
        self._session.stage.choose(0, None)
        self._view.choose(chosen, self._session, self._tell)
        if (before.episode, before.window) != (chosen.ask.episode, chosen.ask.window):
            self._session.clock.seek(0.0)

    def _tell(self) -> None:
        """Show what is chosen."""
        chosen, windows = self._view.chosen, self._windows()
        set_value(self._recording, self._recordings[chosen.ask.episode])
        if tuple(self._window.options) != tuple(windows):
            self._window.options = tuple(windows)
        set_value(self._window, windows[chosen.ask.window])
        self._window.visible = len(windows) > 1

    def _to_recording(self, recording: str) -> None:
        self._ask(episode=self._recordings.index(recording), window=0)

    def _to_window(self, window: str) -> None:
        # A recording that was chosen just before may have other windows.
        if window in self._windows():
            self._ask(window=self._windows().index(window))

    def _to_way(self, way: str) -> None:
        self._ask(horizon=self._ways[way])

    def _to_models(self, models: str) -> None:
        self._to(replace(self._view.chosen, models=self._models[models]))

    def _to_colouring(self, colouring: str) -> None:
        self._to(replace(self._view.chosen, colouring=colouring))

    def _ask(self, **changes: Any) -> None:
        chosen = self._view.chosen
        self._to(replace(chosen, ask=replace(chosen.ask, **changes)))


def _unseen(case: MismatchCase, at: int) -> str:
    """Return what is told of a recording that the diagnosis held out."""
    if not case.never_seen(at):
        return ""
    since = case.unseen_from(at)
    return f" (never seen after {since:.3g} s)" if since > 0.0 else " (never seen)"


def _distinct(names: list[str]) -> list[str]:
    """Return names of which no two are the same."""
    return [
        name if names.index(name) == at else f"{name} ({at + 1})" for at, name in enumerate(names)
    ]


def _legend(models: Sequence[MismatchModel]) -> str:
    """Return what is drawn how, in a line of HTML."""
    solid = '<b style="color:#888">&#9632;</b> recorded (solid)'
    ghosts = "".join(
        f' &nbsp; <b style="color:{each.css}">&#9632;</b> {escape(each.title)}' for each in models
    )
    return f'<p class="morph">{solid}{ghosts}</p>'


def _findings(findings: Sequence[DiagnosedFinding]) -> str:
    """Return findings as a numbered list of HTML."""
    items = "".join(
        f"<li>{escape(each.statement)}<br><small>{escape(each.figures)}</small></li>"
        for each in findings
    )
    return f'<ol class="morph" style="padding-left:1.4em">{items}</ol>'
