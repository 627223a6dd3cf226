"""What a fluid needs to know of a link: worked out once, whatever its shapes are like."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor import box_tensor, ellipsoid_tensor
from morph.physics.fluid.wetted import figures as module
from morph.physics.fluid.wetted import mend
from morph.physics.fluid.wetted.figures import figures_of
from morph.physics.fluid.wetted.panels import box_drag
from morph.physics.fluid.wetted.tessellate import box_mesh, ellipsoid_mesh

SIDES = np.array([0.16, 0.05, 0.02])


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))


def beside(mesh: Mesh, place: tuple[float, ...]) -> Mesh:
    return Mesh(vertices=mesh.vertices + place, faces=mesh.faces)


def test_a_box_beside_its_hinge_has_the_tensor_and_drag_of_that_box() -> None:
    found = figures_of((beside(box_mesh(SIDES), (-0.088, 0.0, 0.01)),))
    due = box_tensor(*SIDES).shifted((-0.088, 0.0, 0.01))
    # Corners are rounded to a billionth.
    assert np.allclose(found.tensor.matrix, due.matrix, rtol=1e-6, atol=1e-14)
    assert np.allclose(found.tensor.centre, (-0.088, 0.0, 0.01), atol=1e-9)
    assert np.allclose(found.tensor.point, 0.0)
    # Panels of 1/24 of its length sample the |s|^3 of a turn.
    assert np.allclose(found.drag, box_drag(SIDES, (1.1, 1.1, 1.1)), rtol=0.01)
    assert (found.how, found.reason, found.spread.tolist()) == ("mesh", "", [0.0, 0.0])


def test_a_ball_has_half_its_volume_and_a_positive_definite_tensor() -> None:
    found = figures_of((ellipsoid_mesh(np.full(3, 0.1)),))
    exact = ellipsoid_tensor(0.1, 0.1, 0.1)
    assert np.allclose(np.diag(found.tensor.matrix)[:3], np.diag(exact.matrix)[:3], rtol=1e-6)
    assert np.linalg.eigvalsh(found.tensor.matrix).min() > 0


def test_a_second_paddle_a_mirrored_one_and_a_second_day_compute_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    blade = beside(box_mesh(SIDES), (-0.088, 0.02, 0.01))
    arm = (blade, box_mesh(np.full(3, 0.04)))
    first = figures_of(arm)

    def never(*_: object) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(module, "_computed", never)
    again = figures_of(arm)
    assert (again.tensor.matrix == first.tensor.matrix).all()
    other = figures_of(tuple(shape.scaled((1.0, -1.0, 1.0)) for shape in arm))
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    # Mirrored in y: v_y, and of the axial w those across y, change sign.
    assert np.allclose(
        other.tensor.matrix, np.outer(signs, signs) * first.tensor.matrix, rtol=1e-9, atol=1e-15
    )
    assert np.allclose(other.tensor.centre, (1.0, -1.0, 1.0) * first.tensor.centre)
    with pytest.raises(AssertionError, match="computed again"):
        figures_of(arm, how="hull")


def test_a_damaged_file_is_computed_again_and_a_cache_without_a_folder_costs_only_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = figures_of((box_mesh(SIDES),))
    (file,) = (Path(os.environ["MORPH_CACHE"]) / "fluid").iterdir()
    file.write_bytes(file.read_bytes()[:200])
    assert (figures_of((box_mesh(SIDES),)).tensor.matrix == first.tensor.matrix).all()
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "file"))
    assert (figures_of((box_mesh(SIDES),)).tensor.matrix == first.tensor.matrix).all()


def test_boxes_that_touch_along_a_face_a_last_digit_apart_are_one_solid() -> None:
    one = box_mesh(np.array([0.1, 0.1, 0.1]))
    other = beside(box_mesh(np.array([0.1, 0.06, 0.06])), (0.1 + 2e-17, 0.0, 0.0))
    found = figures_of((one, other))
    assert found.how == "mesh"
    assert found.tensor.volume == pytest.approx(0.1**3 + 0.1 * 0.06**2, rel=1e-6)


def test_boxes_that_meet_in_an_edge_are_grown_to_be_one_and_keep_their_volume() -> None:
    one = box_mesh(np.full(3, 0.1))
    found = figures_of((one, beside(one, (0.1, 0.1, 0.0))))
    assert found.how == "mesh"
    assert "parts that only touch were grown" in found.reason
    assert found.tensor.volume == pytest.approx(2e-3, rel=1e-6)


def test_a_sheet_thinner_than_its_panels_is_still_a_plate() -> None:
    found = figures_of((box_mesh(np.array([0.2, 0.2, 1e-5])),))
    # 0.579 pi/4 a^3 for a square plate (DNV-RP-C205, table D-2), and 0.7 % for its edge.
    assert found.tensor.matrix[2, 2] == pytest.approx(0.579 * np.pi / 4 * 0.2**3, rel=0.02)
    # 1e-5 m, rounded to 2^-36 of 0.28 m.
    assert found.tensor.volume == pytest.approx(4e-7, rel=1e-6)


def test_what_boundary_elements_refuse_is_replaced_and_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ell = (box_mesh(np.array([0.3, 0.1, 0.1])), beside(box_mesh(np.full(3, 0.1)), (0.1, 0.1, 0)))
    # The wrap that is tried on the way need not be a good one.
    monkeypatch.setattr(mend, "CELLS", (24, 16))
    monkeypatch.setattr(mend, "FEW", 100)
    monkeypatch.setattr(mend, "PANELS", 200)
    real, asked = module._tensor, []

    def refuse(found: object) -> object:
        asked.append(found.how)  # type: ignore[attr-defined]
        if found.how != "box":  # type: ignore[attr-defined]
            raise RobotError("no", where="here", fix="none")
        return real(found)  # type: ignore[arg-type]

    monkeypatch.setattr(module, "_tensor", refuse)
    found = figures_of(ell)
    assert asked == ["mesh", "wrap", "hull", "box"]
    assert found.how == "box"
    assert "found no panels" in found.reason
    assert np.linalg.eigvalsh(found.tensor.matrix).min() > 0
