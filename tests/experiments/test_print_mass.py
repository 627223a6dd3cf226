from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from experiments.print_mass import compared, main, solid, summary
from morph.print.mesh import Mesh
from morph.print.printer import Profile, material, printer
from morph.print.sliced import Sliced
from morph.print.slicer import find_slicer
from morph.print.weight import box

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def said(mass: float, at: float) -> Sliced:
    weight = box(mass, np.array([20.0, 20.0, 20.0])).moved(
        np.array([[1, 0, 0, at], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], dtype=float)
    )
    return Sliced(source="estimate", weight=weight, support_kg=0.0, seconds=3600.0)


def test_errors_are_told_in_percent_and_millimetres() -> None:
    cube = trimesh.creation.box((20, 20, 20))
    full = solid(Mesh(vertices=cube.vertices, faces=np.array(cube.faces)), PROFILE)
    assert full.mass == pytest.approx(8e-6 * 1240)
    found = compared(said(4.5e-3, 0.5), said(5e-3, 0.0), full, PROFILE)
    assert found["mass_percent"] == pytest.approx(-10.0)
    assert found["com_mm"] == pytest.approx(0.5)
    # Ten per cent less mass, the same shape: ten per cent less inertia.
    assert found["inertia_percent"] == pytest.approx(10.0)
    # A cube's own inertia, scaled to the mass, is right, and its centre too.
    assert found["solid_inertia_percent"] == pytest.approx(0.0, abs=1e-9)
    assert found["infill_g"] == pytest.approx(9.92 * 0.15)
    both = summary([{**found, "warnings": [], "estimate_s": 1.0}] * 2)
    assert (both["parts"], both["mean_mass_percent"]) == (2, pytest.approx(10.0))
    assert both["sliced_g"] == pytest.approx(10.0)


@pytest.mark.skipif(find_slicer() is None, reason="there is no slicer")
def test_parts_that_cannot_be_printed_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trimesh.creation.box((12, 12, 6)).export(tmp_path / "cube.stl")
    torn = trimesh.creation.icosphere(subdivisions=1, radius=5)
    trimesh.Trimesh(torn.vertices, torn.faces[:40]).export(tmp_path / "torn.stl")
    assert main([str(tmp_path), "--json", "--as-given", "--out", str(tmp_path / "cells")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [each["part"] for each in told["parts"]] == ["cube", "torn"]
    assert abs(told["parts"][0]["mass_percent"]) < 8.0
    assert told["parts"][1]["why"]
    assert told["mean"]["parts"] == 1
