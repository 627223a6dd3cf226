"""All maps between bodies: what learns them, and what files hold."""

from __future__ import annotations

from morph.alignment.chain import ChainMap
from morph.alignment.errors import MapError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.bent_map import BentMap
from morph.alignment.maps.body_map import BodyMap, Mapper
from morph.alignment.maps.features import Features
from morph.alignment.maps.kernel import KernelMapper
from morph.alignment.maps.manifold import Manifold, ManifoldFree
from morph.alignment.maps.network import NetworkMapper
from morph.alignment.maps.pca_affine import PcaAffine
from morph.alignment.maps.sparse import Sparse
from morph.alignment.maps.transition import TransitionMapper
from morph.alignment.maps.transport import Transport
from morph.alignment.maps.uma import Uma

MAPPERS: tuple[Mapper, ...] = (
    TransitionMapper(),
    KernelMapper(),
    NetworkMapper(),
    PcaAffine(),
    Manifold(),
    ManifoldFree(),
    Sparse(),
    Uma(),
    Transport(),
    Features(),
)
"""Every way to learn a map, with its settings as they are without a choice."""

KINDS: tuple[type[BodyMap], ...] = (AffineMap, BentMap, ChainMap)
"""Every sort of map that a file may hold."""


def mapper(name: str) -> Mapper:
    """Return the way to learn a map that has this name.

    Raises:
        MapError: None has.
    """
    for each in MAPPERS:
        if each.name == name:
            return each
    raise MapError(
        f"no map is called {name!r}",
        where="a map between two bodies",
        fix=f"name one of {', '.join(each.name for each in MAPPERS)}",
    )


def kind_of(name: str) -> type[BodyMap]:
    """Return the sort of map that files call so.

    Raises:
        MapError: There is no such sort.
    """
    for each in KINDS:
        if each.kind == name:
            return each
    raise MapError(
        f"{name!r} is no sort of map",
        where="a map between two bodies",
        fix=f"name one of {', '.join(each.kind for each in KINDS)}",
    )
