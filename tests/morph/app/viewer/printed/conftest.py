"""A small package to look at: the printed quadruped, weighed in part."""

from __future__ import annotations

from dataclasses import replace

import pytest

from morph.app.viewer.printed.source import divided
from morph.app.viewer.printed.viewed_package import ViewedPackage
from morph.body.load import load


@pytest.fixture(scope="module")
def made() -> ViewedPackage:
    """What is seen of the printed quadruped, one of its legs 7 g on the scale."""
    robot = load("quadruped_printed")
    return ViewedPackage(robot, replace(divided(robot), readings={"lower_leg": 0.007}))
