from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import pytest

from morph.print.printer import MATERIALS, PRINTERS, Profile
from morph.print.settings import settings
from morph.print.slicer import Slicer

Said = dict[str, str]


def said(text: str) -> Said:
    return dict(line.split(" = ", 1) if " = " in line else (line[:-2], "")
                for line in text.splitlines() if not line.startswith("#"))  # fmt: skip


def test_the_same_profile_gives_the_same_bytes(pla: Profile) -> None:
    assert settings(pla) == settings(dataclasses.replace(pla))


def test_a_profile_is_told_in_the_slicers_units(pla: Profile) -> None:
    told = said(settings(dataclasses.replace(pla, overhang_deg=50.0, infill=0.15)))
    # Density in g/cm3, infill in per cent, the lean counted from the bed.
    assert told["filament_density"] == "1.24"
    assert told["fill_density"] == "15%"
    assert told["support_material_threshold"] == "40"
    assert told["bed_shape"] == "0x0,250x0,250x210,0x210"
    assert told["max_print_height"] == "220"


def test_all_of_the_inside_is_filled_with_straight_lines(pla: Profile) -> None:
    assert said(settings(dataclasses.replace(pla, infill=1.0)))["fill_pattern"] == "rectilinear"


def test_only_a_printer_that_probes_its_bed_is_told_to() -> None:
    for printer in PRINTERS:
        told = said(settings(Profile(printer=printer, material=MATERIALS[0])))
        assert ("G29" in told["start_gcode"]) == bool(printer.level)


def test_what_is_heated_is_switched_off_at_the_end(pla: Profile) -> None:
    end = said(settings(pla))["end_gcode"]
    assert "M104 S0" in end
    assert "M140 S0" in end


@pytest.mark.parametrize("printer", PRINTERS, ids=lambda printer: printer.name)
def test_the_slicer_knows_every_key_and_keeps_every_value(
    slicer: Slicer, printer: object, tmp_path: Path
) -> None:
    assert printer in PRINTERS
    profile = Profile(printer=printer, material=MATERIALS[1])  # type: ignore[arg-type]
    mine, kept = tmp_path / "mine.ini", tmp_path / "kept.ini"
    mine.write_text(settings(profile, brim_mm=4.0))
    command = [str(slicer.program), "--datadir", str(tmp_path / "data"), "--load", str(mine)]
    subprocess.run([*command, "--save", str(kept)], check=True, capture_output=True, timeout=60)
    told, understood = said(mine.read_text()), said(kept.read_text())
    assert {key: understood.get(key) for key in told} == told
