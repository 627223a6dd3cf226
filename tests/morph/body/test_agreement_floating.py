"""Both engines read the URDF of a body that floats alike."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body import shelf
from morph.body.agreement import disagreement
from morph.body.convert import convert
from morph.body.load import load

FLOATING = [
    name for name in shelf.names() if any(joint.kind == "free" for joint in load(name).joints)
]


@pytest.mark.parametrize("name", FLOATING)
def test_a_floating_body_written_as_urdf_is_read_alike(name: str, tmp_path: Path) -> None:
    written = convert(load(name), "urdf", tmp_path / name)
    assert disagreement(load(written.files[0])) == []


def test_there_are_bodies_that_float() -> None:
    assert {"humanoid", "sea_snake", "hexapod_swimmer"} <= set(FLOATING)
