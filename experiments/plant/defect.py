"""What a defect is: where it matters, what a person does wrong, and what would name it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import ClassVar

import numpy as np

from experiments.plant.description import Description


@dataclass(frozen=True, kw_only=True)
class Places:
    """Where a finding stands that is about one defect."""

    parts: frozenset[str] = frozenset()
    """Names of links and joints."""
    meshes: frozenset[str] = frozenset()
    """Names of mesh files, without folders, in small letters."""
    partners: frozenset[str] = frozenset()
    """Names of twins: right only where the finding's text names one of `parts`."""

    def hold(self, kind: str, name: str, what: str) -> bool:
        """Return whether a finding at this place, with this text, is about the defect."""
        if name in self.parts and kind not in ("file", "robot"):
            return True
        if name in self.partners:
            return any(part in what for part in self.parts)
        return PurePosixPath(name.replace("\\", "/")).name.lower() in self.meshes


@dataclass(frozen=True, kw_only=True)
class Planted:
    """One defect in one copy."""

    defect: str
    """Its class."""
    variant: str
    """Which of the ways in which people make it."""
    robot: str
    """The description that it was planted in."""
    site: str
    """The link or joint."""
    fact: str
    """The measured fact that makes it a defect there."""
    did: str
    """What was changed."""
    places: Places
    """Where a finding may stand that is about it."""
    codes: frozenset[str]
    """Codes that name its class."""
    also: frozenset[str]
    """Codes that say the same with other words; reported apart."""


@dataclass(frozen=True, kw_only=True)
class Done:
    """What a planter changed."""

    did: str
    """In words, with the values."""
    places: Places
    """Where a finding may stand that is about it."""


class Defect(ABC):
    """One class of defects, with the variants in which people make it."""

    name: ClassVar[str]
    """The class, in the words of the issue."""
    variants: ClassVar[tuple[str, ...]]
    """Planted in turn; one may stand twice."""

    @abstractmethod
    def sites(self, original: Description, variant: str) -> list[str]:
        """Return the links or joints where it could be planted, by names alone."""

    @abstractmethod
    def fact(self, original: Description, site: str, variant: str) -> str:
        """Return the measured fact that makes it a defect there; nothing if it is none."""

    @abstractmethod
    def plant(self, copy: Description, site: str, variant: str, rng: np.random.Generator) -> Done:
        """Change the copy on disk and return what was changed."""

    @abstractmethod
    def codes(self, variant: str) -> frozenset[str]:
        """Return the codes of findings that name it."""

    def also(self, variant: str) -> frozenset[str]:
        """Return codes that say the same with other words."""
        return frozenset()


def around(description: Description, link: str) -> Places:
    """Return a link, the joint that carries it, and its meshes."""
    joint = description.parents.get(link)
    return Places(
        parts=frozenset({link} | ({joint} if joint else set())),
        meshes=mesh_names(description.meshes(link)),
    )


def mesh_names(uris: Iterable[str]) -> frozenset[str]:
    """Return the names of mesh files as `Places` compares them."""
    return frozenset(PurePosixPath(uri).name.lower() for uri in uris)
