"""The same robot under other names, with axes turned and actuators in another order."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of

SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


def disguised(robot: Robot, folder: Path, seed: int) -> tuple[Robot, dict[str, str]]:
    """Return a robot with other names, half its axes turned and its actuators in random order.

    Args:
        robot: The robot.
        folder: Where its description is written.
        seed: The chance of names, axes and order.

    Returns:
        The robot, and by each new name of a body, joint or actuator the old one.
    """
    rng = np.random.default_rng(seed)
    spec, names, turned = spec_of(robot), {}, set()
    for kind in (spec.bodies[1:], spec.joints):
        for part in kind:
            new = f"p{rng.integers(10**9)}"
            names[new], part.name = part.name, new
    for joint in spec.joints:
        if joint.type in SCALAR and rng.random() < 0.5:
            turned.add(joint.name)
            joint.axis = -np.array(joint.axis)
            joint.range = [-joint.range[1], -joint.range[0]]
    for part in (*spec.keys, *spec.sensors, *spec.excludes, *spec.equalities):
        spec.delete(part)
    for number, actuator in enumerate(spec.actuators):
        actuator.target = next((new for new, was in names.items() if was == actuator.target), "")
        if actuator.target in turned:
            actuator.ctrlrange = [-actuator.ctrlrange[1], -actuator.ctrlrange[0]]
            actuator.forcerange = [-actuator.forcerange[1], -actuator.forcerange[0]]
        new = f"a{rng.integers(10**9)}_{number}"
        names[new], actuator.name = actuator.name, new
    tree = ElementTree.fromstring(spec.to_xml())
    listed = tree.find("actuator")
    if listed is not None:
        listed[:] = [listed[at] for at in rng.permutation(len(listed))]
    (folder / "robot.xml").write_bytes(ElementTree.tostring(tree))
    return load(folder / "robot.xml"), names
