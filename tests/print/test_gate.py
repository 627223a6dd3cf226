from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from morph.print import gate
from morph.print.check.checks import CHECKS
from morph.print.gate import check_part
from morph.print.mesh import Mesh
from morph.print.part import Check, Part, Placement
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("ender3"), material=material("pla"))


def box(*sides: float, at: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    found = trimesh.creation.box(sides)
    return Mesh(vertices=np.array(found.vertices) + at, faces=np.array(found.faces, dtype=np.int64))


def part(mesh: Mesh | None) -> Part:
    here = Placement(link="link", pose=np.eye(4), world=np.eye(4))
    return Part(name="bracket", kind="printed", mesh=mesh, placements=(here,))


def verdicts(checks: Sequence[Check], verdict: str) -> list[str]:
    return [check.name for check in checks if check.verdict == verdict]


def test_a_sound_part_comes_back_as_it_is_with_all_checks_passed() -> None:
    given = part(box(20.0, 20.0, 20.0))
    found, checks = check_part(given, PROFILE)
    assert found.mesh is given.mesh
    assert [check.name for check in checks] == ["extent", "repair"] + [r.name for r in CHECKS[1:]]
    assert verdicts(checks, "passed") == [check.name for check in checks]


def test_a_part_that_was_mended_comes_back_mended_and_told() -> None:
    cube = box(20.0, 20.0, 20.0)
    found, checks = check_part(part(replace(cube, faces=cube.faces[:, ::-1])), PROFILE)
    assert found.mesh is not None
    assert found.mesh.volume == pytest.approx(8000.0)
    assert verdicts(checks, "noted") == ["repair"]
    assert "turned inside out" in checks[1].what
    assert "its volume changed by 0 %" in checks[1].what


def test_what_every_stl_needs_is_no_note() -> None:
    cube = box(20.0, 20.0, 20.0)
    soup = Mesh(vertices=cube.corners.reshape(-1, 3), faces=np.arange(36).reshape(-1, 3))
    found, checks = check_part(part(soup), PROFILE)
    assert verdicts(checks, "passed") == [check.name for check in checks]
    assert found.mesh is not None
    assert found.mesh.manifold.volume() == pytest.approx(8000.0)


def spoilt(kind: str) -> Mesh | None:
    """A mesh with one of the faults that a slicer takes without a word."""
    cube = box(20.0, 20.0, 20.0)
    if kind == "nan":
        vertices = cube.vertices.copy()
        vertices[3, 1] = np.nan
        return replace(cube, vertices=vertices)
    if kind == "infinite":
        return replace(cube, vertices=np.where(cube.vertices > 9.0, np.inf, cube.vertices))
    if kind == "index":
        return replace(cube, faces=cube.faces + 3)
    if kind == "crossing":
        # One end turned by half a turn: the sides cross in the middle.
        turned = np.where(cube.vertices[:, :1] > 0, cube.vertices * [1, -1, -1], cube.vertices)
        return replace(cube, vertices=turned)
    if kind == "two":
        other = box(20.0, 20.0, 20.0, at=(30.0, 0.0, 0.0))
        both = trimesh.util.concatenate([cube.trimesh, other.trimesh])
        return Mesh(vertices=np.array(both.vertices), faces=np.array(both.faces))
    made = {
        "none": None,
        "empty": Mesh(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), dtype=np.int64)),
        "metres": replace(cube, vertices=cube.vertices / 1000.0),
        "vast": replace(cube, vertices=cube.vertices * 1000.0),
        "open": replace(cube, faces=cube.faces[2:]),
        "thin": box(60.0, 40.0, 0.3),
        "flat": replace(cube, vertices=cube.vertices * [1.0, 1.0, 0.0]),
        "point": replace(cube, vertices=cube.vertices * 0.0),
    }
    return made[kind]


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        ("none", "extent", "no mesh"),
        ("empty", "extent", "empty"),
        ("nan", "extent", "1 of 8 corners"),
        ("infinite", "extent", "7 of 8 corners"),
        ("metres", "extent", "0.02 x 0.02 x 0.02 mm large"),
        ("vast", "extent", "2e+04 x 2e+04 x 2e+04 mm large"),
        ("point", "extent", "0 x 0 x 0 mm large"),
        ("index", "repair", "a face names corner 10, and there are 8"),
        ("open", "repair", "4 edges open"),
        ("flat", "repair", "encloses no solid"),
        ("crossing", "manifold|overlap", "passes through itself"),
        ("two", "one solid", "2 solids in one mesh"),
        ("thin", "wall", "walls of 0.3 mm"),
    ],
)
def test_what_no_printer_can_make_is_refused_with_its_reason_and_a_way_out(
    kind: str, name: str, said: str
) -> None:
    found, checks = check_part(part(spoilt(kind)), PROFILE)
    refused = [check for check in checks if check.verdict == "refused"]
    assert found.name == "bracket"
    assert refused
    assert refused[0].name in name.split("|")
    assert any(word in refused[0].what for word in said.split("|"))
    assert all(check.fix for check in refused)


def test_a_bar_longer_than_the_bed_is_let_through_to_be_cut() -> None:
    _, checks = check_part(part(box(400.0, 20.0, 20.0)), PROFILE)
    assert verdicts(checks, "refused") == []
    assert verdicts(checks, "noted") == ["bed fit"]


@pytest.mark.parametrize("kind", ["bought", "fused"])
def test_what_is_not_printed_by_itself_passes_unlooked_at(kind: str) -> None:
    given = replace(part(spoilt("nan")), kind=kind)
    assert check_part(given, PROFILE) == (given, ())


def test_eighty_thousand_faces_aslant_are_looked_at_in_seconds(
    processor: Callable[[float], AbstractContextManager[None]],
) -> None:
    ball = trimesh.creation.icosphere(subdivisions=6, radius=40.0)
    fine = Mesh(vertices=np.array(ball.vertices), faces=np.array(ball.faces, dtype=np.int64))
    # 0.7 s of one processor; along the normals, whose boxes hold most of the ball, it took 13 s.
    with processor(5.0):
        _, checks = check_part(part(fine), PROFILE)
    assert verdicts(checks, "passed") == [check.name for check in checks]


def test_a_library_that_fails_on_a_mesh_refuses_the_part_and_raises_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fails(*_: object, **__: object) -> None:
        raise RuntimeError("no such luck")

    given = part(box(20.0, 20.0, 20.0))
    monkeypatch.setattr(gate, "repaired", fails)
    _, checks = check_part(given, PROFILE)
    assert (checks[-1].name, checks[-1].verdict) == ("repair", "refused")
    monkeypatch.undo()
    monkeypatch.setattr(gate, "CHECKS", (CHECKS[0], replace(CHECKS[3], look=fails)))
    _, checks = check_part(given, PROFILE)
    assert checks[-1].verdict == "refused"
    assert "no such luck" in checks[-1].what
