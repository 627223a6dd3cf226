"""How many threads step simulations of one model together."""

from __future__ import annotations

import os

MOST = 2
"""Threads at most: states are short, and more threads wait for each other longer than they work."""

VARIABLE = "OMP_NUM_THREADS"
"""Limits threads of numerical libraries by convention; workers of a study and tests set it to 1."""


def batch_threads(rows: int, *, worth: int = 2) -> int:
    """Return how many threads `mujoco.batch.Batch` gets; results are the same bits with any.

    A thread that waits for the others counts as busy: beside other work on the machine, two take
    up to three times the processor of one.

    Args:
        rows: How many simulations there are.
        worth: From how many on a second thread is worth its cost.
    """
    given = os.environ.get(VARIABLE, "")
    most = min(int(given), MOST) if given.isdecimal() and int(given) > 0 else MOST
    return most if rows >= worth else 1
