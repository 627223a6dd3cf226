"""The controls of the view Design on one person's page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from morph.app.viewer.design.joint_panel import JointPanel
from morph.app.viewer.design.number import number_of
from morph.app.viewer.design.parameter_panel import ParameterPanel

if TYPE_CHECKING:
    from morph.app.viewer.session import Session
    from morph.app.viewer.views.design import Design

SECTIONS = ("Joints", "Parameters", "Save")
"""What is shown one at a time, so that the rest of the page stays in sight."""

ACTIONS = ("Undo", "Redo", "Rest", "Random")
"""The buttons over them."""

POINTED = "pointed at"
"""Label of the field in which page.js tells where the pointer is; it is hidden."""


class Panel:
    """The controls; every method runs in the session's thread.

    Args:
        gui: The `viser.GuiApi`, inside the view's folder.
        session: The page.
        view: The view that is controlled.
    """

    def __init__(self, gui: Any, session: Session, view: Design) -> None:
        """Add them."""
        self._gui, self._session, self._view = gui, session, view
        if len(view.plans) > 1:
            names = tuple(f"{at + 1}: {p.robot.name}" for at, p in enumerate(view.plans))
            body = gui.add_dropdown("body", names, initial_value=names[view.at])
            self.on(body.on_update, lambda: view.choose(names.index(body.value)))
        self._headline = gui.add_html("")
        actions = gui.add_button_group("", ACTIONS)
        self.on(actions.on_click, lambda: self._act(str(actions.value)))
        ghost = gui.add_checkbox(
            "show original", view.ghost, hint="the body as described, translucent, where it differs"
        )
        self.on(ghost.on_update, lambda: view.show_original(bool(ghost.value)))
        sections = gui.add_button_group("", SECTIONS)
        self._folders = {name: gui.add_folder(name) for name in SECTIONS}
        with self._folders["Joints"]:
            self.joints = JointPanel(gui, self.on, view.turn)
        with self._folders["Parameters"]:
            self.parameters = ParameterPanel(gui, self.on, view.set)
            plain = gui.add_button("As described")
            self.on(plain.on_click, view.plain)
        with self._folders["Save"]:
            self._save()
        self.on(sections.on_click, lambda: self.open(str(sections.value)))
        self.open(SECTIONS[0])
        self._pointing()
        session.stage.picked = self._picked

    def on(self, event: Any, what: Callable[[], None]) -> None:
        """Have something done in the session's thread when a person does something."""

        def happened(event: Any) -> None:
            if event.client_id is not None:
                self._session.do(what)

        event(happened)

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
            command = self._gui.add_command(f"design: {label}", hotkey=key, modifier=modifier)
            self.on(command.on_trigger, partial(self._when_shown, what))

    def _when_shown(self, what: Callable[[], None]) -> None:
        if self._session.view is self._view:
            what()

    def _act(self, action: str) -> None:
        view = self._view
        {"Undo": view.undo, "Redo": view.redo, "Rest": view.rest, "Random": view.random}[action]()

    def _save(self) -> None:
        gui, view = self._gui, self._view
        name = gui.add_text("name", "", hint="letters, digits and _, beginning with a letter")
        button = gui.add_button("Save as a new body")
        self.on(button.on_click, lambda: view.save(str(name.value)))
        gui.add_markdown("It goes to your own shelf; `morph view NAME` shows it again.")

    def _pointing(self) -> None:
        """Add the field that page.js writes to; the style is of our own text alone."""
        field = self._gui.add_text(POINTED, "")
        number = number_of(field)
        self._gui.add_html(
            f'<style>div:has(> div > div > p > label[for="{number}"]){{display:none}}</style>'
        )

        def pointed() -> None:
            links = self.joints.links | self.parameters.links
            self._view.highlight(links.get(str(field.value)))

        self.on(field.on_update, pointed)

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
