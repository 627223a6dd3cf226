"""Turning viser's own record of a page's camera, and what the page is sent of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from viser import CameraHandle, _messages

from morph.app.viewer.camera import turn

BEFORE, TARGET = np.array([4.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])


class Page:
    """A page that follows what it is sent, and may have sent where it was just before."""

    def __init__(self, late_after: int | None) -> None:
        self.position, self.look_at = BEFORE, TARGET
        self._late_after, self._heard = late_after, 0
        self.camera = CameraHandle(
            SimpleNamespace(_websock_connection=self)  # type: ignore[arg-type]
        )
        self.say()

    def say(self) -> None:
        state = self.camera._state
        state.position, state.look_at, state.update_timestamp = BEFORE, TARGET, 1.0
        state.up_direction = np.array([0.0, 0.0, 1.0])

    def queue_message(self, message: Any) -> None:
        if isinstance(message, _messages.SetCameraPositionMessage):
            self.position = np.array(message.position)
        if isinstance(message, _messages.SetCameraLookAtMessage):
            self.look_at = np.array(message.look_at)
        self._heard += 1
        if self._heard == self._late_after:
            self.say()


@pytest.mark.parametrize("late_after", [None, 1, 2, 3, 4])
def test_a_page_looks_where_it_is_turned_whenever_its_last_message_arrives(
    late_after: int | None,
) -> None:
    page = Page(late_after)
    position = np.array([0.0, 6.0, 3.0])
    turn(page.camera, position, TARGET)
    np.testing.assert_allclose(page.position, position)
    # The two targets are a thousandth of 6.3 m apart.
    assert np.linalg.norm(page.look_at - TARGET) < 0.0064
