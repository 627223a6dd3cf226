"""Readers of untrusted files, by kind of file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path


def _recording(path: Path) -> object:
    from morph.record.read.any import read

    return read(path)


def _binding(path: Path) -> object:
    from morph.record.binding import load_binding

    return load_binding(path)


def _card(path: Path) -> object:
    from morph.body.card import load_card

    return load_card(path)


def _effects(path: Path) -> object:
    from morph.physics.store import load_effects

    return load_effects(path)


def _view(path: Path) -> object:
    from morph.app.viewer.reopen import read_state

    return read_state(path)


def _package(path: Path) -> object:
    from morph.fabrication.reading import read_packed

    return read_packed(path)


def _robot(path: Path) -> object:
    from morph.body.load import load

    return load(path)


def _mesh(path: Path) -> object:
    from morph.body.mesh import mesh_content, read_mesh

    return read_mesh(mesh_content(path), path.suffix, str(path))


def _search(path: Path) -> object:
    from morph.app.cli.search_checkpoint import Checkpoint

    # `Checkpoint` reads the file `state.npz` of a folder.
    return Checkpoint(path.parent, {}).before()


def _pairs(path: Path) -> object:
    from morph.app.cli.align_inputs import pairs

    return pairs(path)


def _map(path: Path) -> object:
    from morph.alignment.maps.files import read

    return read(path)


def _weights(path: Path) -> object:
    from morph.policy.files import read_tensors

    return read_tensors(path)


READERS: dict[str, Callable[[Path], object]] = {
    "recording": _recording,
    "binding": _binding,
    "card": _card,
    "effects": _effects,
    "view": _view,
    "package": _package,
    "robot": _robot,
    "mesh": _mesh,
    "search": _search,
    "pairs": _pairs,
    "map": _map,
    "weights": _weights,
}
"""Function that reads an untrusted file, by its kind."""
