"""The corpus study on a part of it: nothing crashes, no mass is lost in silence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from experiments.corpus import descriptions, main, row
from experiments.corpus_summary import Row, lost, summary
from experiments.plant.originals import packaged_root

PACKAGED = (
    "double_pendulum_description/urdf/double_pendulum.urdf",
    "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
    "so_arm_description/urdf/so100.urdf",
    "ur_description/urdf/ur5_robot.urdf",
)
"""Robots of PyPI's `example-robot-data`, a dependency of the tests alone."""


def judged(root: Path, path: Path) -> Row:
    one = row((root, path))
    assert one.verdict in ("ok", "repaired", "refused"), one.why
    assert not lost([one]), one
    assert one.differs is None or one.differs <= 1e-9 or one.explained, one
    return one


@pytest.mark.parametrize("name", PACKAGED)
def test_robots_of_another_maker_load_with_all_their_mass(name: str) -> None:
    one = judged(packaged_root(), packaged_root() / name)
    assert one.verdict != "refused", one.why


def test_every_eighth_description_of_the_corpus_loads_or_is_refused_by_name(
    real_robots: Path,
) -> None:
    # Two of all 240 name a parent that is no link, and two hold no link.
    rows = [judged(root, path) for root, path in descriptions([real_robots / "urdf_corpus"])[::8]]
    assert len(rows) == 30
    refused = [one for one in rows if one.verdict == "refused"]
    assert len(refused) <= 4
    assert all(one.why for one in refused)


def row_of(**changes: object) -> Row:
    one = Row(
        file="a.urdf",
        verdict="repaired",
        codes=(("mass-missing", "repaired"),),
        why="",
        seconds=0.1,
        mass=1.0,
        stated=2.0,
        named=0,
        silent="",
        uncounted="",
        differs=None,
        explained=False,
        explained_by="",
        mujoco="loads",
        bare="loads",
    )
    return replace(one, **changes)  # type: ignore[arg-type]


def test_a_mass_that_goes_missing_is_told_whatever_else_was_repaired() -> None:
    one = row_of(silent="arm: 2 kg, simulated 1")
    assert lost([one]) == [one]
    said = summary([one])
    assert "mass lost or gained in silence: 1;" in said
    assert "a.urdf: arm: 2 kg, simulated 1" in said


def test_a_mass_that_was_not_counted_is_no_proof_that_none_was_lost() -> None:
    one = row_of(stated=None, uncounted="xacro cannot expand it")
    assert lost([one]) == [one]


def test_a_difference_with_a_repair_that_does_not_explain_it_is_told() -> None:
    rows = [row_of(differs=0.5), row_of(differs=0.5, explained=True, explained_by="mass-missing")]
    said = summary(rows)
    assert "1 agree once the named repairs are made in the file too" in said
    assert "1 differ by more" in said
    assert "a.urdf: differs by 0.5" in said
    assert "1 by mass-missing" in said


def test_a_folder_without_descriptions_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path)]) == 2
    assert "no description below" in capsys.readouterr().err
