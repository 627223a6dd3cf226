"""The study of the SO-101 in small, on real motions."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.so101 import compared, report, studied


def test_dry_friction_is_found_in_a_real_servo_arm_and_no_motion_is_worse_than_described(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Motion 2 of 4 is opened afterwards. The wrist's servo stands still until its command
    # is about 0.02 rad ahead, fifteen counts of its encoder: a linear servo cannot do that.
    motions = [
        "single_joint_rotation",
        "single_joint_wrist_pitch",
        "dual_joint_elbow_wrist",
        "wave_motion",
    ]
    found, aside = studied(recordings, 3, motions, budget=25.0)
    assert set(aside) < set(motions)
    rows = compared(found, aside)
    assert {row["joint"] for row in rows} >= {"Rotation", "Wrist_Pitch"}
    assert found.findings[0].effect.name in {"coulomb_friction", "stribeck_friction"}
    total = {model: sum(row[model] ** 2 for row in rows) for model in ("nominal", "corrected")}
    assert total["corrected"] < total["nominal"]
    report(found, rows, ["Wrist_Pitch"])
    assert "Wrist_Pitch: slow motions" in capsys.readouterr().out
