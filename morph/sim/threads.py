"""How many threads work on simulations, on runs and on matrices."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")
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


def each(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return a function's results for some items, by threads: compiled loops run side by side."""
    listed = list(items)
    threads = batch_threads(len(listed))
    if threads == 1:
        return [function(item) for item in listed]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(function, listed))


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep BLAS, OpenMP and torch to one thread; simulations keep theirs.

    Searches and filters work on matrices of some hundred rows. Threads that wait for each other on
    those take five times as long as one, as soon as anything else runs on the machine.
    """
    torch = sys.modules.get("torch")
    before = None if torch is None else torch.get_num_threads()
    with threadpool_limits(1):
        try:
            if torch is not None:
                torch.set_num_threads(1)
            yield
        finally:
            if torch is not None:
                torch.set_num_threads(before)
