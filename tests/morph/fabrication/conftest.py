"""A small package made by hand: two cubes on a pendulum, no slicer asked; nothing of it changes."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.fabrication.content import Package
from morph.fabrication.masses import link_masses
from morph.print.job import Job, Laid, Orientation, Plate
from morph.print.mesh import Mesh, from_manifold
from morph.print.part import Check, Hinge, Part, Placement, Seat
from morph.print.printer import Profile, material, printer
from morph.print.sliced import Sliced
from morph.print.weight import box


def cube(*size: float) -> Mesh:
    return from_manifold(manifold3d.Manifold.cube(size, True))


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = (x, y, z)
    return pose


@pytest.fixture(scope="session")
def profile() -> Profile:
    return Profile(printer=printer("mk4"), material=material("pla"))


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    return load("pendulum")


@pytest.fixture(scope="session")
def job(profile: Profile, pendulum: Robot) -> Job:
    """Two bars of 10 g on the rod, 100 mm either side of 0.5 m, and a ball of 0.1 kg bought."""
    link = pendulum.links[-1].name
    bar = Part(
        name="bar",
        number="P-01",
        kind="printed",
        mesh=cube(20, 20, 40),
        placements=tuple(
            Placement(link=link, pose=at(0, 0, z), world=at(0, 0, z)) for z in (-400, -600)
        ),
        seats=(Seat(holds="M3", position=np.zeros(3), axis=np.array([0.0, 0, 1]), bore_mm=3.2),),
        weight=box(0.010, np.array([20.0, 20, 40])),
    )
    ball = Part(
        name="ball",
        number="B-01",
        kind="bought",
        mesh=None,
        placements=(Placement(link=link, pose=at(0, 0, -500), world=at(0, 0, -500)),),
        weight=box(0.1, np.array([30.0, 30, 30])),
    )
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    lies = Orientation(turn=turn, support_mm3=0.0, first_support_mm3=5.0, height_mm=20.0)
    weight = bar.weight
    assert weight is not None
    sliced = Sliced(source="estimate", weight=weight, support_kg=0.0, seconds=600.0)
    laid = tuple(Laid(part="bar", copy=each, pose=at(40, 40 + 60 * each, 10)) for each in (0, 1))
    return Job(
        profile=profile,
        parts=(bar, ball),
        refused=(),
        checks=(Check(part="bar", name="wall", verdict="passed", what="20 mm, at least 0.9 mm"),),
        orientations={"bar": lies},
        sliced={"bar": sliced},
        plates=(Plate(name="plate_1", laid=laid),),
    )


@pytest.fixture(scope="session")
def package(job: Job, pendulum: Robot) -> Package:
    link = pendulum.links[-1].name
    hinge = Hinge(
        name="hinge",
        kind="hinge",
        position=np.zeros(3),
        axis=np.array([0.0, -1, 0]),
        low=-3.0,
        high=3.0,
        still="world",
        moving=link,
    )
    return Package(
        name=pendulum.name,
        title="A pendulum of <two> bars",
        designed_sha256=pendulum.sha256,
        job=job,
        links=link_masses(pendulum, job, {link}),
        hinges=(hinge,),
        complete=frozenset({link}),
        command="morph print pendulum --printer mk4 --material pla --out package",
    )
