"""Sliders of joints, in groups or as found by a text."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from morph.app.viewer.design.design_state import Bench
from morph.app.viewer.design.limbs import JointChain, found, limbs
from morph.app.viewer.design.number import number_of
from morph.app.viewer.widget import set_value
from morph.body.posture import Handle

DEGREES = 180.0 / math.pi
"""Hinges are told in degrees on the page, and in rad everywhere else."""


class JointPanel:
    """The sliders of a design's joints.

    Args:
        gui: The `viser.GuiApi`, inside the folder that is for them.
        add: Adds a widget, as `add_widget` of the page does.
        turned: Told a joint's name and position, rad or m, when its slider is moved.
    """

    def __init__(
        self,
        gui: Any,
        add: Callable[..., Any],
        turned: Callable[[str, float], None],
    ) -> None:
        """Add the search field."""
        self._gui, self._add, self._turned = gui, add, turned
        self._find = add(
            gui.add_text,
            "find",
            "",
            hint="words in names of joints or links",
            then=lambda _: self._sift(),
        )
        self._place = gui.add_folder(None)
        self._parts: list[Any] = []
        self._sliders: dict[str, Any] = {}
        self._bench: Bench | None = None
        self._shown: tuple[Any, ...] = ()

    @property
    def links(self) -> dict[str, str]:
        """By the page's number of a slider, the link that it moves."""
        handles = {} if self._bench is None else {h.joint: h for h in self._bench.posture.handles}
        return {
            number_of(slider): handles[joint].link
            for joint, slider in self._sliders.items()
            if joint in handles
        }

    def show(self, bench: Bench) -> None:
        """Show the sliders of a design where its joints are."""
        self._bench = bench
        self._sift()
        self.tell()

    def tell(self, held: str | None = None) -> None:
        """Put the sliders where the joints are, but for one that a hand holds."""
        if self._bench is None:
            return
        for handle in self._bench.posture.handles:
            slider = self._sliders.get(handle.joint)
            if slider is not None and handle.joint != held:
                set_value(slider, _shown(handle, self._bench.position(handle)))

    def seek(self, text: str) -> None:
        """Show only what a text finds."""
        self._find.value = text
        self._sift()

    def _sift(self) -> None:
        if self._bench is None:
            return
        handles, sought = self._bench.posture.handles, str(self._find.value)[:100]
        if sought.strip():
            groups: tuple[JointChain, ...] = (JointChain(title="", handles=found(handles, sought)),)
        else:
            groups = limbs(self._bench.built.robot, handles)
        if groups == self._shown:
            return
        self._shown = groups
        for part in self._parts:
            part.remove()
        self._parts, self._sliders = [], {}
        with self._place:
            for at, limb in enumerate(groups):
                self._group(limb, first=at == 0)
            if not handles or not any(limb.handles for limb in groups):
                text = "no joint is found" if handles else "no joint moves by itself"
                self._parts.append(self._gui.add_markdown(text))

    def _group(self, limb: JointChain, *, first: bool) -> None:
        if limb.title:
            folder = self._gui.add_folder(limb.title, expand_by_default=first)
            self._parts.append(folder)
            with folder:
                for handle in limb.handles:
                    self._slider(handle)
            return
        for handle in limb.handles:
            self._parts.append(self._slider(handle))

    def _slider(self, handle: Handle) -> Any:
        bench = self._bench
        at = handle.rest if bench is None else bench.position(handle)
        low, high = _shown(handle, handle.low), _shown(handle, handle.high)
        high = max(high, low + 1e-6)
        unit = "degrees" if handle.kind == "hinge" else "m"
        step = 0.1 if handle.kind == "hinge" else 1e-4
        without = "" if handle.limited else ", without limits"
        scale = DEGREES if handle.kind == "hinge" else 1.0
        slider = self._add(
            self._gui.add_slider,
            handle.joint,
            low,
            high,
            min(step, high - low),
            min(max(_shown(handle, at), low), high),
            hint=f"{handle.kind}{without}, {unit}; moves {handle.link}",
            then=lambda value: self._turned(handle.joint, float(value) / scale),
        )
        self._sliders[handle.joint] = slider
        return slider


def _shown(handle: Handle, position: float) -> float:
    """Return a joint's position as the page tells it: tenths of degrees, or tenths of mm."""
    return round(position * DEGREES, 1) if handle.kind == "hinge" else round(position, 4)
