from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError, RecordingError
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.model.split import between
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.recording import Recording

Recorded = Callable[..., Recording]


def runs(pendulum: Robot, recorded: Recorded, *effects: Effect) -> list[Recording]:
    """Return 3 episodes of 4 s at 200 Hz, driven at 1 N m through swings of about 1 rad."""

    def command(k: int) -> Callable[[Array], Array]:
        return lambda times: np.sin((2.0 + 0.5 * k) * times) + 0.4 * np.sin(9.0 * times)

    return [
        recorded(
            pendulum,
            *effects,
            start={"hinge": 0.8 - 0.3 * k},
            command=command(k),
            seed=k,
            name=f"run_{k}",
        )
        for k in range(3)
    ]


def consistent_with_itself(found: Diagnosis) -> None:
    """Check what every diagnosis promises."""
    # Numbers of any size, but numbers: NaN and infinity are no JSON.
    written = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert written["schema"] == "morph.diagnosis/1"
    assert not set(found.train) & set(found.held_out)
    assert all(0.0 <= p <= 1.0 for p in found.probabilities.values())
    for finding in found.findings:
        for estimate in finding.parameters.values():
            assert estimate.low90 <= estimate.value <= estimate.high90


def test_dry_friction_is_found_named_and_measured(pendulum: Robot, recorded: Recorded) -> None:
    first, *others = runs(pendulum, recorded, CoulombFriction(joint="hinge", c=0.05))
    # Of the first the motor's effort was logged, and no command.
    channels = dict(first.channels)
    channels["hinge.effort"] = channels.pop("hinge.command")
    found = diagnose(pendulum, [replace(first, channels=channels), *others], seed=0)
    consistent_with_itself(found)
    assert any("the effort measured at its joint is taken for it" in note for note in found.notes)
    assert found.verdict == "mismatch"
    assert [finding.effect.label for finding in found.findings] == ["coulomb_friction@hinge"]
    # Encoders see 2e-4 rad of swings of 1 rad, and 0.05 N m takes 1 % of 4.9 N m in each.
    # What limits it is the half step of 0.25 ms by which commands are centred. 10 %.
    assert found.findings[0].parameters["c"].value == pytest.approx(0.05, rel=0.1)
    assert found.train == ("run_0", "run_1")
    assert found.held_out == ("run_2",)
    rmse = {model: by["hinge.position"] for model, by in found.held_out_rmse.items()}
    assert rmse["corrected"] < 0.7 * min(rmse["nominal"], rmse["refitted"])
    assert found.improvement_low90 > 0.0
    assert "frictionloss" in found.corrected


def test_a_recording_of_the_robot_as_described_is_consistent(
    pendulum: Robot, recorded: Recorded
) -> None:
    found = diagnose(pendulum, runs(pendulum, recorded), seed=0)
    consistent_with_itself(found)
    assert found.verdict == "consistent"
    assert found.findings == ()
    assert max(found.probabilities, key=lambda name: found.probabilities[name]) == "none"


def rod(damping: float) -> str:
    """Return a driven rod of 1 kg with a damped hinge."""
    return f'''<mujoco model="rod"><compiler angle="radian"/><worldbody><body name="rod">
        <joint name="hinge" axis="0 1 0" damping="{damping}"/>
        <inertial pos="0 0 -0.4" mass="1" diaginertia="0.02 0.02 0.02"/></body></worldbody>
        <actuator><motor name="motor" joint="hinge" ctrlrange="-9 9"/></actuator></mujoco>'''


def test_damping_that_is_described_too_great_is_told(
    body: Callable[[str], Robot], recorded: Recorded
) -> None:
    found = diagnose(body(rod(0.4)), runs(body(rod(0.05)), recorded), seed=0)
    consistent_with_itself(found)
    assert found.findings == ()
    # 0.05 of 0.4 is 0.125. Readings of 0.2 mrad tell 0.05 N m s/rad at 2 rad/s to a few per cent;
    # that masses and the gain may all be a tenth too great scales all forces alike: 15 %.
    assert found.refit["damping:hinge"].value == pytest.approx(0.125, rel=0.15)
    assert [s for s in found.summary() if "damping of joint hinge is too great" in s]
    rmse = {model: by["hinge.position"] for model, by in found.held_out_rmse.items()}
    assert rmse["corrected"] < 0.1 * rmse["nominal"]


def test_a_command_of_the_wrong_sign_is_named(pendulum: Robot, recorded: Recorded) -> None:
    wrong = []
    for each in runs(pendulum, recorded):
        sent = each.channel("hinge.command")
        turned = replace(sent, value=-sent.value)
        wrong.append(replace(each, channels={**each.channels, "hinge.command": turned}))
    found = diagnose(pendulum, wrong, seed=0)
    consistent_with_itself(found)
    assert [finding.effect.label for finding in found.findings] == ["torque_scale@hinge"]
    # Swings of 1 rad in 0.2 mrad, of which half is driven: a gain to a thousandth or so, and masses
    # that may be a tenth too great beside it.
    assert found.findings[0].parameters["gain"].value == pytest.approx(-1.0, rel=0.11)
    assert "the other way" in found.findings[0].statement


