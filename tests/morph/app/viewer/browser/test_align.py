"""Align in a real Chromium."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from morph.app.cli.main import main

QUICK = ("--trials", "2", "--repeats", "0", "--scratch", "0", "--quiet")


def test_a_chain_is_seen_and_its_hops_parts_and_motions_are_chosen(
    served: Callable[..., Any], look: Callable[..., Any], tmp_path: Path
) -> None:
    chain = ("cartpole", "rider_rigid_driven", "rider_three_links_driven")
    out = tmp_path / "out"
    command = ["transfer", "--from", "learned", "--chain", *chain, "--out", str(out), *QUICK]
    assert main(command) == 0
    viewer = served(transfer=out)
    person = look(viewer.address)
    (session,) = viewer.sessions
    assert session.view.name == "align"
    for text in ("The chain from cartpole", *chain, "The guard calls it safe on", "safe"):
        person.until(lambda text=text: text in person.text(), f"it says {text}")
    session.do(lambda: session.jump(0.5))
    before = person.picture()
    choose(person, "hop", "2: rider_rigid_driven → rider_three_links_driven")
    person.until(lambda: "turned round" not in person.text(), "the other hop is told")
    for text in ("Scores on rider_three_links_driven", "no gain", "the same way", "32 %"):
        person.until(
            lambda text=text: text in person.text().replace("\N{NO-BREAK SPACE}", " "),
            f"it says {text}",
        )
    person.until(lambda: session.content.actors[0].ghost, "the cart-pole is a ghost")
    person.until(lambda: person.changes(before), "it is seen")
    choose(person, "part", "ankle → knee")
    person.until(lambda: session.content.actors[1].tints, "the part is pointed at")
    choose(person, "motion", "the target leads")
    person.until(lambda: session.content.seconds > 4.5, "the target's run is shown")
    assert "That did not work" not in person.text()


def choose(person: Any, what: str, wanted: str) -> None:
    """Choose from one of the lists."""
    person.page.get_by_role("combobox", name=what, exact=True).click()
    person.page.get_by_role("option", name=wanted, exact=True).click()
