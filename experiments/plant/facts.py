"""What can be measured at the place of a finding, so that a reader can judge it without morph."""

from __future__ import annotations

from pathlib import PurePosixPath

import numpy as np

from experiments.plant.description import Description, joint_in, link_in
from experiments.plant.measure import inertial, solid, triangles
from experiments.plant.sides import joint_at
from morph.arrays import Array


def measured(description: Description, kind: str, name: str) -> str:
    """Return in one line what trimesh and the file say of a link, a joint or a mesh."""
    if name in description.joints and kind != "link":
        return _of_joint(description, name)
    if name in description.links:
        return _of_link(description, name)
    wanted = PurePosixPath(name).name.lower()
    uris = dict.fromkeys(mesh.get("filename", "") for mesh in description.robot.iter("mesh"))
    return next((_of_mesh(description, u) for u in uris if u.lower().endswith(wanted)), "")


def _of_joint(description: Description, name: str) -> str:
    joint = joint_in(description.robot, name)
    limit, axis = joint.find("limit"), joint.find("axis")
    return (
        f"{joint.get('type')} at {_short(joint_at(description, name))} m from the base, "
        f"axis {'default' if axis is None else axis.get('xyz')}, "
        f"limit {'none' if limit is None else dict(limit.attrib)}"
    )


def _of_link(description: Description, name: str) -> str:
    shape, mass = solid(description, name), inertial(description, name)
    element = link_in(description.robot, name)
    count = len(element.findall("visual")) + len(element.findall("collision"))
    words = [f"{count} shapes"]
    if mass:
        moments: Array = np.linalg.eigvalsh(mass.moment).astype(np.float64)
        words.append(f"{mass.mass:.4g} kg, principal moments {_short(moments)}")
    else:
        words.append("no mass")
    if shape:
        words.append(f"hull {1e6 * shape.volume:.4g} cm^3, {shape.size:.3f} m across")
    if mass and shape:
        outside = np.maximum(shape.low - mass.centre, mass.centre - shape.high).max()
        gyration = np.sqrt(moments[-1] / mass.mass)
        words.append(
            f"{mass.mass / shape.volume:.0f} kg/m^3, gyration {gyration:.3f} m, "
            f"centre {max(float(outside), 0.0):.3f} m outside the box"
        )
        own: Array = np.diag(mass.turn @ mass.moment @ mass.turn.T) / mass.mass
        words.append(
            f"xx yy zz of unit mass {_short(own)}, of the hull {_short(np.diag(shape.moment))}"
        )
    return "; ".join(words)


def _of_mesh(description: Description, uri: str) -> str:
    file = description.file_of(uri)
    if file is None:
        return f"{uri} is not there letter for letter"
    mesh = triangles(file)
    return (
        f"{file.stat().st_size} bytes, {len(mesh.faces)} faces, closed {mesh.is_watertight}, "
        f"signed volume {1e6 * mesh.volume:.4g} cm^3 of scale 1, extent "
        f"{np.array2string(np.asarray(mesh.extents), precision=3)}"
    )


def _short(values: Array) -> str:
    return " ".join(f"{value:.2g}" for value in values)
