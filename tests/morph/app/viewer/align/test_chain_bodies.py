"""Whether the bodies of a record are found, and only where they may be looked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from morph.app.viewer.align.chain_bodies import cast
from morph.app.viewer.align.read import story
from morph.body.load import load

Copy = Callable[..., Path]


def named(name: str, command: str = "") -> Callable[[Any], None]:
    """Return what gives the target of an alignment another name, and the record a command."""

    def change(said: Any) -> None:
        said["target"]["name"] = name
        if command:
            said["provenance"]["command"] = command

    return change


def test_a_body_that_is_not_on_the_shelf_is_left_out_with_a_way_on(copy: Copy) -> None:
    told = story(copy("align", named("hexapod9")))
    _, target = cast(told, ())
    assert target.figure is None
    assert "no robot is called 'hexapod9'" in target.notes[0]
    assert f"morph view DESCRIPTION --transfer {told.folder}" in target.notes[0]


def test_a_body_that_is_named_beside_the_folder_is_taken(copy: Copy) -> None:
    told = story(copy("align", named("hexapod9")))
    own = replace(load("rider_rigid_driven"), name="hexapod9")
    _, target = cast(told, (own,))
    assert target.figure is not None
    assert target.figure.robot.name == "hexapod9"


def test_a_path_in_a_record_is_never_followed(copy: Copy, tmp_path: Path) -> None:
    trap = tmp_path / "trap.xml"
    trap.write_text("<mujoco><worldbody/></mujoco>")
    command = f"morph align cartpole {trap} --task balance --out DIR"
    for name in (str(trap), "trap", "../cartpole", f"{trap}+board(free)"):
        told = replace(story(copy("align", named(name, command))), folder=tmp_path)
        _, target = cast(told, ())
        assert target.figure is None
        assert "no robot is called" in target.notes[0]
        import shutil

        shutil.rmtree(tmp_path / "align")


def test_a_body_that_has_changed_since_is_shown_and_told(copy: Copy) -> None:
    def changed(said: Any) -> None:
        said["provenance"]["inputs"]["rider_rigid_driven"] = "0" * 64

    source, target = cast(story(copy("align", changed)), ())
    assert source.notes == ()
    assert target.figure is not None
    assert "its description differs since" in target.notes[0]


def test_a_body_that_cannot_balance_stands_still(copy: Copy) -> None:
    _, target = cast(story(copy("align", named("sea_snake"))), ())
    assert target.figure is not None
    assert target.body is None
    assert target.notes[0].startswith("sea_snake stands still: ")


def test_what_was_only_recorded_has_no_body(copy: Copy) -> None:
    command = "morph align cartpole --target ours.npz --task balance --out DIR"
    source, target = cast(story(copy("align", named("cartpole", command))), ())
    assert source.figure is not None
    assert target.figure is None
    assert "was only recorded" in target.notes[0]


def test_a_board_that_nobody_knows_leaves_the_rider_drawn(copy: Copy) -> None:
    _, target = cast(story(copy("align", named("humanoid+board(flying)"))), ())
    assert target.body is None
    assert "no board is 'flying'" in target.notes[0]


@pytest.mark.parametrize("count", [1, 3])
def test_a_body_that_comes_twice_is_made_once(copy: Copy, count: int) -> None:
    def twice(said: Any) -> None:
        hop = said["hops"][0] | {"target": "cartpole"}
        said["hops"] = [hop] * count
        said["provenance"]["command"] = "morph transfer"

    players = cast(story(copy("transfer", twice)), ())
    assert len(players) == count + 1
    assert len({id(each) for each in players}) == 1
