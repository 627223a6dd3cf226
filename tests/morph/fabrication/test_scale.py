"""Readings of a scale."""

from __future__ import annotations

from dataclasses import replace

import pytest

from morph.errors import MakeError
from morph.fabrication.content import Package
from morph.fabrication.scale import ScaleReading, readings, taken


@pytest.mark.parametrize(
    ("said", "part", "grams"),
    [
        ("bar=9.5", "bar", 9.5),
        ("P-01=9.5", "bar", 9.5),
        ("p-01=9.5", "bar", 9.5),
        ("bar = 19/2", "bar", 9.5),
        ("ball=101.5", "ball", 101.5),
    ],
)
def test_a_part_is_weighed_by_name_or_number_alone_or_with_its_like(
    package: Package, said: str, part: str, grams: float
) -> None:
    (found,) = readings(package, [said])
    assert found.part == part
    assert found.kg == pytest.approx(1e-3 * grams)


@pytest.mark.parametrize(
    ("said", "what"),
    [
        (["bra=9"], "there is no part 'bra'"),
        (["bar"], "says no mass"),
        (["bar=heavy"], "'heavy' is no mass"),
        (["bar=0"], "'0' is no mass"),
        (["bar=-9"], "'-9' is no mass"),
        (["bar=nan"], "'nan' is no mass"),
        (["bar=inf"], "'inf' is no mass"),
        (["bar=9/0"], "'9/0' is no mass"),
        (["bar=9/two"], "'9/two' is no mass"),
        (["bar=9", "P-01=9.5"], "weighed twice"),
        (["bar=13.1"], r"bar 13.1 g \(10 g predicted, \+31 %\)"),
    ],
)
def test_a_reading_that_makes_no_sense_is_refused(
    package: Package, said: list[str], what: str
) -> None:
    with pytest.raises(MakeError, match=what):
        readings(package, said)


def test_an_unknown_part_is_told_what_is_near(package: Package) -> None:
    with pytest.raises(MakeError) as told:
        readings(package, ["bra=9"])
    assert "'bar'" in told.value.fix


def test_a_gauge_and_a_refused_part_are_no_parts_of_the_robot(package: Package) -> None:
    bar = package.job.parts[0]
    job = replace(
        package.job,
        gauges=(replace(bar, name="gauge", number="G-01"),),
        refused=(replace(bar, name="shell", number="P-09"),),
    )
    with pytest.raises(MakeError, match="a gauge"):
        readings(replace(package, job=job), ["G-01=9"])
    with pytest.raises(MakeError, match="refused"):
        readings(replace(package, job=job), ["shell=9"])


def test_far_off_is_taken_if_somebody_insists(package: Package) -> None:
    (found,) = readings(package, ["bar=30"], anyway=True)
    assert found.kg == pytest.approx(0.03)


def test_the_later_reading_counts_and_one_can_be_forgotten() -> None:
    before = {"bar": 0.009, "ball": 0.1}
    assert taken(before, [ScaleReading(part="bar", kg=0.011)]) == {"bar": 0.011, "ball": 0.1}
    assert taken(before, [ScaleReading(part="bar", kg=None)]) == {"ball": 0.1}
    assert before == {"bar": 0.009, "ball": 0.1}
