from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import motion
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import makers
from morph.body.load import load
from morph.body.robot import Robot

LINK = """<link name="{name}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="{name}.stl"/></geometry></visual></link>"""

JOINT = """<joint name="j{at}" type="revolute"><parent link="l{at}"/><child link="l{to}"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""


def torn(folder: Path, links: int) -> Robot:
    """A chain of links, each with a mesh that is nowhere."""
    parts = [LINK.format(name=f"l{at}") for at in range(links)]
    parts += [JOINT.format(at=at, to=at + 1) for at in range(links - 1)]
    path = folder / "torn.urdf"
    path.write_text(f'<robot name="torn">{"".join(parts)}</robot>', encoding="utf-8")
    return load(path)


def missing(notes: tuple[str, ...]) -> list[str]:
    return [note for note in notes if ".stl" in note]


@pytest.mark.parametrize("view", ["compare", "design"])
def test_no_view_is_silent_about_a_mesh_that_is_missing(tmp_path: Path, view: str) -> None:
    robot = torn(tmp_path, 2)
    found, first = makers(ViewRequest(robots=(robot,), asked=("torn",)), view)
    shown = found[first]()
    shown.complete()
    told = missing(shown.content().notes)
    assert len(told) == 2
    for name, note in zip(("l0", "l1"), told, strict=True):
        assert f"link {name} " in note
        assert f"{name}.stl" in note


def test_of_many_parts_that_are_not_drawn_a_few_are_told_and_the_rest_is_counted(
    tmp_path: Path,
) -> None:
    body = figure(torn(tmp_path, 10))
    rest = motion(body.model, np.zeros(1), np.zeros((1, body.model.nq)))
    # The same body as a ghost is no news.
    ghost = Actor(figure=body, motion=rest, ghost=True)
    notes = Content(actors=(Actor(figure=body, motion=rest), ghost)).notes
    assert len(missing(notes)) == 3
    assert "torn: 7 more of its parts are not drawn as described" in notes
