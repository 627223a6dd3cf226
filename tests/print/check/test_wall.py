from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from morph.print.check.subject import Subject
from morph.print.check.wall import wall
from morph.print.mesh import Mesh

Make = Callable[..., Mesh]


@pytest.mark.parametrize(
    # 2 * 0.85 * 0.4 = 0.68 mm is two lines at their narrowest, 2 * 0.45 = 0.9 mm in full.
    ("thickness", "verdict"),
    [(0.3, "refused"), (0.67, "refused"), (0.7, "noted"), (0.89, "noted"), (0.91, "passed")],
)
def test_a_plate_is_judged_by_its_thickness(
    thickness: float, verdict: str, box: Make, subject: Callable[..., Subject]
) -> None:
    found = wall(subject(box(60.0, 40.0, thickness)))
    assert found.verdict == verdict
    if verdict != "passed":
        assert found.value == pytest.approx(thickness, abs=0.002)


def test_a_box_with_walls_of_a_third_of_a_millimetre_is_refused(
    box: Make, subject: Callable[..., Subject]
) -> None:
    hollow = trimesh.boolean.difference(
        [box(40, 40, 30).trimesh, box(39.4, 39.4, 30, at=(0, 0, 0.3)).trimesh], engine="manifold"
    )
    mesh = Mesh(vertices=np.array(hollow.vertices), faces=np.array(hollow.faces))
    assert wall(subject(mesh)).verdict == "refused"


@pytest.mark.parametrize("angle_deg", [10.0, 25.0, 45.0])
def test_a_sharp_edge_is_no_thin_wall(angle_deg: float, subject: Callable[..., Subject]) -> None:
    # A wedge 30 mm long: it is thinner than 0.9 mm over the last 0.9 / tan(angle), at 10 degrees
    # 5.1 of 30 mm.
    rise = 30.0 * np.tan(np.deg2rad(angle_deg))
    corners = [[x, y, z] for y in (0.0, 40.0) for x, z in ((0.0, 0.0), (30.0, 0.0), (30.0, rise))]
    hull = trimesh.convex.convex_hull(np.array(corners))
    mesh = Mesh(vertices=np.array(hull.vertices), faces=np.array(hull.faces, dtype=np.int64))
    assert wall(subject(mesh)).verdict != "refused"


def test_a_small_fin_is_told_and_does_not_refuse_the_part(
    box: Make, subject: Callable[..., Subject]
) -> None:
    fin = trimesh.boolean.union(
        [box(40, 40, 40).trimesh, box(0.3, 20, 20, at=(0, 0, 30)).trimesh], engine="manifold"
    )
    mesh = Mesh(vertices=np.array(fin.vertices), faces=np.array(fin.faces))
    found = wall(subject(mesh))
    # 2 * 20 * 20 = 800 mm2 of 6 * 1600 + 800; a point stands for 7 mm2.
    assert found.verdict == "noted"
    assert float(found.what.split()[0]) == pytest.approx(800.0, abs=15.0)


def test_a_finer_nozzle_prints_thinner_walls(box: Make, subject: Callable[..., Subject]) -> None:
    plate = subject(box(60.0, 40.0, 0.5))
    fine = replace(plate.profile.printer, nozzle_mm=0.25)
    finer = replace(plate, profile=replace(plate.profile, printer=fine, line_mm=0.25))
    # 2 * 0.85 * 0.25 = 0.425 mm; in full 0.5, and a plate of 0.5 mm is measured to rounding.
    assert wall(plate).verdict == "refused"
    assert wall(finer).verdict != "refused"
