"""`morph excite` writes commands that a diagnosis of what they cause can use."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from morph.app.cli import excite
from morph.app.cli.main import main
from morph.body.load import load
from morph.record.load import load_recordings

SCHEMA = json.loads(Path(excite.__file__).with_name("experiment.schema.json").read_text())
TWO = ["--separate", "coulomb_friction@hinge", "viscous_friction@hinge"]

Out = pytest.CaptureFixture[str]


def test_two_laws_are_told_apart_by_commands_within_limits(tmp_path: Path, capsys: Out) -> None:
    out = tmp_path / "plan"
    assert main(["excite", "pendulum", *TWO, "--out", str(out), "--json", "--quiet"]) == 0
    said = json.loads(capsys.readouterr().out)
    jsonschema.validate(said, SCHEMA)
    assert said == json.loads((out / "experiment.json").read_text())
    assert sorted(path.name for path in out.iterdir()) == ["experiment.json", "run_1.csv"]
    assert {(each["law"], each["rival"]) for each in said["separations"]} == {
        ("coulomb_friction@hinge", "viscous_friction@hinge"),
        ("viscous_friction@hinge", "coulomb_friction@hinge"),
    }
    assert all(each["power"] > 0.9 for each in said["separations"])
    robot = load("pendulum")
    (run,) = load_recordings(out / "run_1.csv", robot=robot)
    limit = robot.actuators[0].limit
    assert limit is not None
    assert np.abs(run["hinge.command"]).max() <= limit
    assert run.end - run.start == pytest.approx(said["runs"][0]["seconds"], abs=0.01)


def test_what_is_planned_can_be_simulated_and_diagnosed(tmp_path: Path, capsys: Out) -> None:
    plan, run, found = tmp_path / "plan", tmp_path / "run.csv", tmp_path / "found"
    assert main(["excite", "pendulum", *TWO, "--out", str(plan), "--quiet"]) == 0
    said = capsys.readouterr().out
    assert f"morph simulate pendulum --commands {plan / 'run_1.csv'} --seconds" in said
    seconds = json.loads((plan / "experiment.json").read_text())["runs"][0]["seconds"]
    simulate = ["simulate", "pendulum", "--commands", str(plan / "run_1.csv"), "--quiet"]
    law = "viscous_friction@hinge:b=0.05"
    assert main([*simulate, "--seconds", str(seconds), "--effect", law, "--out", str(run)]) == 0
    diagnose = ["diagnose", "pendulum", str(run), "--out", str(found), "--horizon", "1"]
    capsys.readouterr()
    assert main([*diagnose, "--quiet"]) == 0
    said = capsys.readouterr().out
    diagnosis = json.loads((found / "diagnosis.json").read_text())
    assert [each["effect"] for each in diagnosis["findings"]] == ["viscous_friction"]
    # What it may be taken for is named, with the experiment that tells.
    (line,) = [line for line in said.splitlines() if "to plan how to tell them apart" in line]
    words = shlex.split(line.partition(": ")[2])
    name, _, size = words[4].rpartition("=")
    assert name == "viscous_friction@hinge:b"
    # Readings without noise, and a step of 2 ms beside one of 4 ms in the fit.
    assert float(size) == pytest.approx(0.05, rel=0.05)
    rival = diagnosis["findings"][0]["rivals"][0]
    assert words[5] == f"{rival['effect']}@{rival['where']['name']}"
    again = [str(tmp_path / "again") if word == "DIR" else word for word in words[1:]]
    assert main([*again, "--quiet"]) == 0


def test_a_plan_for_everything_lists_what_it_cannot_show(tmp_path: Path, capsys: Out) -> None:
    out = tmp_path / "plan"
    words = ["excite", "pendulum", "--for-everything", "--seconds", "6", "--out", str(out)]
    assert main([*words, "--quiet"]) == 0
    said = capsys.readouterr().out
    separations = json.loads((out / "experiment.json").read_text())["separations"]
    shown = {each["law"]: each["power"] >= 0.9 for each in separations if each["rival"] == "none"}
    (hinge,) = [line for line in said.splitlines() if line.startswith("  hinge: shows ")]
    shows, hides = (
        part.split(", ") for part in hinge.partition("shows ")[2].split("; does not show ")
    )
    assert {f"{law}@hinge": True for law in shows} | {f"{law}@hinge": False for law in hides} == {
        law: enough for law, enough in shown.items() if law.endswith("@hinge")
    }
    alike = [
        line.removeprefix("  look alike: ").split(" and ")
        for line in said.splitlines()
        if "look alike" in line
    ]
    assert alike
    assert all(shown[law] for pair in alike for law in pair)
    # On one hinge a link's inertia and a rotor's are one figure.
    armature = next(e for e in separations if (e["law"], e["rival"]) == ("armature@hinge", "none"))
    assert armature["power"] < 0.5
    assert "armature" in hides


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ([], "it is not said what the experiment is to show"),
        ([*TWO, "--for-everything"], "two laws and every law are asked for at once"),
        (["--separate", "coulomb_friction@hinge", "nothing"], "there is no effect 'nothing'"),
        (["--separate", "coulomb_friction@hinge"], "and 1 are given"),
        (["--separate", "cogging@hinge", "cogging@hinge"], "of different ones there are 1"),
        ([*TWO, "--seconds", "0.1"], "0.1 is out of range"),
        ([*TWO, "--noise", "nan"], "nan is out of range"),
        ([*TWO, "--seed", "-1"], "a seed of -1 is below 0"),
        (["--separate", "external_push@rod", "cogging@hinge"], "comes from outside"),
        ([*TWO, "--vary", "mass"], "'mass' is no NAME=FRACTION"),
    ],
)
def test_what_cannot_be_planned_is_refused(
    words: list[str], what: str, tmp_path: Path, capsys: Out
) -> None:
    out = tmp_path / "plan"
    assert main(["excite", "pendulum", *words, "--out", str(out), "--quiet"]) == 2
    assert what in capsys.readouterr().err
    assert not out.exists()


BODY = """<mujoco><worldbody><body>%s<geom size="0.1"/></body></worldbody>%s</mujoco>"""
MOTOR = '<actuator><motor name="m" joint="j"%s/></actuator>'


@pytest.mark.parametrize(
    ("joint", "actuator", "what"),
    [
        ('<joint name="j"/>', "", "it has no actuator"),
        ('<joint name="j"/>', MOTOR % "", "actuator m has no limit within which"),
        ('<freejoint name="j"/>', MOTOR % ' ctrlrange="-1 1"', "falls freely"),
        (
            '<joint name="j" type="slide" axis="0 0 1" range="-0.01 0.01"/>',
            MOTOR % ' ctrlrange="-1 1"',
            "no motion from home is safe",
        ),
        ('<joint name="j"/>', MOTOR % ' gear="0" forcerange="-1 1"', "no law acts"),
        (
            '<joint name="j"/>',
            '<actuator><general name="m" joint="j" dyntype="filter" dynprm="0.1" '
            'ctrlrange="-1 1"/></actuator>',
            "actuator m has a state of its own",
        ),
        (
            '<joint name="j" range="-2 2"/>',
            '<actuator><position name="m" joint="j" kp="5" ctrlrange="0.5 1.5"/></actuator>',
            "actuator m cannot be told to stay at home: its commands go from 0.5 to 1.5",
        ),
    ],
)
def test_a_robot_that_cannot_be_excited_is_refused(
    joint: str, actuator: str, what: str, tmp_path: Path, capsys: Out
) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(BODY % (joint, actuator))
    words = ["excite", str(path), "--for-everything", "--out", str(tmp_path / "plan"), "--quiet"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert what in said
    assert "fix: " in said


def test_laws_of_commands_are_planned_for(tmp_path: Path, capsys: Out) -> None:
    two = ["--separate", "actuator_delay@hinge:T=0.03", "actuator_lag@hinge"]
    out = str(tmp_path / "plan")
    assert main(["excite", "pendulum", *two, "--out", out, "--json", "--quiet"]) == 0
    said = json.loads(capsys.readouterr().out)["separations"]
    assert {each["law"]: each["size"] for each in said}["actuator_delay@hinge"] == {"T": 0.03}
    assert all(each["nats"] > 0.0 for each in said)


def test_a_one_sided_motor_idles_at_none(tmp_path: Path) -> None:
    path, out = tmp_path / "robot.xml", tmp_path / "plan"
    path.write_text(BODY % ('<joint name="j" damping="0.1"/>', MOTOR % ' ctrlrange="0 0.4"'))
    words = ["excite", str(path), "--for-everything", "--seconds", "5", "--out", str(out)]
    assert main([*words, "--quiet"]) == 0
    told = [load_recordings(each)[0]["m.command"] for each in sorted(out.glob("run_*.csv"))]
    assert min(each.min() for each in told) == 0.0
    assert max(each.max() for each in told) <= 0.4


def test_a_folder_of_something_else_is_not_touched(tmp_path: Path, capsys: Out) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    assert main(["excite", "pendulum", *TWO, "--out", str(tmp_path), "--quiet"]) == 2
    assert "holds no earlier experiment" in capsys.readouterr().err
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_a_diagnosis_says_what_a_plan_lacks_where_an_actuator_has_no_range(
    tmp_path: Path, capsys: Out
) -> None:
    robot, run = tmp_path / "rod.xml", tmp_path / "run.csv"
    robot.write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02" mass="0.5"/></body></worldbody>'
        '<actuator><motor name="motor" joint="hinge"/></actuator></mujoco>'
    )
    law = ["--effect", "viscous_friction@hinge:b=0.02"]
    simulate = ["simulate", str(robot), "--start", "hinge=1", "--seconds", "8", *law]
    assert main([*simulate, "--out", str(run), "--quiet"]) == 0
    capsys.readouterr()
    assert main(["diagnose", str(robot), str(run), "--out", str(tmp_path / "d"), "--quiet"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "to plan how" in line]
    assert "give it a ctrlrange" in line
    assert "actuator motor has no limit" in line
