"""Sliders of what a designer may change of a body."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from morph.app.viewer.design.design_state import Bench
from morph.app.viewer.design.number import number_of
from morph.app.viewer.design.parameters import UNITS, WHOLE, neutral
from morph.app.viewer.widget import set_value
from morph.body.card import CardParameter
from morph.body.vary import Lock

OWN = "its card's parameters"
"""The choice of the card's parameters."""

EVERYTHING = "whole body"
"""What the choice calls `*`."""

STEPS = 200
"""Steps between the ends of a slider."""


class ParameterPanel:
    """The sliders of a design's parameters.

    Args:
        gui: The `viser.GuiApi`, inside the folder that is for them.
        add: Adds a widget, as `add_widget` of the page does.
        changed: Told a parameter's name and value, None for as described.
    """

    def __init__(
        self,
        gui: Any,
        add: Callable[..., Any],
        changed: Callable[[str, float | None], None],
    ) -> None:
        """Add the choice of what is changed."""
        self._gui, self._add, self._changed = gui, add, changed
        self._of = add(gui.add_dropdown, "change", (OWN,), then=lambda _: self._list())
        self._place = gui.add_folder(None)
        self._parts: list[Any] = []
        self._sliders: dict[str, Any] = {}
        self._locks: dict[str, Any] = {}
        self._bench: Bench | None = None
        self._listed: tuple[Any, ...] = ()

    @property
    def links(self) -> dict[str, str]:
        """By the page's number of a slider, the link or joint that it changes."""
        if self._bench is None:
            return {}
        of = {parameter.name: parameter.link for parameter in self._bench.plan.parameters}
        shown = (*self._sliders.items(), *self._locks.items())
        return {number_of(handle): of[name] for name, handle in shown}

    def show(self, bench: Bench) -> None:
        """Show the parameters of a design."""
        if self._bench is None or self._bench.plan is not bench.plan:
            own = (OWN,) if bench.plan.own else ()
            links = dict.fromkeys(parameter.link for parameter in bench.plan.general)
            options = (*own, *(EVERYTHING if link == WHOLE else link for link in links))
            self._of.options, self._of.value = options, options[0]
        self._bench = bench
        self._list()

    def choose(self, link: str) -> None:
        """Show what may be changed of a link, if there is anything."""
        if self._bench is not None and link in self._of.options:
            set_value(self._of, link)
            self._list()

    def tell(self, held: str | None = None) -> None:
        """Put the sliders where the parameters are, but for one that a hand holds."""
        if self._bench is None:
            return
        values = self._bench.choice.values
        for parameter in self._bench.plan.parameters:
            name = parameter.name
            if name in self._locks:
                set_value(self._locks[name], name in values)
                self._sliders[name].visible = name in values
            if name in self._sliders and name != held:
                set_value(self._sliders[name], values.get(name, neutral(parameter)))

    def _list(self) -> None:
        bench, chosen = self._bench, str(self._of.value)
        if bench is None:
            return
        # A body that is built anew has the same sliders: one may be under a hand.
        if self._listed != (bench.plan, chosen):
            self._listed = bench.plan, chosen
            self._draw(bench, chosen)
        self.tell()

    def _draw(self, bench: Bench, chosen: str) -> None:
        for part in self._parts:
            part.remove()
        self._parts, self._sliders, self._locks = [], {}, {}
        link = WHOLE if chosen == EVERYTHING else chosen
        own = chosen == OWN
        shown = bench.plan.own if own else [p for p in bench.plan.general if p.link == link]
        with self._place:
            for parameter in shown:
                self._show(parameter, parameter.name if own else parameter.name.split(": ")[-1])

    def _show(self, parameter: CardParameter, label: str) -> None:
        name = parameter.name
        part = "the whole body" if parameter.link == WHOLE else parameter.link
        unit = UNITS.get(parameter.operation, "")
        if parameter.operation == Lock.name:
            lock = self._add(
                self._gui.add_checkbox,
                label,
                False,
                hint=f"weld the joint of {part}",
                then=lambda locked: self._changed(name, neutral(parameter) if locked else None),
            )
            self._parts.append(lock)
            self._locks[name] = lock
        slider = self._add(
            self._gui.add_slider,
            "at" if parameter.operation == Lock.name else label,
            parameter.low,
            parameter.high,
            (parameter.high - parameter.low) / STEPS or 1e-6,
            neutral(parameter),
            hint=f"{parameter.operation} {part}; {unit}",
            then=lambda value: self._changed(name, float(value)),
        )
        self._parts.append(slider)
        self._sliders[name] = slider
