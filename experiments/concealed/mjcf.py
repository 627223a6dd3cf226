"""The nominal description of a mechanism as plain MJCF."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from experiments.concealed.mechanism import SERVO, Mechanism
from experiments.concealed.plant import Array

TIMESTEP = "0.001"


def _text(values: Array | float) -> str:
    return " ".join(f"{x:.10g}" for x in np.atleast_1d(values).ravel())


def quaternion(R: Array) -> Array:
    """Return the unit quaternion (w, x, y, z) of a rotation, by its largest component.

    Source: Shepperd 1978, J. Guidance and Control 1(3).
    """
    trace = np.trace(R)
    squares = np.array([trace, *np.diag(R)])
    i = int(np.argmax(squares))
    if i == 0:
        q = np.array([1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        a, b, c = (i - 1, i % 3, (i + 1) % 3)
        q = np.zeros(4)
        q[0] = R[c, b] - R[b, c]
        q[1 + a] = 1 + R[a, a] - R[b, b] - R[c, c]
        q[1 + b] = R[b, a] + R[a, b]
        q[1 + c] = R[c, a] + R[a, c]
    return np.asarray(q / np.linalg.norm(q))


def describe(mechanism: Mechanism, name: str) -> str:
    """Return the MJCF of a mechanism; its links have no shapes."""
    plant = mechanism.plant
    root = ElementTree.Element("mujoco", model=name)
    ElementTree.SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
    ElementTree.SubElement(
        root, "option", gravity=_text(plant.gravity), timestep=TIMESTEP, integrator="implicitfast"
    )
    parts = [ElementTree.SubElement(root, "worldbody")]
    for i, link in enumerate(mechanism.links):
        body = ElementTree.SubElement(
            parts[plant.parent[i] + 1], "body", name=link, pos=_text(plant.origin[i]),
            quat=_text(quaternion(plant.rotation[i])),
        )  # fmt: skip
        I = plant.inertia[i]  # noqa: E741
        ElementTree.SubElement(
            body, "inertial", pos=_text(plant.com[i]), mass=_text(plant.of_body("mass")[i]),
            fullinertia=_text(np.array([I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]])),
        )  # fmt: skip
        ElementTree.SubElement(
            body, "joint", name=mechanism.joints[i], type="slide" if plant.slide[i] else "hinge",
            axis=_text(plant.axis[i]), armature=_text(plant.of_joint("rotor")[i]),
            damping=_text(plant.of_joint("viscous")[i]),
        )  # fmt: skip
        parts.append(body)
    actuators = ElementTree.SubElement(root, "actuator")
    for i in mechanism.driven:
        figures = {"name": mechanism.actuator(i), "joint": mechanism.joints[i]}
        if plant.of_joint("drive")[i] == SERVO:
            figures |= {name: _text(plant.of_joint(name)[i]) for name in ("kp", "kv")}
            ElementTree.SubElement(actuators, "position", figures)
        else:
            most = _text(plant.of_joint("most")[i])
            figures |= {"ctrllimited": "true", "ctrlrange": f"-{most} {most}"}
            ElementTree.SubElement(actuators, "motor", figures)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
