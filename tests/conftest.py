"""What several tests share."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest

from experiments.public.manifest import VARIABLES, data_root, load_sets


def folder_of(kind: str) -> Path:
    """Return the folder of public data of a kind, or skip, or fail where `CI=true`."""
    root = data_root(kind)
    absent = [s.name for s in load_sets() if s.kind == kind and not (root / s.name).is_dir()]
    # A folder that the environment names may hold what its owner likes.
    if not root.is_dir() or (absent and not os.environ.get(VARIABLES[kind])):
        reason = (
            f"there are not all public {kind} in {root} (missing: {', '.join(absent)}); "
            f"fetch them by python -m experiments.data, or name their folder by {VARIABLES[kind]}"
        )
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return root


def pytest_configure() -> None:
    """Give numerical libraries one thread, and no example of Hypothesis a limit in seconds.

    The tests themselves run on every core. Threads of a BLAS that wait for each other count as
    busy: two for each test on two cores took five times the processor for small matrices.
    """
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        # Read when a library is loaded, here and in every process that is started.
        os.environ.setdefault(name, "1")
    from hypothesis import HealthCheck, settings
    from threadpoolctl import threadpool_limits

    # What conftest.py of a folder has loaded before this.
    threadpool_limits(1)
    slow = [HealthCheck.too_slow]
    settings.register_profile("unhurried", deadline=None, suppress_health_check=slow)
    settings.load_profile("unhurried")


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; CI must have it, elsewhere its tests are skipped."""
    return folder_of("recordings")


@pytest.fixture(scope="session")
def real_robots() -> Path:
    """The folder of real descriptions; CI must have it, elsewhere its tests are skipped."""
    return folder_of("robots")


COUNTED = 0.02
"""s of the processor that counting to a million takes on a machine that does nothing else."""


def counted() -> float:
    """Return how long counting to a million takes here and now, s of the processor."""
    began = time.process_time()
    sum(range(1_000_000))
    return time.process_time() - began


def measured_slowness() -> float:
    """Return how much more of the processor counting takes here and now; at least 1.

    Whoever shares a core has less of its caches: what counting takes then, all else takes too.
    """
    return max(1.0, counted() / COUNTED)


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Fail if what is done takes more of the processor than it may."""
    began = time.process_time()
    yield
    taken = time.process_time() - began
    # Counting takes time itself: it is only done where a slow machine might be the reason.
    given = seconds if taken < seconds else seconds * max(measured_slowness() for _ in range(5))
    assert taken < given, f"{taken:.2f} s; {given:.2f} s are given"


@pytest.fixture
def processor() -> Callable[[float], AbstractContextManager[None]]:
    """Says how much of the processor something may take, s; a slow machine is given more."""
    return within


@pytest.fixture
def slowness() -> Callable[[], float]:
    """Tells how much more of the processor anything takes here and now; at least 1."""
    return measured_slowness
