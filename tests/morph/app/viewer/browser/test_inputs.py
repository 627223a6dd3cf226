"""Inputs that come as soon as a widget stands on the page, many within one throttle of viser's."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from morph.app.viewer.design.panel import SECTIONS
from morph.app.viewer.session import Session

HASTY = """
(() => {
  const typed = (window.typed = {}), met = new Set(), open = new Map();
  // viser's own settings are numbered otherwise.
  const ours = (number) => /^[0-9a-f]{8}-/.test(number);
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const type = (input, text) => {
    set.call(input, text);
    input.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const rowOf = (label) => {
    for (let node = label; node && node !== document.body; node = node.parentElement) {
      if (node.querySelectorAll("label[for]").length > 1) return null;
      if (node.querySelector("input,[role=slider],button")) return node;
    }
    return null;
  };
  // A list has its options once it is open: the first that it does not show is taken.
  const choose = () => {
    for (const [number, list] of open) {
      const options = document.getElementById(list.getAttribute("aria-controls"));
      const all = [...(options ? options.querySelectorAll("[role=option]") : [])];
      const other = all.find((option) => option.textContent !== list.value);
      if (all.length) open.delete(number);
      if (!other) continue;
      typed[number] = other.textContent;
      other.click();
    }
  };
  const press = () => {
    for (const button of document.querySelectorAll("button[id]")) {
      if (met.has(button.id) || !ours(button.id) || button.disabled) continue;
      met.add(button.id);
      typed[button.id] = true;
      button.click();
    }
  };
  const act = () => {
    press();
    choose();
    for (const label of document.querySelectorAll("label[for]")) {
      const number = label.htmlFor, row = rowOf(label);
      if (!row || met.has(number) || !ours(number)) continue;
      const thumb = row.querySelector("[role=slider]");
      const box = row.querySelector("input[type=checkbox]");
      const inputs = row.querySelectorAll("input");
      const input = inputs[inputs.length - 1];
      const list = row.querySelector("[aria-haspopup=listbox]");
      if (!thumb && !box && label.textContent === "pointed at") continue;
      met.add(number);
      if (thumb) {
        const low = +thumb.ariaValueMin, high = +thumb.ariaValueMax, now = +thumb.ariaValueNow;
        const to = now < (low + high) / 2 ? low + 0.75 * (high - low) : low + 0.25 * (high - low);
        // A field cuts off what its slider has no digits for: degrees have tenths.
        typed[number] = +to.toFixed(high - low > 5 ? 1 : 2);
        type(input, String(typed[number]));
      } else if (box) {
        typed[number] = !box.checked;
        box.click();
      } else if (list) {
        open.set(number, list);
        list.click();
      } else if (!input) {
        const first = row.querySelector("button");
        typed[number] = first.textContent;
        first.click();
      } else {
        // Joints are sought by words: by a blank all are found.
        type(input, " ");
        typed[number] = " ";
      }
    }
  };
  new MutationObserver(act).observe(document, { childList: true, subtree: true });
})();
"""
"""Types into every slider, box and text the moment that it stands on the page, presses every
button and the first of every group, and chooses from every list that has something else."""


STANDS = """
(numbers) => numbers.filter(
  (number) => document.querySelector(`[id="${number}"], label[for="${number}"]`))
"""
"""Which of some widgets stand on the page."""


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Any]]:
    """The last input of a person that was to be acted on, by the number of its widget.

    What the first press of a button or choice from a list does is left out: a page
    would be saved, or another view shown.
    """
    from viser import _gui_handles as handles

    found: dict[str, Any] = {}
    choices = (handles.GuiButtonHandle, handles.GuiButtonGroupHandle, handles.GuiDropdownHandle)
    told, does = threading.local(), Session.do

    def hearing(listen: Callable[..., Any]) -> Callable[..., Any]:
        def listens(handle: Any, what: Callable[[Any], None]) -> Any:
            def hears(event: Any) -> None:
                told.handle = handle
                what(event)
                told.handle = None

            return listen(handle, hears)

        return listens

    def do(session: Session, what: Any) -> None:
        handle = getattr(told, "handle", None)
        if handle is None:
            does(session, what)
            return
        number, first = handle._impl.uuid, handle._impl.uuid not in found
        if first or not isinstance(handle, choices):
            found[number] = what.args[-1]
        if not (first and isinstance(handle, choices)):
            does(session, what)

    monkeypatch.setattr(Session, "do", do)
    for kind, name in (
        (handles.GuiInputHandle, "on_update"),
        (handles.GuiButtonHandle, "on_click"),
        (handles.GuiButtonGroupHandle, "on_click"),
    ):
        monkeypatch.setattr(kind, name, hearing(getattr(kind, name)))
    return found


def lost(typed: dict[str, Any], heard: dict[str, Any]) -> list[str]:
    """The numbers of the widgets that show what nobody heard of."""

    def same(one: Any, other: Any) -> bool:
        # A page's numbers are JavaScript's; half a hundredth is less than any two differ by.
        return one == (other if isinstance(other, bool | str) else pytest.approx(other, abs=0.0051))

    return [
        number
        for number, value in typed.items()
        if number not in heard or not same(heard[number], value)
    ]


@pytest.mark.parametrize("names", [("pendulum", "cartpole"), ("humanoid",)], ids="-".join)
def test_what_is_typed_at_once_into_every_panel_is_heard_of(
    served: Callable[..., Any],
    blank: Callable[..., Any],
    inputs: dict[str, Any],
    heard: dict[str, Any],
    names: tuple[str, ...],
) -> None:
    viewer = served(*names, **(inputs if "cartpole" in names else {}))
    person = blank()
    person.page.add_init_script(HASTY)
    person.page.goto(viewer.address)
    person.until(lambda: viewer.sessions, "somebody is there")
    (session,) = viewer.sessions
    typed: dict[str, Any] = {}

    def all_heard(where: str) -> None:
        # What a view of before had is gone from the page, and was heard of while it was there.
        before = len(typed)

        def holds() -> bool:
            typed.update(person.page.evaluate("window.typed"))
            # A widget that was replaced meanwhile shows nothing any more.
            stands = set(person.page.evaluate(STANDS, lost(typed, heard)))
            return len(typed) > before and not stands & set(lost(typed, heard))

        person.until(holds, f"all of {where} is heard of")

    for view in session.views:
        if view is not session.view:
            person.press(view.title)
            person.until(lambda view=view: session.view is view, f"{view.title} is open")
        if view.name == "design":
            for section in SECTIONS:
                if section != SECTIONS[0]:
                    person.press(section)
                all_heard(f"{view.title}, {section}")
        elif view.name in ("compare", "align", "print"):
            all_heard(view.title)
    assert {type(value) for value in typed.values()} >= {bool, str, float}
    # The humanoid has 25 joints, and both pages the clock's slider and the three boxes of a page.
    assert len(typed) > (30 if names == ("humanoid",) else 10)
