"""The controls of the view Design on one person's page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from morph.app.viewer.design.joint_panel import JointPanel
from morph.app.viewer.design.number import number_of
from morph.app.viewer.design.parameter_panel import ParameterPanel
from morph.app.viewer.widget import add_widget

if TYPE_CHECKING:
    from morph.app.viewer.session import Session
    from morph.app.viewer.views.design import DesignView

SECTIONS = ("Joints", "Parameters", "Save")
"""What is shown one at a time, so that the rest of the page stays in sight."""

ACTIONS = ("Undo", "Redo", "Rest", "Random")
"""The buttons over them."""

POINTED = "pointed at"
"""Label of the field in which page.js tells where the pointer is; it is hidden."""


class DesignPanel:
    """The controls; every method runs in the session's thread.

    Args:
        gui: The `viser.GuiApi`, inside the view's folder.
        session: The page.
        view: The view that is controlled.
    """

    def __init__(self, gui: Any, session: Session, view: DesignView) -> None:
        """Add them."""
        self._gui, self._session, self._view = gui, session, view
        add = self._add = partial(add_widget, session)
        if len(view.plans) > 1:
            names = tuple(f"{at + 1}: {p.robot.name}" for at, p in enumerate(view.plans))
            add(
                gui.add_dropdown,
                "body",
                names,
                initial_value=names[view.at],
                then=lambda name: view.choose(names.index(name)),
            )
        self._headline = gui.add_html("")
        add(gui.add_button_group, "", ACTIONS, then=self._act)
        add(
            gui.add_checkbox,
            "show original",
            view.ghost,
            hint="the body as described, translucent, where it differs",
            then=view.show_original,
        )
        add(gui.add_button_group, "", SECTIONS, then=self.open)
        self._folders = {name: gui.add_folder(name) for name in SECTIONS}
        with self._folders["Joints"]:
            self.joints = JointPanel(gui, add, view.turn)
        with self._folders["Parameters"]:
            self.parameters = ParameterPanel(gui, add, view.set)
            add(gui.add_button, "As described", then=lambda _: view.plain())
        with self._folders["Save"]:
            self._save()
        self.open(SECTIONS[0])
        self._pointing()
        session.stage.picked = self._picked

    def open(self, section: str) -> None:
        """Show one of the sections."""
        for name, folder in self._folders.items():
            folder.visible = name == section

    def show(self) -> None:
        """Show another body, or one with other joints."""
        self.joints.show(self._view.bench)
        self.parameters.show(self._view.bench)
        self.tell()

    def tell(self, held: str | None = None) -> None:
        """Show where everything is, but for a slider that a hand holds."""
        self.joints.tell(held)
        self.parameters.tell(held)
        self._headline.content = f'<p class="morph headline">{escape(self._view.headline())}</p>'

    def keys(self) -> None:
        """Add the keys; once for a page, for they outlive the controls."""
        for label, key, modifier, what in (
            ("undo", "Z", None, self._view.undo),
            ("redo", "Z", "shift", self._view.redo),
        ):
            self._add(
                self._gui.add_command,
                f"design: {label}",
                hotkey=key,
                modifier=modifier,
                then=partial(self._when_shown, what),
            )

    def _when_shown(self, what: Callable[[], None], _: None) -> None:
        if self._session.view is self._view:
            what()

    def _act(self, action: str) -> None:
        view = self._view
        {"Undo": view.undo, "Redo": view.redo, "Rest": view.rest, "Random": view.random}[action]()

    def _save(self) -> None:
        gui, view = self._gui, self._view
        name = self._add(
            gui.add_text,
            "name",
            "",
            hint="letters, digits and _, beginning with a letter",
            then=lambda _: None,
        )
        self._add(gui.add_button, "Save as a new body", then=lambda _: view.save(str(name.value)))
        gui.add_markdown("It goes to your own shelf; `morph view NAME` shows it again.")

    def _pointing(self) -> None:
        """Add the field that page.js writes to; the style is of our own text alone."""

        def pointed(number: str) -> None:
            links = self.joints.links | self.parameters.links
            self._view.highlight(links.get(number))

        number = number_of(self._add(self._gui.add_text, POINTED, "", then=pointed))
        self._gui.add_html(
            f'<style>div:has(> div > div > p > label[for="{number}"]){{display:none}}</style>'
        )

    def _picked(self, actor: int, link: str) -> None:
        """Show what moves a link that was clicked in the scene, or what may be changed of it."""

        def seek() -> None:
            joints = [h.joint for h in self._view.bench.posture.handles if h.link == link]
            if self._folders["Parameters"].visible:
                self.parameters.choose(link)
            else:
                self.open("Joints")
                self.joints.seek(joints[0] if joints else link)
            self._view.highlight(link)

        self._session.do(seek)
