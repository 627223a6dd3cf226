"""What MuJoCo warns of, caught instead of printed and written to a file of its own."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def quiet() -> Iterator[list[str]]:
    """Catch MuJoCo's warnings; yield the list to which they are added, each once."""
    caught: list[str] = []

    def keep(message: str) -> None:
        words = " ".join(str(message).split())
        if words not in caught:
            caught.append(words)

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(keep)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            yield caught
        for warning in told:
            keep(str(warning.message))
    finally:
        mujoco.set_mju_user_warning(before)
