"""A body designed in a real browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from morph.app.viewer.server import Viewer
from morph.app.viewer.session import Session
from morph.app.viewer.views.design import DesignView
from morph.body.load import load


def test_a_designer_finds_moves_changes_undoes_and_saves(
    served: Callable[..., Viewer],
    look: Callable[[str], Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("MORPH_SHELF", str(tmp_path))
    viewer = served("humanoid", first="design")
    person = look(viewer.address)
    page = person.page
    session: Session = viewer.sessions[0]
    view = session.view
    assert isinstance(view, DesignView)

    # The search leaves both knees.
    page.get_by_text("find", exact=True).locator("xpath=../../../..").locator("input").fill("knee")
    person.until(lambda: not page.locator("label", has_text="l_hip_x").count(), "hips are gone")
    assert page.locator("label", has_text="knee_y").count() == 2

    # The pointer over a slider highlights its link, and nothing once it is elsewhere.
    before = person.settled()
    page.locator("label", has_text="l_knee_y").hover()
    person.until(lambda: person.changes(before), "a link is highlighted")
    page.locator("label", has_text="show original").hover()
    person.until(lambda: not person.changes(before), "it is so no more")
    assert not page.get_by_text("pointed at").first.is_visible()

    # The slider's field moves the link.
    row = page.locator("label", has_text="l_knee_y").locator("xpath=../../../..")
    row.locator("input").last.fill("60")
    person.until(lambda: view.bench.choice.pose, "the joint is turned")
    person.until(lambda: person.changes(before), "the leg is bent")
    assert view.bench.choice.pose["l_knee_y"] == pytest.approx(60 * 3.141592653589793 / 180)

    # A parameter changes the mass, and undo takes it back.
    person.press("Parameters")
    person.until(lambda: page.locator("label", has_text="head_mass").count() == 1, "parameters")
    row = page.locator("label", has_text="head_mass").locator("xpath=../../../..")
    row.locator("input").last.fill("2")
    more = view.plans[0].robot.mass + view.plans[0].robot.link("head").mass
    person.until(lambda: f"{more:.4g} kg (" in person.text(), "the heavier mass is told")
    person.press("Undo")
    person.until(lambda: f"{more:.4g} kg (" not in person.text(), "the mass is as described")
    page.keyboard.press("Shift+Z")
    person.until(lambda: f"{more:.4g} kg (" in person.text(), "the key did it again")

    # It is saved, and loaded by its name.
    person.press("Save")
    page.get_by_text("name", exact=True).locator("xpath=../../../..").locator("input").fill(
        "big_head"
    )
    person.press("Save as a new body")
    person.until(lambda: "morph view big_head" in person.text(), "it is told")
    assert load("big_head").mass == pytest.approx(more, abs=1e-9)
