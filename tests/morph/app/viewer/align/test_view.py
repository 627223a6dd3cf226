"""Whether the view shows the hop, the part and the motion that are chosen."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from morph.app.viewer.align.lines import COMMANDS, FAINT, SAME, TURNED
from morph.app.viewer.align.performance import PARTS, TARGET
from morph.app.viewer.content import Content, Tie
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.align import HELD, TURNED_ROUND, AlignView, maker
from morph.errors import ViewError

Copy = Callable[..., Path]
Shown = Callable[..., AlignView]


def joined(content: Content, tie: Tie) -> tuple[str, str, str, str]:
    """Return the bodies and the links that a line joins."""
    found = []
    for at, link in (tie.source, tie.target):
        figure = content.actors[at].figure
        assert link in figure.links
        found += [figure.name, link]
    return (found[0], found[1], found[2], found[3])


def test_lines_join_the_links_of_the_parts_as_thick_as_their_share(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["transfer"])
    view.chosen = view.at_hop(2)
    content = view.content()
    said = json.loads((wrote["transfer"] / "transfer.json").read_text())
    # Of the shelf: each joint's own link.
    link = {"board": "board", "ankle": "rider"}
    other = {"board": "board", "ankle": "shanks", "knee": "thighs", "hip": "upper_body"}
    expected = {
        ("rider_rigid_driven", link[a["to"]], "rider_three_links_driven", other[a["from"]]): a
        for a in said["hops"][1]["relay"]["parts"]["states"]
    }
    found = {joined(content, tie): tie for tie in content.ties}
    assert found.keys() == expected.keys()
    for ends, tie in found.items():
        weight = expected[ends]["weight"]
        assert tie.strength == pytest.approx(abs(weight))
        assert tie.colour == (SAME if weight > 0.0 else TURNED)


def test_the_whole_chain_is_shown_first_and_a_hop_has_the_others_as_ghosts(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["transfer"])
    assert view.chosen.hop == 0
    whole = view.content()
    assert [actor.figure.name for actor in whole.actors] == [
        "cartpole",
        "rider_rigid_driven",
        "rider_three_links_driven",
    ]
    assert not any(actor.ghost for actor in whole.actors)
    assert [table.title for table in whole.tables] == ["The chain from cartpole"]
    view.chosen = view.at_hop(2)
    hop = view.content()
    assert [actor.ghost for actor in hop.actors] == [True, False, False]
    assert {at for tie in hop.ties for at in (tie.source[0], tie.target[0])} == {1, 2}
    assert hop.tables[0].title == "The guard on rider_three_links_driven"


def test_what_turned_round_means_is_told_where_something_is(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["transfer"])
    assert f"{TURNED_ROUND}." in view.content().notes
    view.chosen = view.at_hop(2)
    assert f"{TURNED_ROUND}." not in view.content().notes


def test_a_part_that_is_pointed_at_shows_on_both_bodies(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["align"])
    assert view.labels == ("slide → board", "hinge → ankle")
    view.chosen = replace(view.chosen, part="hinge → ankle")
    content = view.content()
    assert [dict(actor.tints) for actor in content.actors] == [{"pole": HELD}, {"rider": HELD}]
    colours = {joined(content, tie)[1]: tie.colour for tie in content.ties}
    assert colours == {"cart": FAINT, "pole": TURNED}


def test_a_click_on_a_link_points_at_its_parts_one_after_another_and_then_at_none(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["transfer"])
    view.chosen = view.at_hop(2)
    turn = []
    for _ in range(3):
        part = view.part_at(1, "rider")
        turn.append(part)
        view.chosen = replace(view.chosen, part=part)
    assert sorted(turn[:2]) == ["ankle → ankle", "ankle → knee"]
    assert turn[2] == ""
    # Of the body before the hop nothing is joined.
    assert view.part_at(0, "pole") == ""


def test_what_is_told_is_other_lines_than_what_is_seen(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["align"])
    view.chosen = replace(view.chosen, sort=COMMANDS)
    content = view.content()
    assert [joined(content, tie)[1::2] for tie in content.ties] == [("cart", "board")]


def test_an_alignment_has_its_parts_in_turn_and_a_moment_for_each(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["align"])
    assert view.chosen.way == PARTS
    assert [moment.title for moment in view.content().moments] == [
        "slide of cartpole",
        "hinge of cartpole",
    ]


def test_a_state_that_was_saved_shows_the_same_again(wrote: dict[str, Path], shown: Shown) -> None:
    view = shown(wrote["transfer"])
    view.chosen = replace(view.at_hop(2), way=TARGET, part="ankle → knee", large=False)
    state = json.loads(json.dumps(view.state()))
    again = shown(wrote["transfer"])
    again.restore(state)
    assert again.chosen == view.chosen
    assert again.content().ties == view.content().ties


@pytest.mark.parametrize(
    ("state", "what"),
    [
        ({}, r"it holds \{\}, and needs hop, way, sort, part, large"),
        ({"hop": 3}, r"hop is 3, and there are 2 hops"),
        ({"hop": True}, r"hop is True"),
        ({"hop": -1}, r"hop is -1"),
        ({"sort": "all"}, r"sort is 'all', not what is seen or what is told"),
        ({"part": None}, r"part is None"),
        ({"more": 1}, r"and needs hop"),
    ],
)
def test_a_state_of_something_else_is_refused(
    wrote: dict[str, Path], shown: Shown, state: dict[str, Any], what: str
) -> None:
    view = shown(wrote["transfer"])
    before = view.chosen
    with pytest.raises(ViewError, match=what):
        view.restore({**view.state(), **state} if state else {})
    assert view.chosen == before


def test_a_state_whose_part_or_motion_is_unknown_shows_all_at_rest(
    wrote: dict[str, Path], shown: Shown
) -> None:
    view = shown(wrote["align"])
    view.restore({**view.state(), "way": "<b>", "part": "nobody → nothing"})
    content = view.content()
    assert content.seconds == 0.0
    assert {tie.colour for tie in content.ties} == {FAINT}


def test_an_alignment_of_recordings_shows_its_parts_without_bodies(
    copy: Copy, shown: Shown
) -> None:
    def recorded(said: Any) -> None:
        said["provenance"]["command"] = "morph align --source a.npz --target b.npz --out DIR"

    content = shown(copy("align", recorded)).content()
    assert content.actors == ()
    assert content.ties == ()
    assert any(table.title.startswith("states of ") for table in content.tables)
    assert sum("was only recorded: there is no body" in note for note in content.notes) == 2


def test_one_body_that_is_not_there_leaves_the_others(copy: Copy, shown: Shown) -> None:
    def unknown(said: Any) -> None:
        for name in ("source", "target"):
            said["hops"][1 if name == "source" else 0][name] = "hexapod9"

    view = shown(copy("transfer", unknown))
    content = view.content()
    assert [actor.figure.name for actor in content.actors] == [
        "cartpole",
        "rider_three_links_driven",
    ]
    assert content.ties == ()
    assert any("hexapod9 is not drawn: no robot is called" in note for note in content.notes)
    view.chosen = view.at_hop(2)
    assert [actor.ghost for actor in view.content().actors] == [True, False]


def test_a_loop_is_shown_without_lines(copy: Copy, shown: Shown) -> None:
    def looped(said: Any) -> None:
        (hop, *_) = said["hops"]
        hop |= {"map": "identity", "quality": None, "target": "the robot"}
        del hop["relay"], said["provenance"]["inputs"]
        said["hops"], said["policy"] = [hop], None

    view = shown(copy("transfer", looped))
    content = view.content()
    assert [actor.figure.name for actor in content.actors] == ["cartpole"]
    assert content.ties == ()
    assert any(table.title == "Scores on the robot" for table in content.tables)


def test_names_that_are_no_part_of_the_bodies_are_told(copy: Copy, shown: Shown) -> None:
    def renamed(said: Any) -> None:
        said["parts"]["states"][0]["from"] = "<b>wing</b>"

    content = shown(copy("align", renamed)).content()
    assert len(content.ties) == 1
    assert "The bodies that are drawn have no <b>wing</b>." in content.notes


def test_without_a_folder_there_is_no_view() -> None:
    with pytest.raises(ViewError, match=r"no folder is named"):
        maker(ViewRequest(robots=(), asked=()))


def test_two_people_choose_each_for_themselves(wrote: dict[str, Path]) -> None:
    make = maker(ViewRequest(robots=(), asked=(), transfer=wrote["transfer"]))
    one, other = make(), make()
    assert isinstance(one, AlignView)
    one.chosen = one.at_hop(1)
    assert isinstance(other, AlignView)
    assert other.chosen.hop == 0
    # What is loaded is one thing for both.
    assert one.content().actors[0].figure is other.content().actors[0].figure
