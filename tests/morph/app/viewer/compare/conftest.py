"""Small bodies whose motion is known in closed form, and tasks for them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.task.quantity import Commands
from morph.task.start import Start
from morph.task.task import Task
from morph.task.term import Goal, Term


@pytest.fixture
def made(tmp_path: Path) -> Callable[..., Robot]:
    """Makes a robot of what stands in its worldbody, and of its actuators."""

    def build(worldbody: str, actuator: str = "", rest: str = "", name: str = "thing") -> Robot:
        file = tmp_path / f"{name}.xml"
        file.write_text(
            f"""<mujoco model="{name}">{rest}<worldbody>{worldbody}</worldbody>
            <actuator>{actuator}</actuator></mujoco>"""
        )
        return load(file)

    return build


@pytest.fixture
def wheel(made: Callable[..., Robot]) -> Robot:
    """A wheel of 2 kg m2 about an upright axle, which a motor of at most 4 N m turns."""
    return made(
        """<body name="wheel"><joint name="axle" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="1" diaginertia="2 2 2"/>
        <geom type="sphere" size="0.1" mass="0" contype="0" conaffinity="0"/></body>""",
        '<motor name="axle" joint="axle" ctrllimited="true" ctrlrange="-4 4"/>',
        name="wheel",
    )


@pytest.fixture
def asked() -> Callable[..., Task]:
    """Makes a task that costs its commands, in which nothing is drawn by chance."""

    def build(robot: Robot, **how: Any) -> Task:
        names = tuple(each.name for each in robot.actuators)
        zero = (0.0,) * len(names)
        commands = Commands(actuators=names)
        how = {"start": Start(spread=0.0), "horizon": 1.0, "period": 0.05, "step": 0.005, **how}
        return Task(
            name="balance",
            robot=robot,
            terms=(Term(name="effort", quantity=commands, target=zero, width=1.0),),
            goals=(Goal(name="rest", quantity=commands, target=zero, within=1.0),),
            **how,
        )

    return build
