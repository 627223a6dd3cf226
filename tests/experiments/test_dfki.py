from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.dfki import DESIGNS, FOLDER, main, moved_to_the_wrong_joint
from experiments.openloop import Model, bound, corrected, errors, from_mjcf, laid
from morph.body.fulltext import fulltext
from morph.body.load import load as load_robot
from morph.body.spec import spec_of
from morph.model.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.model.split import between
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def slice_of_c0(recordings: Path) -> tuple[Diagnosis, Path]:
    robot = load_robot("double_pendulum")
    whole = bound("dfki_c0", FOLDER, robot, ("run_00", "run_01"), root=recordings)
    # Six seconds of each: the study fits all of four runs.
    train = [between(run, run.start, run.start + 6.0) for run in whole]
    aside = bound("dfki_c0", FOLDER, robot, ("run_03",), root=recordings)
    return diagnose(robot, train, held_out=aside, horizon=1.0), recordings


def test_two_runs_of_the_rig_are_enough_to_name_dry_friction_at_a_joint(
    slice_of_c0: tuple[Diagnosis, Path],
) -> None:
    found, _ = slice_of_c0
    assert found.verdict == "mismatch"
    labels = {finding.effect.label for finding in found.findings}
    assert labels & {"coulomb_friction@shoulder", "coulomb_friction@elbow"}


def test_the_model_rebuilt_from_what_is_written_scores_as_the_diagnosis_says(
    slice_of_c0: tuple[Diagnosis, Path],
) -> None:
    found, root = slice_of_c0
    robot = load_robot("double_pendulum")
    runs = laid(bound("dfki_c0", FOLDER, robot, ("run_03",), root=root), robot)
    rebuilt = errors(corrected(found), runs, 1.0)
    for joint, value in rebuilt.items():
        # Text at full precision and the same steps: what differs is rounding.
        assert value == pytest.approx(
            found.held_out_rmse["corrected"][f"{joint}.position"], rel=1e-6
        )


def test_the_finding_at_the_wrong_joint_is_worse(slice_of_c0: tuple[Diagnosis, Path]) -> None:
    found, root = slice_of_c0
    robot = load_robot("double_pendulum")
    runs = laid(bound("dfki_c0", FOLDER, robot, ("run_03",), root=root), robot)
    right = errors(corrected(found), runs, 1.0)
    wrong = errors(moved_to_the_wrong_joint(corrected(found)), runs, 1.0)
    assert sum(wrong.values()) > sum(right.values())


def test_the_control_moves_what_was_found_and_nothing_else() -> None:
    robot = load_robot("double_pendulum")
    spec = spec_of(robot)
    CoulombFriction(joint="shoulder", c=0.1).edit(spec)
    spec.compile()
    delay = ActuatorDelay(actuator="elbow", T=0.01)
    stribeck = StribeckFriction(joint="elbow", c=0.02, s=0.05)
    found = Model(robot=from_mjcf(fulltext(spec)), effects=(delay, stribeck))
    moved = moved_to_the_wrong_joint(found)
    assert moved.effects == (delay, replace(stribeck, joint="shoulder"))
    before, after = (Simulator(model.robot).model for model in (found, moved))
    assert list(after.dof_frictionloss) == [0.0, 0.1] == list(before.dof_frictionloss)[::-1]
    assert np.array_equal(after.body_mass, before.body_mass)
    assert np.array_equal(after.dof_armature, before.dof_armature)


def test_no_held_out_run_is_fitted() -> None:
    for design in DESIGNS.values():
        opened = {*design.held_out, *(name for names, _ in design.also for name in names)}
        assert not opened & set(design.train)


def test_missing_recordings_are_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MORPH_RECORDINGS", str(tmp_path))
    assert main(["--quiet"]) == 2
    assert "the recordings are not there" in capsys.readouterr().err