@pytest.fixture(scope="module")
def run(pendulum: Robot, recorded: Recorded) -> Recording:
    return recorded(pendulum, start={"hinge": 0.5}, command=lambda times: np.sin(5.0 * times))


def test_nothing_to_fit_is_refused(pendulum: Robot) -> None:
    with pytest.raises(DiagnosisError, match="no recording to fit") as caught:
        diagnose(pendulum, [])
    assert caught.value.where == "the recordings"
    assert caught.value.fix


@pytest.mark.parametrize(
    ("setting", "what", "where"),
    [
        ({"horizon": math.nan}, "a horizon of nan s", "--horizon"),
        ({"horizon": math.inf}, "a horizon of inf s", "--horizon"),
        ({"horizon": 0.05}, r"a horizon of 0\.05 s", "--horizon"),
        ({"budget": 0.0}, "the budget is 0 s", "--budget"),
        ({"budget": math.nan}, "the budget is nan s", "--budget"),
        ({"vary": {"weight": 0.1}}, "--vary weight", "robot pendulum"),
    ],
)
def test_a_setting_out_of_range_is_refused(
    pendulum: Robot, run: Recording, setting: dict[str, Any], what: str, where: str
) -> None:
    with pytest.raises(DiagnosisError, match=what) as caught:
        diagnose(pendulum, [run], **setting)
    assert caught.value.where == where
    assert caught.value.fix


def test_a_recording_too_short_to_show_anything_is_refused(pendulum: Robot, run: Recording) -> None:
    short, rest = between(run, 1.0, 1.4), replace(between(run, 1.5, 4.0), name="rest")
    with pytest.raises(DiagnosisError, match=r"one without gaps takes 0\.5 s") as caught:
        diagnose(pendulum, [short], held_out=[rest])
    assert caught.value.where == "run"
    # Beside longer ones it is left out, and told.
    whole = replace(between(run, 0.0, 1.0), name="whole")
    found = diagnose(pendulum, [short, rest], held_out=[whole])
    assert found.train == ("rest",)
    assert [note for note in found.notes if note.startswith("run: left out")]


@pytest.mark.parametrize("missing", ["hinge.command", "hinge.position"])
def test_a_missing_channel_is_named(pendulum: Robot, run: Recording, missing: str) -> None:
    channels = {name: c for name, c in run.channels.items() if name != missing}
    with pytest.raises(RecordingError, match=f"no channel '{missing}'") as caught:
        diagnose(pendulum, [replace(run, channels=channels)])
    assert caught.value.where == "recording run"
    assert "bind " in caught.value.fix


def test_a_copy_of_what_is_fitted_cannot_be_held_out(pendulum: Robot, run: Recording) -> None:
    copy = replace(run, name="copy")
    with pytest.raises(RecordingError, match="'run' and 'copy' are identical"):
        diagnose(pendulum, [run], held_out=[copy])


def test_a_copy_among_the_fitted_is_left_out_and_told(pendulum: Robot, run: Recording) -> None:
    found = diagnose(pendulum, [run, replace(run, name="copy")], budget=0.5)
    assert any("recording 'copy' is identical to 'run'" in note for note in found.notes)
    assert "copy" not in (*found.train, *found.held_out)


def test_linear_algebra_has_one_thread(
    pendulum: Robot, recorded: Recorded, monkeypatch: pytest.MonkeyPatch
) -> None:
    def looked(*_: Any, **__: Any) -> None:
        raise InterruptedError({each["num_threads"] for each in threadpool_info()})

    monkeypatch.setattr("morph.inference.diagnose.ranked", looked)
    with threadpool_limits(2), pytest.raises(InterruptedError) as caught:
        diagnose(pendulum, runs(pendulum, recorded))
    assert caught.value.args == ({1},)


def test_a_braked_joint_accuses_no_link(arm: Callable[..., Robot], recorded: Recorded) -> None:
    # The brake holds the elbow, whose encoder toggles between two counts.
    braked, described = arm(elbow='armature="1e6"'), arm()
    rng, taken = np.random.default_rng(3), []
    for k in range(3):
        run = recorded(
            braked,
            start={"shoulder": 1.2 - 0.3 * k, "elbow": 0.5},
            command=lambda times, k=k: 4.0 * np.sin((2.0 + k) * times),
            seed=k,
            name=f"run_{k}",
            seconds=2.0,
        )
        elbow = run.channel("elbow.position")
        counts = 0.5 + 2.0 * np.pi / 4096.0 * rng.integers(0, 2, len(elbow.value))
        channels = {**run.channels, "elbow.position": replace(elbow, value=counts)}
        taken.append(replace(run, channels=channels))
    found = diagnose(described, taken)
    assert not found.findings
    assert any("Joint elbow does not move" in note for note in found.notes)
    # An elbow that were free would fall; held, it is off by no more than a count, 1.5e-3 rad.
    assert found.held_out_rmse["corrected"]["elbow.position"] < 2e-3
    # The brake is no part of the model that is written.
    model = mujoco.MjModel.from_xml_string(found.corrected)
    assert model.dof_armature.max() < 1.0
