"""The corpus study on a part of it: nothing crashes, no mass is lost in silence."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.corpus import Row, descriptions, lost, main, row, summary
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


def test_a_mass_that_goes_missing_is_told() -> None:
    one = Row(
        file="a.urdf",
        verdict="ok",
        codes=(),
        why="",
        seconds=0.1,
        mass=1.0,
        stated=2.0,
        differs=None,
        explained=False,
        mujoco="loads",
        bare="loads",
    )
    assert lost([one]) == [one]
    assert "mass lost or gained in silence: 1" in summary([one])


def test_a_folder_without_descriptions_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path)]) == 2
    assert "no description below" in capsys.readouterr().err
