"""The mechanism that is simulated: bodies, joints and every law, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.concealed.compiled import library, pointer
from experiments.concealed.fields import BODY, BODY_ROW, JOINT, JOINT_ROW

Array = np.ndarray


@dataclass(frozen=True, kw_only=True)
class Plant:
    """A tree of bodies, each on one hinge or slide; body i hangs on body `parent[i]` < i."""

    parent: Array
    """Index of each body's parent, -1 for the world, shape (n,)."""
    slide: Array
    """1 where the joint is a slide, shape (n,)."""
    rotation: Array
    """Orientation of each frame in its parent's at q = 0, shape (n, 3, 3)."""
    origin: Array
    """Origin of each frame in its parent's, m, shape (n, 3)."""
    axis: Array
    """Unit axis of each joint in its body's frame, shape (n, 3)."""
    inertia: Array
    """Inertia about the centre of mass in the body's frame, kg m2, shape (n, 3, 3)."""
    gravity: Array
    """Acceleration of gravity, m/s2, shape (3,)."""
    current: Array
    """Velocity of the fluid, m/s, shape (3,)."""
    joint: Array
    """Figures by `fields.JOINT`, shape (figures, n)."""
    body: Array
    """Figures by `fields.BODY`, shape (figures, n)."""

    @property
    def count(self) -> int:
        """Number of joints."""
        return len(self.parent)

    def of_joint(self, field: str) -> Array:
        """Return a figure of every joint, shape (n,)."""
        return np.asarray(self.joint[JOINT_ROW[field]])

    def of_body(self, field: str) -> Array:
        """Return a figure of every body, shape (n,)."""
        return np.asarray(self.body[BODY_ROW[field]])

    def with_joint(self, place: int | slice, **figures: float | Array) -> Plant:
        """Return a copy with some figures of a joint, or of all."""
        joint = self.joint.copy()
        for field, value in figures.items():
            joint[JOINT_ROW[field], place] = value
        return replace(self, joint=joint)

    def with_body(self, place: int | slice, **figures: float | Array) -> Plant:
        """Return a copy with some figures of a body, or of all."""
        body = self.body.copy()
        for field, value in figures.items():
            body[BODY_ROW[field], place] = value
        return replace(self, body=body)

    @property
    def com(self) -> Array:
        """Centres of mass in their bodies' frames, m, shape (n, 3)."""
        row = BODY_ROW["cx"]
        return np.asarray(self.body[row : row + 3].T)

    def with_com(self, place: int | slice, com: Array) -> Plant:
        """Return a copy with the centre of mass of a body, or of all, shape (3,) or (n, 3)."""
        x, y, z = np.asarray(com).T
        return self.with_body(place, cx=x, cy=y, cz=z)

    def with_inertia(self, place: int, inertia: Array) -> Plant:
        """Return a copy with the inertia of one body, shape (3, 3)."""
        every = self.inertia.copy()
        every[place] = inertia
        return replace(self, inertia=every)

    def constants(self) -> tuple[list[Array], list[object]]:
        """Return the arrays that the compiled functions read, and their first arguments."""
        arrays = [
            np.ascontiguousarray(each, dtype=kind)
            for each, kind in (
                (self.parent, np.int32),
                (self.slide, np.int32),
                *((each, np.float64) for each in (self.rotation, self.origin, self.axis)),
                *((each, np.float64) for each in (self.inertia, self.gravity, self.current)),
                *((each, np.float64) for each in (self.joint, self.body)),
            )
        ]
        return arrays, [self.count, *(pointer(each) for each in arrays)]

    def mass_and_bias(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the mass matrices without rotors, (m, n, n), and the bias forces, (m, n).

        Args:
            q: Positions, shape (m, n).
            v: Velocities, shape (m, n).
        """
        n, count = self.count, len(q)
        q, v = (np.ascontiguousarray(each, dtype=float) for each in (q, v))
        mass, bias = np.zeros((count, n, n)), np.zeros((count, n))
        alive, arguments = self.constants()
        outputs = (pointer(each) for each in (q, v, mass, bias))
        library().mass_and_bias(*arguments, count, *outputs)
        del alive
        return mass, bias


def plant_of(
    *, parent: Array, slide: Array, rotation: Array, origin: Array, axis: Array, mass: Array,
    com: Array, inertia: Array, gravity: Array,
) -> Plant:  # fmt: skip
    """Return a plant in which no law acts and nothing drives."""
    n = len(parent)
    joint = np.repeat(np.array([[value] for value in JOINT.values()], dtype=float), n, axis=1)
    body = np.repeat(np.array([[value] for value in BODY.values()], dtype=float), n, axis=1)
    bare = Plant(
        parent=parent, slide=slide, rotation=rotation, origin=origin, axis=axis, inertia=inertia,
        gravity=gravity, current=np.zeros(3), joint=joint, body=body,
    )  # fmt: skip
    return bare.with_body(slice(None), mass=mass).with_com(slice(None), com)


def add_leaf(
    plant: Plant, parent: int, *, slide: bool, origin: Array, axis: Array, mass: float,
    com: Array, inertia: Array,
) -> Plant:  # fmt: skip
    """Return a plant with one more body, the last, on a joint that no description shows."""
    one = plant_of(
        parent=np.array([parent]), slide=np.array([int(slide)]), rotation=np.eye(3)[None],
        origin=origin[None], axis=axis[None], mass=np.array([mass]), com=com[None],
        inertia=inertia[None], gravity=plant.gravity,
    )  # fmt: skip
    stacked = {
        name: np.concatenate([getattr(plant, name), getattr(one, name)])
        for name in ("parent", "slide", "rotation", "origin", "axis", "inertia")
    }
    wide = {
        name: np.concatenate([getattr(plant, name), getattr(one, name)], axis=1)
        for name in ("joint", "body")
    }
    return replace(plant, **stacked, **wide)
