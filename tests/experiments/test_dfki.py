from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.dfki import (
    CORRECTED,
    DESIGNS,
    FOLDER,
    HELD_BY_JOINT,
    NOMINAL,
    PUBLISHER,
    SYSID,
    SYSID_FIXED,
    main,
    moved_to_the_wrong_joint,
    rivals,
    scores,
)
from experiments.openloop import Model, bound, corrected, errors, from_mjcf, laid
from morph.body.fulltext import fulltext
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import Episode
from morph.model.split import between
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.record.recording import Recording
from morph.sim.simulator import Simulator

ROBOT = load_robot("double_pendulum")


@pytest.fixture(scope="module")
def runs(recordings: Path) -> list[Recording]:
    """Two runs of the rig, and one that is held out."""
    return bound("dfki_c0", FOLDER, ROBOT, ("run_00", "run_01", "run_03"), root=recordings)


@pytest.fixture(scope="module")
def slice_of_c0(runs: list[Recording]) -> tuple[Diagnosis, list[Episode]]:
    # Six seconds of each: the study fits all of four runs.
    train = [between(run, run.start, run.start + 6.0) for run in runs[:2]]
    found = diagnose(ROBOT, train, held_out=runs[2:], horizon=1.0)
    return found, laid(runs[2:], ROBOT)


def test_two_runs_of_the_rig_are_enough_to_name_dry_friction_at_a_joint(
    slice_of_c0: tuple[Diagnosis, list[Episode]],
) -> None:
    found, _ = slice_of_c0
    # Belts and teeth shake it by more than an encoder's noise, and have no name.
    assert found.verdict == "unknown"
    labels = {finding.effect.label for finding in found.findings}
    assert labels & {"coulomb_friction@shoulder", "coulomb_friction@elbow"}


def test_the_model_rebuilt_from_what_is_written_scores_as_the_diagnosis_says(
    slice_of_c0: tuple[Diagnosis, list[Episode]],
) -> None:
    found, aside = slice_of_c0
    rebuilt = errors(corrected(found), aside, 1.0)
    for joint, value in rebuilt.items():
        # Text at full precision and the same steps: what differs is rounding.
        assert value == pytest.approx(
            found.held_out_rmse["corrected"][f"{joint}.position"], rel=1e-6
        )


def test_without_the_friction_that_was_found_a_run_is_predicted_worse(
    slice_of_c0: tuple[Diagnosis, list[Episode]],
) -> None:
    found, aside = slice_of_c0
    # Its levels are alike at both joints, so that those of the other joint would do as well.
    friction = replace(corrected(found), effects=())
    spec = spec_of(friction.robot)
    for joint in spec.joints:
        joint.frictionloss = 0.0
    spec.compile()
    without = errors(replace(friction, robot=from_mjcf(fulltext(spec))), aside, 1.0)
    assert sum(without.values()) > 1.2 * sum(errors(friction, aside, 1.0).values())


def test_the_control_moves_what_was_found_and_nothing_else() -> None:
    spec = spec_of(ROBOT)
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
    assert "files of dfki_double_pendulum are not there" in capsys.readouterr().err


def test_the_incumbent_told_that_friction_is_known_moves_the_rest_alone(
    monkeypatch: pytest.MonkeyPatch, runs: list[Recording]
) -> None:
    given = []

    def fitted(robot: Robot, runs: Sequence[Episode], *, fixed: Sequence[str]) -> tuple:
        given.append((Simulator(robot).model.dof_frictionloss.tolist(), tuple(fixed)))
        return Model(robot=robot), {}

    monkeypatch.setattr("experiments.dfki.by_sysid", fitted)
    models, told = rivals("C.0", ROBOT, runs[:1])
    # Published: 0.093 pi / 2 and 0.078 pi / 2 N m.
    assert given[0] == ([0.0, 0.0], ())
    assert given[1] == (pytest.approx([0.14608, 0.12252], abs=1e-5), HELD_BY_JOINT)
    levels = Simulator(models["published factors read as levels"].robot).model.dof_frictionloss
    assert list(levels) == [0.093, 0.078]
    assert list(told) == [SYSID, SYSID_FIXED]


def test_every_row_says_how_many_times_the_corrected_error_it_has(
    slice_of_c0: tuple[Diagnosis, list[Episode]], recordings: Path
) -> None:
    found, _ = slice_of_c0
    models = {NOMINAL: Model(robot=ROBOT), CORRECTED: corrected(found)}
    score = scores("C.0", models, found, ("run_03",), 1.0, recordings)
    assert PUBLISHER in score["rmse"]
    for title, row in score["rmse"].items():
        for joint, value in row.items():
            times = score["times_corrected"][title][joint]
            assert times * score["rmse"][CORRECTED][joint] == pytest.approx(value)
