"""Mismatch in a real Chromium."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from morph.body.load import load
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.write import write
from morph.sim.simulator import Simulator


def test_a_recording_and_its_ghost_are_seen_chosen_and_coloured(
    served: Callable[..., Any], look: Callable[..., Any], tmp_path: Path
) -> None:
    rubbing = Simulator(load("pendulum"), (CoulombFriction(joint="hinge", c=0.2),))
    for name, angle in (("one", 0.3), ("two", 0.5)):
        run = rubbing.run(
            seconds=4.0,
            start={"hinge": angle},
            command={"hinge": lambda t: 1.5 * np.sin(2.0 * t)},
            name=name,
        )
        write(run, tmp_path / f"{name}.npz")
    viewer = served("pendulum", recordings=(tmp_path / "one.npz", tmp_path / "two.npz"))
    person = look(viewer.address)
    (session,) = viewer.sessions
    assert session.view.name == "mismatch"
    for text in ("recorded (solid)", "as described", "hinge: missing torque (N m)"):
        person.until(lambda text=text: text in person.text(), f"it says {text}")
    session.do(lambda: session.jump(2.0))
    before = person.settled()
    # The ghost is somewhere else when it is never put back to the recording.
    choose(person, "simulation", "open loop")
    person.until(lambda: "open loop" in session.content.tables[0].title, "it is an open loop")
    person.until(lambda: person.changes(before), "the ghost has moved")
    assert session.clock.time == 2.0
    choose(person, "recording", "two")
    person.until(lambda: session.content.actors[0].title == "two", "the other run is shown")
    assert "That did not work" not in person.text()


def choose(person: Any, what: str, wanted: str) -> None:
    """Choose from one of the lists."""
    person.page.get_by_role("combobox", name=what).click()
    person.page.get_by_role("option", name=wanted, exact=True).click()
