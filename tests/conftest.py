"""What several tests share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real recordings; CI must have it, elsewhere its tests are skipped."""
    named = os.environ.get("MORPH_RECORDINGS")
    folder = Path(named) if named else HERE.parent.parent / "shared" / "recordings"
    if not folder.is_dir():
        reason = f"there are no real recordings in {folder}; name them by MORPH_RECORDINGS"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return folder


@pytest.fixture(scope="session")
def real_robots() -> Path:
    """The folder of real descriptions; CI must have it, elsewhere its tests are skipped."""
    named = os.environ.get("MORPH_ROBOTS")
    folder = Path(named) if named else HERE.parent.parent / "shared" / "robots"
    if not folder.is_dir():
        reason = f"there are no real robots in {folder}; name them by MORPH_ROBOTS"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return folder
