"""The knobs of the comparison: which task, which arrows, and who is commanded by what."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from morph.app.viewer.compare.arrows import KINDS
from morph.app.viewer.compare.body_show import Show
from morph.app.viewer.compare.shared_work import Work
from morph.app.viewer.stage import ARROWS
from morph.app.viewer.widget import add_widget

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

SWEEP = "none: joints through their ranges"
"""What the choice of tasks calls no task."""

ALONE = "There is no task that all of them know: each shows how far its joints go."
"""Told where there is nothing to choose."""


class ComparePanel:
    """What the view adds to a person's page.

    Args:
        gui: The `viser.GuiApi`, inside the view's folder.
        session: The page.
        tasks: Names of the tasks to choose from.
        task: The one that is chosen.
        kinds: The kinds of arrows that are shown.
        on_task: Is told which task a person chooses; None for none.
        on_arrows: Is told which kinds of arrows a person wants.
    """

    def __init__(
        self,
        gui: Any,
        session: Session,
        tasks: Sequence[str],
        task: str | None,
        kinds: set[str],
        *,
        on_task: Callable[[str | None], None],
        on_arrows: Callable[[set[str]], None],
    ) -> None:
        """Add it."""
        if tasks:
            add_widget(
                session,
                gui.add_dropdown,
                "task",
                (SWEEP, *tasks),
                initial_value=task or SWEEP,
                then=lambda chosen: on_task(None if chosen == SWEEP else chosen),
            )
        self._shared = bool(tasks)
        self._said = gui.add_html("")
        self._boxes: dict[str, Any] = {}

        def drawn(_: bool) -> None:
            on_arrows({kind for kind, box in self._boxes.items() if box.value})

        for kind in KINDS:
            given = (gui.add_checkbox, f"{kind} arrows", kind in kinds)
            self._boxes[kind] = add_widget(session, *given, then=drawn)
        self._legend = gui.add_html("")

    def tell(
        self,
        names: Sequence[str],
        works: Sequence[Work[Show]],
        lengths: Mapping[str, str],
        goals: Sequence[str] = (),
    ) -> None:
        """Tell how each body stands, and what the arrows mean that there are.

        Args:
            names: What the bodies are called.
            works: What comes of each.
            lengths: What the length of each kind of arrow means.
            goals: What the task asks for.
        """
        for kind, box in self._boxes.items():
            box.visible = kind in lengths
        statement = goals_html(goals) + states_html(names, works)
        self._said.content = (
            statement if self._shared else f'<p class="morph">{ALONE}</p>{statement}'
        )
        self._legend.content = legend_html(lengths)


def goals_html(goals: Sequence[str]) -> str:
    """Return what the task asks for, each goal once."""
    named = escape("; ".join(dict.fromkeys(goals)))
    return f'<div class="morph">Goals: {named}.</div>' if goals else ""


def states_html(names: Sequence[str], works: Sequence[Work[Show]]) -> str:
    """Return what commands each body, or what it waits for."""
    rows = []
    for name, work in zip(names, works, strict=True):
        if work.error is not None:
            state = "cannot be shown moving: see the notes"
        elif work.found is not None:
            state = work.found.policy
        else:
            state = f"{work.told or 'getting ready'} \N{HORIZONTAL ELLIPSIS}"
        if state:
            rows.append(f"<li>{escape(name)}: {escape(state)}</li>")
    return f'<ul class="morph">{"".join(rows)}</ul>' if rows else ""


def legend_html(lengths: Mapping[str, str]) -> str:
    """Return the colour of each kind of arrow, and what its length means."""
    rows = "".join(
        f'<li><span style="color:rgb{ARROWS[kind]}">\N{RIGHTWARDS ARROW}</span> '
        f"{escape(kind)}: {escape(length)}</li>"
        for kind, length in lengths.items()
    )
    return f'<ul class="morph">{rows}</ul>' if rows else ""
