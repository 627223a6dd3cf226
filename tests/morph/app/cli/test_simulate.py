from __future__ import annotations

import inspect
import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import morph.app.cli.simulate
from morph.app.cli.main import main
from morph.app.cli.simulate_arguments import Simulate
from morph.body.load import load
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.store import effects_text
from morph.physics.worlds import world_names
from morph.policy.pattern import Swing, pattern
from morph.policy.store import write_policy
from morph.record.load import load_recordings
from morph.sim.simulator import Simulator

SCHEMA = json.loads(
    (Path(morph.app.cli.simulate.__file__).parent / "simulation.schema.json").read_text()
)
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")


@pytest.fixture(autouse=True)
def aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")


def done(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert main(["simulate", *arguments]) == status
    told = capsys.readouterr()
    assert told.err == ""
    return told.out


def refused(capsys: pytest.CaptureFixture[str], folder: Path, *arguments: str) -> re.Match[str]:
    """Return the one message of a command that must be refused and write nothing."""
    before = sorted(folder.rglob("*"))
    assert main(["simulate", *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    found = MESSAGE.fullmatch(told.err)
    assert found, told.err
    assert sorted(folder.rglob("*")) == before
    return found


@pytest.mark.parametrize("name", ["run.parquet", "run.csv", "run.csv.gz", "run.npz"])
def test_a_run_is_written_as_the_library_records_it(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = done(
        capsys,
        *("pendulum", "--seconds", "0.5", "--step", "0.005", "--start", "hinge=1"),
        *("--speed", "hinge=-2", "--command", "hinge=0.3", "--out", name),
        *("--effect", "viscous_friction@hinge:b=0.1", "--effect", "coulomb_friction@hinge:c=0.2"),
    )
    assert "under viscous_friction@hinge (b = 0.1 N m s/rad)\n" in words
    assert f"wrote {name} (recording)\n" in words
    effects = (ViscousFriction(joint="hinge", b=0.1), CoulombFriction(joint="hinge", c=0.2))
    due = Simulator(load("pendulum"), effects, step=0.005).run(
        seconds=0.5, start={"hinge": 1.0}, speed={"hinge": -2.0}, command={"hinge": 0.3}
    )
    (found,) = load_recordings(tmp_path / name, robot=load("pendulum"))
    assert found.name == "run"
    for channel in ("hinge.position", "hinge.velocity"):
        assert np.array_equal(found[channel], due[channel])


def test_json_is_by_its_schema_and_says_all_that_is_needed_to_do_it_again(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = done(
        capsys,
        *("hexapod_swimmer", "--seconds", "0.1", "--start", "hull.position.z=0.5", "--json"),
        *("--effect", "viscous_friction@left_front:b=0.1", "--out", "run.npz"),
    )
    content = json.loads(text)
    jsonschema.Draft202012Validator(SCHEMA).validate(content)
    assert content["robot"] == {
        "name": "hexapod_swimmer",
        "sha256": load("hexapod_swimmer").sha256,
    }
    assert content["effects"] == [
        {"name": "viscous_friction", "where": "left_front", "parameters": {"b": 0.1}}
    ]
    assert content["files"] == {"recording": "run.npz"}
    assert (content["seconds"], content["step"]) == (0.1, 0.002)
    assert content["channels"]["hull.position.z"]["first"] == 0.5
    # It falls for 0.1 s, leapfrog: 9.81 * 0.1 * (0.1 + 0.002) / 2 = 0.0500 m.
    last = content["channels"]["hull.position.z"]["last"]
    assert last == pytest.approx(0.5 - 0.5 * 9.81 * 0.1 * 0.102, abs=1e-6)


def test_effects_may_come_from_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    effect = ViscousFriction(joint="hinge", b=0.25)
    (tmp_path / "corrected.toml").write_text(effects_text((effect,)))
    asked = ("pendulum", "--seconds", "0.01", "--effects", "corrected.toml", "--json")
    content = json.loads(done(capsys, *asked))
    assert content["effects"] == [
        {"name": "viscous_friction", "where": "hinge", "parameters": {"b": 0.25}}
    ]


def test_a_policy_commands_and_a_command_overrules_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load("hexapod_swimmer")
    swing = Swing(amplitude=0.4, frequency=2.0)
    policy = pattern(robot, {each.name: swing for each in robot.actuators})
    write_policy(policy, tmp_path / "gait", robot)
    asked = ("hexapod_swimmer", "--policy", "gait", "--seconds", "0.3", "--out", "run.npz")
    words = done(capsys, *asked, "--command", "left_rear=-0.1")
    assert "commanded by gait" in words
    (found,) = load_recordings(tmp_path / "run.npz")
    for actuator, due in policy.commands().items():
        channel = found.channel(f"{actuator}.command")
        if actuator == "left_rear":
            assert set(channel.value) == {-0.1}
        else:
            # Commands are stamped half a step of 2 ms before.
            told = np.r_[0.0, channel.time[1:] + 0.001]
            assert channel.value == pytest.approx(due(told), abs=1e-6)
    assert np.ptp(found["right_rear.command"]) > 0.5


def test_commands_are_of_the_episode_that_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    for name, torque in (("low", 0.1), ("high", 0.3)):
        rows = "".join(f"{0.1 * at:.1f},{torque}\n" for at in range(12))
        (logs / f"{name}.csv").write_text("time,hinge.command\n" + rows)
    asked = ("pendulum", "--seconds", "0.3", "--out", "run.npz", "--commands", "logs")
    for name, torque in (("low", 0.1), ("high", 0.3)):
        done(capsys, *asked, "--only", name)
        (found,) = load_recordings(tmp_path / "run.npz")
        assert set(found["hinge.command"]) == {torque}
        (tmp_path / "run.npz").unlink()
    message = refused(capsys, tmp_path, *asked)
    assert message["what"] == "it holds 2 recordings: high, low"
    assert "--only" in message["fix"]
    alone = ("pendulum", "--seconds", "0.3", "--out", "run.npz", "--only", "low")
    assert "--commands" in refused(capsys, tmp_path, *alone)["fix"]
    assert "0 recordings called 'lo'" in refused(capsys, tmp_path, *asked, "--only", "lo")["what"]


def test_an_unstable_run_stops_short_and_keeps_what_came_before(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # w h = sqrt(205 / 0.251) * 0.075 = 2.14, and a leapfrog is stable only below 2: a little
    # beyond it grows by e^(2 acosh(1.07)) = 2.1 a step, which takes 30 steps to 1e10.
    asked = ("pendulum", "--step", "0.075", "--seconds", "20", "--start", "hinge=1")
    effect = ("--effect", "joint_stiffness@hinge:k=200", "--out", "run.npz")
    words = " ".join(done(capsys, *asked, *effect, status=3).split())
    assert "of 20 s: the simulation became unstable" in words
    content = json.loads(done(capsys, *asked, *effect, "--json", status=3))
    jsonschema.Draft202012Validator(SCHEMA).validate(content)
    assert content["stopped_short"] == "the simulation became unstable"
    (found,) = load_recordings(tmp_path / "run.npz")
    assert found.end == content["seconds"] < 20.0


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("pendulum", "--effect", "magic@hinge"), "there is no effect 'magic'"),
        (("pendulum", "--start", "hinge"), "'hinge' is no NAME=VALUE with a finite number"),
        (("pendulum", "--start", "hinge=up"), "'hinge=up' is no NAME=VALUE"),
        (("pendulum", "--speed", "=1"), "'=1' is no NAME=VALUE"),
        (("pendulum", "--command", "hinge=nan"), "'hinge=nan' is no NAME=VALUE"),
        (("pendulum", "--start", "hinge=1", "--start", "hinge=2"), "hinge is given twice"),
        (("pendulum", "--start", "knee=1"), "there is no joint 'knee'"),
        (("pendulum", "--command", "knee=1"), "there is no actuator 'knee'"),
        (("pendulum", "--seconds", "-1"), "a run of -1.0 s is out of range"),
        (("pendulum", "--seconds", "nan"), "a run of nan s is out of range"),
        (("pendulum", "--step", "0"), "a step of 0.0 s is out of range"),
        (("nowhere",), "nowhere"),
        (("pendulum", "--policy", "none"), "none"),
        (("pendulum", "--effects", "none.toml"), "cannot be read"),
        (("pendulum", "--out", "run.txt"), "'run.txt' does not say which kind of file"),
        (("pendulum", "--out", ""), "'' does not say which kind of file"),
        (("pendulum", "--video", "run.avi"), "'run.avi' does not say which kind of file"),
        (("pendulum", "--video", ".mp4"), "'.mp4' does not say which kind of file"),
        (("pendulum", "--out", "folder.csv"), "this is a folder"),
        (("pendulum", "--out", "file/run.csv"), "nothing can be written there"),
    ],
)
def test_what_cannot_be_used_is_refused_with_one_message(
    arguments: tuple[str, ...], what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "file").touch()
    found = refused(capsys, tmp_path, *arguments)
    assert what in found["where"] + ": " + found["what"]


def test_a_body_without_a_joint_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "box.xml").write_text(
        "<mujoco><worldbody><body name='a'><geom size='0.1'/></body></worldbody></mujoco>"
    )
    found = refused(capsys, tmp_path, "box.xml", "--out", "run.csv")
    assert "neither a joint" in found["what"]


def test_an_interrupt_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("morph.app.picture.video.film", interrupted)
    asked = ["simulate", "pendulum", "--seconds", "0.1", "--out", "a.csv", "--video", "a.gif"]
    assert main(asked) == 130
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert list(tmp_path.iterdir()) == []


def test_many_channels_are_counted_rather_than_listed(capsys: pytest.CaptureFixture[str]) -> None:
    words = done(capsys, "humanoid", "--seconds", "0.01")
    # 7 of the pelvis and 25 joints; 24 are shown.
    assert "\n... and 8 more; --json lists all\n" in words
    assert max(map(len, words.splitlines())) <= 80


def test_the_help_names_every_world() -> None:
    text = inspect.getsource(Simulate).split("world: ")[1].split('"""')[1]
    assert text == f"Where it moves: {', '.join(world_names())}."


def test_a_start_within_the_floor_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("hexapod_swimmer", "--world", "hard_floor", "--seconds", "0.01")
    within = done(capsys, *asked, "--posture", "rest")
    assert "hull and floor 60 mm within each other" in " ".join(within.split())
    # By itself it starts on the floor.
    content = json.loads(done(capsys, *asked, "--json"))
    assert content["notes"] == []
