"""The gate judges by itself: what a robot can do, what is absurd, what a message proposes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.own_robots.absurd import absurd_motion, absurd_policy
from experiments.own_robots.applies import abilities
from experiments.own_robots.drawn import MASSES, drawn
from experiments.own_robots.outcome import Outcome, outcome
from experiments.own_robots.pushed import stands_pushed
from morph.body import shelf
from morph.body.load import load
from morph.policy.pattern import Swing, pattern
from morph.policy.store import write_policy
from morph.record.write import write
from morph.sim.simulator import Simulator

PENDULUM = """<mujoco model="swing"><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02" mass="1"/></body></worldbody>
<actuator><motor name="m" joint="hinge" ctrlrange="-1 1"/></actuator></mujoco>"""


@pytest.mark.parametrize("seed", range(20))
def test_a_drawn_robot_compiles_and_weighs_what_it_may(seed: int, tmp_path: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(drawn(tmp_path, seed)))
    # Six digits of each link's mass.
    assert 0.9999 * MASSES[0] < model.body_mass.sum() < 1.0001 * MASSES[1]
    assert drawn(tmp_path / "again", seed).read_text() == drawn(tmp_path, seed).read_text()


@pytest.mark.parametrize(
    ("body", "feet", "arms", "learns"),
    [
        ("quadruped_printed", 4, 0, {"stand", "walk"}),
        ("humanoid", 2, 0, {"stand", "walk"}),
        ("so101", 0, 1, {"hold", "reach"}),
        ("sea_snake", 1, 0, {"walk"}),
    ],
)
def test_what_a_robot_can_do_follows_from_its_tree(
    body: str, feet: int, arms: int, learns: set[str]
) -> None:
    able = abilities(load(body))
    assert (able.feet, able.arms) == (feet, arms)
    assert able.applicable & {"hold", "stand", "walk", "reach"} == learns


@pytest.mark.parametrize(("faster", "absurd"), [(1.0, []), (1.3, ["it gains"])])
def test_energy_from_nothing_is_absurd(faster: float, absurd: list[str], tmp_path: Path) -> None:
    (tmp_path / "swing.xml").write_text(PENDULUM)
    run = Simulator(load(tmp_path / "swing.xml")).run(seconds=1.0, start={"hinge": 1.0})
    channel = run.channels["hinge.velocity"]
    later = np.where(channel.time > 0.5, faster, 1.0) * channel.value
    channels = {**run.channels, "hinge.velocity": replace(channel, value=later)}
    write(replace(run, channels=channels), tmp_path / "run.csv")
    found = absurd_motion(
        tmp_path / "swing.xml", tmp_path / "run.csv", base=None, folder=None, floor=None
    )
    assert [each[: len("it gains")] for each in found] == absurd


def test_a_success_that_is_worse_than_doing_nothing_is_absurd() -> None:
    def record(loss: float, *, succeeded: bool) -> dict[str, object]:
        controls = {"nothing": {"loss": {"mean": 1.0}}}
        return {"succeeded": succeeded, "judged": {"loss": {"mean": loss}}, "controls": controls}

    assert absurd_policy(record(2.0, succeeded=True))
    assert not absurd_policy(record(0.5, succeeded=True))
    assert not absurd_policy(record(2.0, succeeded=False))


@pytest.mark.parametrize(
    ("fix", "options"),
    [
        ("describe one, or for a URDF --base floating", ("--base", "floating")),
        ("let all of /a/b be read: --folder /a/b", ("--folder", "/a/b")),
        ("name a world by --world NAME", ()),
        ("write the numbers", ()),
    ],
)
def test_options_that_a_fix_names_are_tried(fix: str, options: tuple[str, ...]) -> None:
    message = f"warning first\nerror: robot x: it cannot\n  fix: {fix}\n"
    told = Outcome(command="", kind="refused", seconds=0.0, memory=0.0, message=message)
    assert told.fix == options


@pytest.mark.parametrize(
    ("words", "seconds", "kind"),
    [
        (["list", "robots", "--json"], 30.0, "works"),
        (["inspect", "nobody.urdf", "--json"], 30.0, "refused"),
        (["simulate", "nobody.urdf"], 30.0, "refused"),
        (["no-such-command"], 30.0, "bad message"),
        (["simulate", "pendulum", "--seconds", "90000"], 2.0, "too long"),
    ],
)
def test_what_becomes_of_a_command(
    words: list[str], seconds: float, kind: str, tmp_path: Path
) -> None:
    assert outcome(words, folder=tmp_path, seconds=seconds).kind == kind


@pytest.mark.parametrize(("offset", "stands"), [(0.0, True), (1.2, False)])
def test_a_robot_that_is_pushed_stays_on_its_feet_or_not(
    offset: float, stands: bool, tmp_path: Path
) -> None:
    robot = load("quadruped_printed")
    # All knees at 1.2 rad, its trunk comes down by more than a fifth.
    knees = [each.name for each in robot.actuators if each.name.endswith("knee")]
    swings = {name: Swing(offset=offset) for name in knees}
    write_policy(pattern(robot, swings, period=0.02), tmp_path / "policy", robot)
    path = shelf.find("quadruped_printed")
    assert stands_pushed(path, tmp_path / "policy", base=None, floor="hard_floor") is stands
