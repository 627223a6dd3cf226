"""Arrows keep the shape of arrows, however short they are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from morph.app.viewer.quiver import HEAD_LENGTH, MOST_HEAD, SHAFT, SHRINK, STEPS, Quiver, steps


def arrow(length: float) -> Any:
    """Return one picture with one upright arrow of so many metres."""
    return np.array([[[[0.0, 0.0, 0.0], [0.0, 0.0, length]]]])


def head(step: int, size: float = 1.0) -> float:
    return SHAFT * HEAD_LENGTH * size * SHRINK**step


@given(length=st.floats(0.01, 10.0), size=st.floats(0.1, 5.0))
def test_a_head_takes_at_most_two_fifths_of_its_arrow(length: float, size: float) -> None:
    # What is shorter than a hundredth of a body is not drawn at all.
    (found,) = steps(arrow(length * size), size)[0]
    assert head(found, size) <= MOST_HEAD * length * size * (1 + 1e-6)
    # And it is no more slender than it must be.
    assert found == 0 or head(found - 1, size) > MOST_HEAD * length * size


def test_what_is_not_there_has_no_step() -> None:
    assert steps(arrow(0.0), 1.0) == -1
    assert steps(arrow(np.nan), 1.0) == -1
    assert steps(arrow(1e-9), 1.0) == STEPS - 1


def test_arrows_of_one_thickness_share_a_node_and_a_picture_shows_its_own() -> None:
    nodes: list[Any] = []

    def add_arrows(name: str, points: Any, colour: Any, **given: Any) -> Any:
        nodes.append(SimpleNamespace(name=name, colour=colour, points=points, **given))
        return nodes[-1]

    # Heads of the longest are 0.042 m: 1 m is long, 0.08 m is not (0.4 of it are 0.032 m).
    both = np.concatenate((arrow(1.0), arrow(0.08)))
    quiver = Quiver(SimpleNamespace(add_arrows=add_arrows), "/a", both, 1.0, (0, 255, 128))
    assert [node.head_length for node in nodes] == pytest.approx([head(0), head(1)])
    quiver.pose(1, shown=True)
    assert [node.visible for node in nodes] == [False, True]
    assert np.allclose(nodes[1].points[0, 1], (0.0, 0.0, 0.08))
    quiver.pose(1, shown=False)
    assert not any(node.visible for node in nodes)
    # Black and full light stay; (128 / 255)^2.2 of 255 is 56.
    assert nodes[0].colour == (0, 255, 56)
