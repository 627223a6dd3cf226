"""Masses, margins and times of a package as its report shows them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.app.report.print.words import hours, link_rows, margin_row
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.margins import Margin
from morph.print.weight import Weight


def weight(mass: float, x_mm: float = 0.0, stretch: float = 1.0) -> Weight:
    inertia = 1e-4 * mass * np.diag([stretch, 1.0, 1.0])
    return Weight(mass=mass, com=np.array([1e-3 * x_mm, 0.0, 0.0]), inertia=inertia)


def row(mass: LinkMass) -> Any:
    (only,) = link_rows(cast(Any, SimpleNamespace(links=[mass])))
    return only


def test_a_link_that_became_heavier_says_by_how_much() -> None:
    told = row(
        LinkMass(
            link="arm",
            designed=weight(0.2),
            predicted=weight(0.25, x_mm=3.0, stretch=2.0),
            measured=None,
            source="estimate",
        )
    )
    assert (told.designed, told.predicted, told.measured) == ("200.0 g", "250.0 g", "–")
    # 250 by 200 is a quarter more.
    assert (told.change, told.moved, told.source) == ("+25 %", "3.0 mm", "estimated")
    # Of (1, 1, 1) with the norm sqrt 3 one number is off by 1: 58 %, once masses are alike.
    assert told.inertia == "58 %"


def test_what_a_scale_showed_counts_before_what_was_predicted() -> None:
    told = row(
        LinkMass(
            link="arm",
            designed=weight(0.2),
            predicted=weight(0.25),
            measured=weight(0.19),
            source="scale",
        )
    )
    assert (told.measured, told.change, told.source) == ("190.0 g", "-5 %", "weighed")


def test_what_keeps_its_description_has_no_change() -> None:
    told = row(
        LinkMass(
            link="arm", designed=weight(0.2), predicted=None, measured=None, source="description"
        )
    )
    assert (told.change, told.moved, told.inertia) == ("–", "–", "–")


def test_a_margin_is_what_is_left_of_the_limit() -> None:
    told = margin_row(
        Margin(actuator="knee", joint="knee", unit="N m", limit=2.0, designed=1.0, printed=1.5)
    )
    # 1.5 of 2 are used: a quarter is left.
    assert (told.limit, told.designed, told.printed, told.left) == (
        "2 N m",
        "1 N m",
        "1.5 N m",
        "25 %",
    )


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [(59.0 * 60.0, "59 min"), (3.0 * 3600.0 + 300.0, "3 h 05 min"), (3600.0, "1 h 00 min")],
)
def test_times_are_hours_and_minutes(seconds: float, shown: str) -> None:
    assert hours(seconds) == shown
