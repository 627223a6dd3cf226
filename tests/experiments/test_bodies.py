from __future__ import annotations

import numpy as np
import pytest

from experiments.bodies import case, summary
from experiments.bodies_driven import NOISE, RATE, SECONDS, loaded, moved_along_sines, read


@pytest.mark.parametrize(("body", "falls"), [("pendulum", False), ("hopper", True)])
def test_what_would_fall_without_end_stands_on_a_floor(body: str, falls: bool) -> None:
    robot = loaded(body)
    assert ('type="plane"' in robot.mjcf) is falls


def test_a_motion_is_read_with_noise_and_ends_where_it_is_led() -> None:
    robot = loaded("cart_two_links_servo")
    moved = moved_along_sines(robot, (), np.random.default_rng(0))
    recording = read(robot, (), moved, np.random.default_rng(1), "take")
    channel = recording.channel("hinge_1.position")
    assert len(channel.time) == int(SECONDS * RATE) + 1
    true = np.interp(channel.time, moved.time, moved.position[:, 1])
    # The deviation of 801 numbers is known to 1 / sqrt(1602) of itself; four times that.
    assert np.std(channel.value - true) == pytest.approx(NOISE, rel=0.1)
    assert {name for name in recording.channels if name.endswith("velocity")} == set()


def test_a_clean_pendulum_is_not_accused() -> None:
    row = case("pendulum", 0, clean=True)
    assert (row["hidden"], row["found"]) == ("", [])
    found = summary([row])
    assert (found["diagnosed"], found["clean"], found["accused"]) == (1.0, 1, 0)


def test_a_summary_counts_names_and_places() -> None:
    def row(hidden: str, found: list[str], rivals: list[str]) -> dict[str, object]:
        return {"body": "b", "hidden": hidden, "found": found, "rivals": rivals, "unknown": 0.0}

    rows = [
        row("friction@a", ["friction@a"], []),
        row("friction@a", ["lag@a"], ["friction@a"]),
        row("friction@a", ["friction@b"], []),
        row("friction@a", [], []),
        row("", ["lag@a"], []),
        {**row("friction@a", [], []), "refused": "why"},
    ]
    found = summary(rows)
    assert (found["first"], found["first_three"], found["place"]) == (0.25, 0.5, 0.5)
    assert (found["accused"], found["diagnosed"]) == (1, 1.0 - 1 / 6)
