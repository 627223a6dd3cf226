"""Defects planted in good descriptions: what people do wrong, told apart from what finds it."""

from experiments.plant.defect import Defect as Defect
from experiments.plant.inertias import BrokenInertia, MissingMass
from experiments.plant.limits import AbsurdLimit
from experiments.plant.loose import DanglingJoint, LostBase
from experiments.plant.meshes import LfsStub, MovedMeshOrigin, NegativeVolume, WrongCase
from experiments.plant.swapped import SwappedInertia
from experiments.plant.symmetry import FlippedAxis, MirroredLimb
from experiments.plant.tree import CyclicTree, DuplicateName
from experiments.plant.units import UnitSwap

DEFECTS: tuple[Defect, ...] = (
    UnitSwap(),
    FlippedAxis(),
    MirroredLimb(),
    SwappedInertia(),
    MissingMass(),
    WrongCase(),
    LfsStub(),
    BrokenInertia(),
    NegativeVolume(),
    DuplicateName(),
    CyclicTree(),
    DanglingJoint(),
    AbsurdLimit(),
    MovedMeshOrigin(),
    LostBase(),
)
"""The fifteen classes, in the order of the issue."""
