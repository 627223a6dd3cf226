"""Masses and inertias that do not belong to a body of the link's shape are named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from morph.body.check.fit import swapped

SIZES = {"base": (0.3, 0.3, 0.1), "arm": (0.05, 0.06, 0.4), "hand": (0.1, 0.04, 0.12)}
"""Edges of three solid boxes of aluminium, 2700 kg/m3, m."""


def masses(**factors: float) -> dict[str, float]:
    return {
        name: 2700 * float(np.prod(edges)) * factors.get(name, 1.0) for name, edges in SIZES.items()
    }


def solid(mass: float, edges: tuple[float, float, float]) -> tuple[float, ...]:
    """Return the moments of a solid box: m / 12 (b^2 + c^2), and so on round."""
    a, b, c = edges
    return tuple(mass / 12 * (x * x + y * y) for x, y in ((b, c), (a, c), (a, b)))


def robot(
    bench: Any, mass: dict[str, float] | None = None, arm: tuple[float, ...] | None = None
) -> Any:
    """Return the reading of three boxes with these masses, and the arm with these moments."""
    mass = mass or masses()
    links = []
    for name, edges in SIZES.items():
        moments = solid(mass[name], edges)
        if name == "arm" and arm is not None:
            moments = arm
        shape = bench.box(" ".join(str(edge) for edge in edges))
        links.append(bench.link(name, shape, mass=mass[name], moments=moments))
    return bench.read(
        *links,
        bench.joint("shoulder", "base", "arm", xyz="0 0 0.3"),
        bench.joint("wrist", "arm", "hand", xyz="0 0 0.4"),
    )


def test_solid_boxes_of_aluminium_are_right(bench: Any) -> None:
    assert robot(bench).findings == ()


@pytest.mark.parametrize("factor", [0.05, 0.3, 3.0])
def test_hollow_boxes_and_boxes_of_steel_are_right_too(bench: Any, factor: float) -> None:
    # Plastic shells have a twentieth of a solid's mass, steel three times aluminium's.
    assert robot(bench, masses(arm=factor)).findings == ()


def test_a_mass_in_grams_does_not_fit_its_volume(bench: Any) -> None:
    reading = robot(bench, masses(arm=1000.0))
    assert reading.stands("mass-volume", "info", "link", "arm")


def test_a_mass_in_tonnes_does_not_fit_its_volume(bench: Any) -> None:
    reading = robot(bench, masses(arm=0.0003))
    assert reading.stands("mass-volume", "info", "link", "arm")


def test_a_shape_ten_times_too_large_does_not_fit_its_mass(bench: Any) -> None:
    # 1000 times the volume at the same mass: 2.7 kg/m3 beside aluminium.
    reading = bench.read(
        bench.link("base", bench.box("0.3 0.3 0.1"), mass=24.3, moments=(0.2, 0.2, 0.36)),
        bench.link("arm", bench.box("0.5 0.6 4"), mass=3.24, moments=(0.04, 0.04, 0.002)),
        bench.link("hand", bench.box("0.1 0.1 0.1"), mass=2.7, moments=(0.0045, 0.0045, 0.0045)),
        bench.joint("shoulder", "base", "arm", xyz="0 0 2.2"),
        bench.joint("wrist", "arm", "hand", xyz="0 0 2.2"),
    )
    assert reading.stands("mass-volume", "info", "link", "arm")


def test_an_inertia_in_gram_millimetres_is_wider_than_its_shape(bench: Any) -> None:
    moments = solid(masses()["arm"], SIZES["arm"])
    # 1 kg m2 = 1e9 g mm2.
    reading = robot(bench, arm=tuple(1e9 * value for value in moments))
    assert reading.stands("inertia-oversized", "info", "link", "arm")


def test_an_inertia_a_million_times_too_small_is_told(bench: Any) -> None:
    moments = solid(masses()["arm"], SIZES["arm"])
    reading = robot(bench, arm=tuple(1e-6 * value for value in moments))
    assert reading.stands("inertia-undersized", "info", "link", "arm")


def test_an_inertia_with_exchanged_axes_is_told_with_the_axes(bench: Any) -> None:
    xx, yy, zz = solid(masses()["arm"], SIZES["arm"])
    reading = robot(bench, arm=(zz, yy, xx))
    assert reading.stands("inertia-swapped", "info", "link", "arm")
    assert "x and z" in reading.the("inertia-swapped").what


def test_exchanging_the_axes_of_a_cube_changes_nothing(bench: Any) -> None:
    edge = (0.1, 0.1, 0.1)
    assert swapped(np.diag(solid(1.0, edge)), np.diag(solid(2.0, edge))) is None


def test_a_rod_with_exchanged_axes_is_brought_back_by_the_same_exchange() -> None:
    rod = np.diag(solid(1.0, (0.02, 0.02, 1.0)))
    for wrong, axes in {(2, 1, 0): "x and z", (0, 2, 1): "y and z"}.items():
        told = swapped(rod[np.ix_(wrong, wrong)], rod)
        # Two of a rod's axes are alike, so either of them may be the one exchanged.
        assert told is not None
        assert "z" in told, axes


def test_a_mass_that_is_hung_on_one_side_is_no_exchange(bench: Any) -> None:
    # A motor of half the mass at one end of the arm: the law of the lever, not an exchange.
    mass, edges = masses()["arm"], SIZES["arm"]
    xx, yy, zz = solid(mass / 2, edges)
    off = mass / 2 * 0.1**2 + mass / 2 * 0.1**2
    assert robot(bench, arm=(xx + off, yy + off, zz)).findings == ()


def test_an_inertia_that_no_body_has_is_compared_with_no_shape(bench: Any) -> None:
    reading = robot(bench, arm=(-1.0, -1.0, -1.0))
    assert {finding.code for finding in reading.findings} == {"inertia-broken"}
    assert robot(bench, arm=(1.0, -1.0, 0.0)).the("inertia-broken").where.name == "arm"
