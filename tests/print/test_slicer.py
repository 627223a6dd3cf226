"""The real PrusaSlicer, on parts of which the weight is known."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh

from morph.print.job import Orientation
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.printer import Profile
from morph.print.slicer import Slicer

Make = Callable[[trimesh.Trimesh], Part]


def test_a_full_cube_weighs_as_its_plastic(
    slicer: Slicer, pla: Profile, upright: Orientation, part: Make
) -> None:
    solid = dataclasses.replace(pla, infill=1.0)
    found = slicer.sliced(part(trimesh.creation.box((20, 20, 20))), upright, solid)
    # 8 cm3 of 1.24 g/cm3 are 9.92 g; a cube's inertia is m a2 / 6. What remains is that lines
    # overlap a little at their ends: 0.5 % was found.
    assert found.weight.mass == pytest.approx(9.92e-3, rel=0.01)
    assert np.abs(found.weight.com).max() < 0.1e-3
    cube = 9.92e-3 * 0.02**2 / 6
    assert np.diag(found.weight.inertia) == pytest.approx(np.full(3, cube), rel=0.02)
    assert np.abs(found.weight.inertia - np.diag(np.diag(found.weight.inertia))).max() < cube / 500
    assert found.warnings == ()
    assert found.slicer.startswith("PrusaSlicer ")


def test_our_sum_is_the_slicers_own(
    slicer: Slicer, pla: Profile, upright: Orientation, part: Make
) -> None:
    found = slicer.sliced(part(trimesh.creation.annulus(8, 11, 6)), upright, pla)
    assert found.gcode is not None
    said = re.search(rb"^; filament used \[g\] = ([0-9.]+)", found.gcode, re.MULTILINE)
    assert said is not None
    # The slicer writes grams with two digits: 0.005 g of 2 g are a quarter of a per cent.
    all_of_it = found.weight.mass + found.support_kg
    assert all_of_it * 1e3 == pytest.approx(float(said.group(1)), rel=0.005)
    assert sum(found.by_feature.values()) == pytest.approx(all_of_it)


def test_the_weight_is_in_the_frame_of_the_part_however_it_lies(
    slicer: Slicer, pla: Profile, part: Make
) -> None:
    # A wedge far from its origin, printed full, lying on another side and turned askew.
    wedge = trimesh.Trimesh(
        [[0, 0, 0], [30, 0, 0], [0, 20, 0], [0, 0, 12], [30, 0, 12], [0, 20, 12]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]],
    )
    wedge.apply_translation((500, -70, 33))
    turn = trimesh.transformations.euler_matrix(np.pi, 0.0, 0.7)[:3, :3]
    lying = Orientation(turn=turn, support_mm3=0, first_support_mm3=0, height_mm=12)
    solid = dataclasses.replace(pla, infill=1.0)
    found = slicer.sliced(part(wedge), lying, solid)
    assert wedge.volume == pytest.approx(3600)
    assert found.weight.mass == pytest.approx(wedge.volume * 1.24e-6, rel=0.01)
    assert np.abs(found.weight.com * 1e3 - wedge.center_mass).max() < 0.1
    inertia = wedge.moment_inertia * 1.24e-6 * 1e-6
    away = np.linalg.norm(found.weight.inertia - inertia) / np.linalg.norm(inertia)
    assert away < 0.02


def test_several_parts_on_a_bed_keep_their_places_and_names(slicer: Slicer, pla: Profile) -> None:
    box = trimesh.creation.box((10, 10, 4))
    low = Mesh(vertices=box.vertices + np.array([20, 30, 2]), faces=np.array(box.faces))
    far = Mesh(vertices=box.vertices + np.array([200, 150, 2]), faces=np.array(box.faces))
    code = slicer.code({"arm-1": low, "arm-2": far}, pla)
    assert {b"; printing object arm-1.stl", b"; printing object arm-2.stl"} == {
        line.split(b" id:")[0]
        for line in code.gcode.splitlines()
        if line.startswith(b"; printing object")
    }
    places = np.array(re.findall(rb"^G1 X([0-9.]+) Y([0-9.]+) E\.", code.gcode, re.MULTILINE))
    x = places.astype(float)[:, 0]
    # Nothing was moved: both are where they were put, and between them is only the skirt.
    assert ((x > 15) & (x < 25)).any()
    assert ((x > 195) & (x < 205)).any()
    assert code.seconds > 60


def test_two_may_slice_at_once(
    slicer: Slicer, pla: Profile, upright: Orientation, part: Make
) -> None:
    cube = part(trimesh.creation.box((8, 8, 4)))
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda _: slicer.sliced(cube, upright, pla).weight.mass, range(2)))
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_what_hangs_over_is_held_up_and_what_holds_it_is_weighed_apart(
    slicer: Slicer, pla: Profile, upright: Orientation, part: Make
) -> None:
    post = trimesh.creation.box(bounds=[[-2, -2, 0], [2, 2, 6]])
    roof = trimesh.creation.box(bounds=[[-8, -8, 6], [8, 8, 7]])
    found = slicer.sliced(part(trimesh.util.concatenate([post, roof])), upright, pla)
    held = found.by_feature["Support material"] + found.by_feature["Support material interface"]
    # Under the roof are 240 mm2, 6 mm high: a seventh of it, and more in the dense layers.
    assert 240 * 6 * 1.24e-6 / 10 < held < 240 * 6 * 1.24e-6 / 2
    assert found.support_kg == pytest.approx(held + found.by_feature["Skirt/Brim"])
    assert found.warnings == ()


def test_a_slim_part_gets_a_brim_and_a_squat_one_none(
    slicer: Slicer, pla: Profile, upright: Orientation, part: Make
) -> None:
    mast = slicer.sliced(part(trimesh.creation.box((4, 4, 20))), upright, pla)
    block = slicer.sliced(part(trimesh.creation.box((4, 4, 8))), upright, pla)
    # A brim of 4 mm about 4 mm: (12^2 - 4^2) mm2 of 0.2 mm, less its corners, is some 30 mg.
    assert mast.by_feature["Skirt/Brim"] - block.by_feature["Skirt/Brim"] > 20e-6
