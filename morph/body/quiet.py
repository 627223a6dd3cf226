"""What engines warn of, caught instead of printed and written to files of their own."""

from __future__ import annotations

import os
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
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            yield caught
        for warning in given:
            keep(str(warning.message))
    finally:
        mujoco.set_mju_user_warning(before)


@contextmanager
def silent() -> Iterator[None]:
    """Drop what a C library writes to standard error: it says the same in its exception."""
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)
