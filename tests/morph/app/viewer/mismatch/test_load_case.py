"""What was given is checked before anything is served."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from morph.app.viewer.mismatch.load_case import load_case
from morph.app.viewer.view_request import ViewRequest
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import EffectError, MorphError, RecordingError, ViewError
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.record.recording import Recording
from morph.record.write import write

RUBBING = CoulombFriction(joint="hinge", c=0.2)


@pytest.fixture
def given(
    pendulum: Robot, swung: Callable[..., Recording], tmp_path: Path
) -> Callable[..., ViewRequest]:
    """Makes what was given: a run of the pendulum, and what is changed of it."""

    def made(**changes: object) -> ViewRequest:
        path = tmp_path / "run.npz"
        if not path.exists():
            write(swung(seconds=2.0), path)
        whole = ViewRequest(robots=(pendulum,), asked=("pendulum",), recordings=(path,))
        return replace(whole, **changes)  # type: ignore[arg-type]

    return made


def test_a_recording_of_another_robot_is_refused_with_the_nearest_names(
    given: Callable[..., ViewRequest],
) -> None:
    with pytest.raises(RecordingError, match=r"names no .* of cartpole; its .* are") as caught:
        load_case(given(robots=(load("cartpole"),)))
    assert "nearest" in caught.value.fix


def test_a_file_that_is_not_there_is_refused_by_its_name(
    given: Callable[..., ViewRequest], tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=r"nowhere\.npz"):
        load_case(given(recordings=(tmp_path / "nowhere.npz",)))


def test_a_recording_that_tells_of_no_joint_is_refused(
    given: Callable[..., ViewRequest], swung: Callable[..., Recording], tmp_path: Path
) -> None:
    run = swung(seconds=1.0)
    channels = {"hinge.command": run.channel("hinge.command")}
    write(replace(run, channels=channels), tmp_path / "told.npz")
    with pytest.raises(ViewError, match=r"tells of no joint of pendulum") as caught:
        load_case(given(recordings=(tmp_path / "told.npz",)))
    assert "hinge.position" in caught.value.fix


def test_two_recordings_of_one_name_are_refused(
    given: Callable[..., ViewRequest], swung: Callable[..., Recording], tmp_path: Path
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    write(swung(seconds=1.0), other / "run.npz")
    first = given().recordings[0]
    with pytest.raises(ViewError, match=r"several recordings are called run"):
        load_case(given(recordings=(first, other / "run.npz")))


def test_a_diagnosis_alone_asks_for_its_recordings_by_its_own_command(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    with pytest.raises(ViewError, match=r"morph diagnose pendulum runs/train\.npz") as caught:
        load_case(given(recordings=(), diagnosis=folder))
    assert "--recording" in caught.value.fix


def test_a_folder_without_a_diagnosis_is_refused(
    given: Callable[..., ViewRequest], tmp_path: Path
) -> None:
    with pytest.raises(ViewError, match=r"diagnosis\.json.*No such file"):
        load_case(given(diagnosis=tmp_path))


def test_a_diagnosis_of_another_robot_is_refused(
    given: Callable[..., ViewRequest], diagnosis_of: Callable[..., Path]
) -> None:
    cartpole = load("cartpole")
    folder = diagnosis_of(cartpole)
    with pytest.raises(ViewError, match=r"corrects another robot: its joints are .*those of pend"):
        load_case(given(diagnosis=folder))


def test_a_finding_at_a_part_that_is_not_there_is_refused(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    path = folder / "diagnosis.json"
    path.write_text(path.read_text().replace('"name": "hinge"', '"name": "elbow"'))
    with pytest.raises(ViewError, match=r"coulomb_friction@elbow concerns a part that pendulum"):
        load_case(given(diagnosis=folder))


def test_another_version_of_the_description_is_told_not_refused(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    assert load_case(given(diagnosis=folder)).notes == ()
    content = json.loads((folder / "diagnosis.json").read_text())
    content["provenance"]["robot_sha256"] = "0" * 64
    content["provenance"]["recordings_sha256"] = {"run": "0" * 64}
    (folder / "diagnosis.json").write_text(json.dumps(content))
    notes = load_case(given(diagnosis=folder)).notes
    assert any("another version of this description" in note for note in notes)
    assert any("other files called run" in note for note in notes)


def test_effects_beside_the_corrected_model_act_in_it(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    hard = StribeckFriction(joint="hinge")
    case = load_case(given(diagnosis=diagnosis_of(pendulum, hard)))
    assert case.models[1].effects == (hard,)
    assert case.findings == (hard,)


def test_a_spoilt_corrected_model_is_refused_by_its_name(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    whole = (folder / "corrected.xml").read_text()
    for spoilt in ("", "<mujoco", whole[:300], "\0" * 50, "<mujoco><include file='/etc/passwd'/>"):
        (folder / "corrected.xml").write_text(spoilt)
        with pytest.raises(ViewError, match=r"corrected\.xml"):
            load_case(given(diagnosis=folder))
    (folder / "corrected.xml").write_text(whole)
    (folder / "corrected.toml").write_text("schema = 3")
    with pytest.raises(EffectError, match=r"corrected\.toml"):
        load_case(given(diagnosis=folder))


@pytest.mark.parametrize(
    "spoilt",
    [
        "",
        "[]",
        "null",
        "{" * 100_000,
        '{"schema": "morph.diagnosis/2"}',
        '{"schema": "morph.diagnosis/1", "fit": 3}',
        '{"schema": "morph.diagnosis/1", "fit": {"horizon_s": 1e999}, "provenance": {}}',
        '{"schema": "morph.diagnosis/1", "fit": {"horizon_s": -1}, "provenance": {}}',
        '{"schema": "morph.diagnosis/1", "fit": {"horizon_s": true}, "provenance": {}}',
        '{"schema": "morph.diagnosis/1", "fit": {"horizon_s": '
        + "9" * 4000
        + '}, "provenance":{}}',
    ],
)
def test_a_spoilt_diagnosis_is_refused_in_a_sentence(
    given: Callable[..., ViewRequest],
    pendulum: Robot,
    diagnosis_of: Callable[..., Path],
    spoilt: str,
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    (folder / "diagnosis.json").write_text(spoilt)
    with pytest.raises(ViewError, match=r"diagnosis\.json"):
        load_case(given(diagnosis=folder))


def test_every_key_of_a_diagnosis_may_be_spoilt_without_a_traceback(
    given: Callable[..., ViewRequest], pendulum: Robot, diagnosis_of: Callable[..., Path]
) -> None:
    folder = diagnosis_of(pendulum, RUBBING)
    path = folder / "diagnosis.json"
    whole = json.loads(path.read_text())
    known = given(diagnosis=folder)
    refused = 0
    for place in places(whole):
        for value in (None, -1, "x", [3], {"a": None}):
            path.write_text(json.dumps(changed(whole, place, value)))
            try:
                load_case(known)
            except MorphError:
                refused += 1
    # Of some forty places most matter; a text may be any text, a probability any number.
    assert refused > 80


def places(content: object, at: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Return the way to every value of JSON."""
    found = [at] if at else []
    if isinstance(content, dict):
        for key, value in content.items():
            found += places(value, (*at, key))
    elif isinstance(content, list):
        for number, value in enumerate(content):
            found += places(value, (*at, number))
    return found


def changed(content: object, at: tuple[str | int, ...], value: object) -> object:
    """Return JSON with one value changed."""
    copy = json.loads(json.dumps(content))
    inner = copy
    for key in at[:-1]:
        inner = inner[key]
    inner[at[-1]] = value
    return copy
