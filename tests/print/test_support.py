from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import trimesh

from morph.print.mesh import Mesh
from morph.print.printer import Profile
from morph.print.sections import sections
from morph.print.support import support_mm3


def needed(solid: trimesh.Trimesh, profile: Profile) -> float:
    mesh = Mesh(vertices=np.array(solid.vertices), faces=np.array(solid.faces))
    return support_mm3(sections(mesh, profile.layer_mm), profile)


def boxes(*bounds: list[list[float]]) -> trimesh.Trimesh:
    return trimesh.util.concatenate([trimesh.creation.box(bounds=each) for each in bounds])


def table(height: float) -> trimesh.Trimesh:
    top = [[0.0, 0.0, height], [20.0, 20.0, height + 2.0]]
    return boxes([[8.0, 8.0, 0.0], [12.0, 12.0, height + 1.0]], top)


def test_a_block_needs_none(pla: Profile) -> None:
    assert needed(boxes([[0.0, 0.0, 0.0], [20.0, 20.0, 20.0]]), pla) == 0.0


def test_under_a_table_it_grows_with_the_height_and_is_loose(pla: Profile) -> None:
    low, high = needed(table(10.0), pla), needed(table(20.0), pla)
    # Under the table are 384 mm2, and half again in the margin that support gets around what
    # it holds; a seventh of that is plastic.
    assert 384 * 10 * 0.14 < high - low < 2.0 * 384 * 10 * 0.14


@pytest.mark.parametrize(("lean_deg", "held"), [(40.0, False), (60.0, True)])
def test_a_leaning_bar_is_held_up_past_the_lean_allowed(
    pla: Profile, lean_deg: float, held: bool
) -> None:
    shear = np.eye(4)
    shear[0, 2] = np.tan(np.radians(lean_deg))
    bar = boxes([[0.0, 0.0, 0.0], [10.0, 10.0, 20.0]])
    bar.apply_transform(shear)
    assert (needed(bar, pla) > 0.0) == held


def test_a_bridge_between_two_posts_needs_none_and_a_shelf_on_one_does(pla: Profile) -> None:
    left = [[0.0, 0.0, 0.0], [5.0, 30.0, 10.0]]
    right = [[13.0, 0.0, 0.0], [18.0, 30.0, 10.0]]
    beam = [[0.0, 0.0, 9.0], [18.0, 30.0, 11.0]]
    assert needed(boxes(left, right, beam), pla) == 0.0
    assert needed(boxes(left, beam), pla) > 0.0


def test_with_every_lean_allowed_only_what_starts_in_the_air_is_held(pla: Profile) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=8)
    ball.apply_translation((0, 0, 8))
    bold = dataclasses.replace(pla, overhang_deg=90.0)
    assert needed(ball, bold) < 0.2 * needed(ball, pla)
