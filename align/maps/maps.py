"""All maps between bodies: what learns them, and what files hold."""

from __future__ import annotations

from align.chain import ChainMap
from align.errors import MapError
from align.maps.affine_map import AffineMap
from align.maps.bent_map import BentMap
from align.maps.body_map import BodyMap, Mapper
from align.maps.features import Features
from align.maps.kernel import KernelMapper
from align.maps.manifold import Manifold, ManifoldFree
from align.maps.network import NetworkMapper
from align.maps.pca_affine import PcaAffine
from align.maps.sparse import Sparse
from align.maps.transition import TransitionMapper
from align.maps.transport import Transport
from align.maps.uma import Uma

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
