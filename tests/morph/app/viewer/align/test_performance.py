"""Whether the bodies of a chain move as their maps say."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from morph.app.viewer.align.chain_bodies import cast
from morph.app.viewer.align.joint_turns import SECONDS, SHIFT
from morph.app.viewer.align.performance import PARTS, SOURCE, TARGET, Performance
from morph.app.viewer.align.read import story
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import MotionFrames
from morph.arrays import Array
from morph.body.load import load
from morph.errors import ViewError

Copy = Callable[..., Path]


@pytest.fixture(scope="module")
def chain(wrote: dict[str, Path]) -> Performance:
    told = story(wrote["transfer"])
    return Performance(told, cast(told, ()))


def leaning(chain: Performance, motion: MotionFrames, at: int, link: str) -> Array:
    """Return by how much a link leans more than it does at first, rad, about the world's y."""
    drawn = chain.players[at].figure
    assert drawn is not None
    turn = motion.turn[:, drawn.links.index(link)]
    turned = Rotation.from_quat(turn, scalar_first=True)
    return np.asarray((turned * turned[0].inv()).as_rotvec()[:, 1])


def along(chain: Performance, motion: MotionFrames, at: int, link: str) -> Array:
    """Return how far a link has gone along x, m."""
    drawn = chain.players[at].figure
    assert drawn is not None
    x = motion.position[:, drawn.links.index(link), 0]
    return np.asarray(x - x[0])


def ratio(here: Array, there: Array) -> float:
    """Return how many times another motion is as large as one, if it is nothing but that."""
    found = float(here @ there / (here @ here))
    # Quaternions of single steps leave 1e-6 over.
    np.testing.assert_allclose(found * here, there, atol=1e-6)
    return found


@pytest.mark.parametrize("way", [TARGET, SOURCE])
@pytest.mark.parametrize("large", [False, True])
def test_a_rider_leans_the_way_the_pole_does_and_rolls_as_the_cart(
    chain: Performance, way: str, large: bool
) -> None:
    # Where both lean is seen in the world here, whichever way their joints count; nothing of the
    # map is looked at. A rider is a little stiffer or looser than a pole, never its mirror image.
    pole, rider, _ = chain.scene(0, 1, way, large).motions
    leans = leaning(chain, pole, 0, "pole"), leaning(chain, rider, 1, "rider")
    assert np.abs(leans[0]).max() > 0.005
    assert 0.5 < ratio(*leans) < 2.0
    rolls = along(chain, pole, 0, "cart"), along(chain, rider, 1, "board")
    assert ratio(*rolls) == pytest.approx(1.0, abs=1e-6)


def test_what_leads_runs_by_its_own_physics_and_is_pushed(chain: Performance) -> None:
    body = chain.players[1].body
    assert body is not None
    motion = chain.scene(0, 1, TARGET, False).motions[1]
    push = body.task.start.push
    assert push is not None
    # Its impulse over the mass of the whole is its speed at first; it is driven back within
    # five seconds, so that it goes at most as far as that speed would carry it.
    speed = push.impulse[0] / body.task.robot.mass
    gone = along(chain, motion, 1, "board")
    assert 0.0 < np.abs(gone).max() < 5.0 * abs(speed) + 0.1
    assert motion.seconds == pytest.approx(body.task.horizon, abs=0.02)


def test_enlarged_motions_are_so_many_times_as_large_and_say_so(chain: Performance) -> None:
    plain, large = (chain.scene(0, 1, TARGET, each) for each in (False, True))
    scale = np.ptp(along(chain, large.motions[1], 1, "board")) / np.ptp(
        along(chain, plain.motions[1], 1, "board")
    )
    assert scale == pytest.approx(20.0)
    assert "Motions are drawn 20 times as large as they are" in large.notes
    assert not any("times as large" in note for note in plain.notes)


def test_each_part_has_its_turn_and_moves_what_the_map_joins_to_it(chain: Performance) -> None:
    scene = chain.scene(0, 1, PARTS, True)
    assert [(each.time, each.title) for each in scene.moments] == [
        (0.0, "slide of cartpole"),
        (SECONDS, "hinge of cartpole"),
    ]
    pole, rider, _ = scene.motions
    drawn = chain.players[0].figure
    assert drawn is not None
    cart, board = along(chain, pole, 0, "cart"), along(chain, rider, 1, "board")
    # A sine's greatest value over so many samples, at a quarter of its turn.
    assert cart.max() == pytest.approx(SHIFT * drawn.model.stat.extent, rel=1e-3)
    assert np.abs(board[pole.at(SECONDS) :]).max() < 1e-9
    lean = leaning(chain, rider, 1, "rider")
    assert np.abs(lean[: pole.at(SECONDS)]).max() < 1e-9
    assert np.abs(lean).max() > 0.3


def test_the_whole_chain_is_led_by_its_last_body(chain: Performance) -> None:
    scene = chain.scene(0, 2, TARGET, False)
    assert any("rider_three_links_driven moves by the policy" in each for each in scene.notes)
    assert any("every other body shows what the map makes of it" in each for each in scene.notes)
    assert all(motion.pictures > 100 for motion in scene.motions)


def test_bodies_beside_the_chosen_hop_rest(chain: Performance) -> None:
    assert chain.scene(0, 1, TARGET, False).motions[2].pictures == 1
    assert chain.scene(1, 2, TARGET, False).motions[0].pictures == 1


def test_a_motion_is_computed_once_for_all_who_look(chain: Performance) -> None:
    assert chain.scene(0, 2, SOURCE, True) is chain.scene(0, 2, SOURCE, True)


def test_without_its_law_a_body_moves_by_the_policy_beside_the_record(copy: Copy) -> None:
    folder = copy("transfer")
    with_law = Performance(story(folder), cast(story(folder), ()))
    (folder / "hops/02/law.npz").unlink()
    without = Performance(story(folder), cast(story(folder), ()))
    here, there = (each.scene(1, 2, TARGET, False) for each in (with_law, without))
    assert here.notes == there.notes
    # A hinge without limits is seen by its sine and cosine in a policy: to first order the same.
    np.testing.assert_allclose(here.motions[2].position, there.motions[2].position, atol=1e-2)


def test_without_any_policy_of_its_own_the_source_s_is_seen_through_the_map(
    wrote: dict[str, Path],
) -> None:
    told = story(wrote["align"])
    scene = Performance(told, cast(told, ())).scene(0, 1, TARGET, False)
    assert any("by the regulator of cartpole, seen through the map" in n for n in scene.notes)


def test_without_its_map_a_body_rests_and_it_is_said_why(copy: Copy) -> None:
    folder = copy("align")
    (folder / "maps/01_body_map.npz").unlink()
    told = story(folder)
    scene = Performance(told, cast(told, ())).scene(0, 1, SOURCE, False)
    assert "rider_rigid_driven stands at rest: no map leads to it" in scene.notes
    assert scene.motions[1].pictures == 1


@pytest.mark.parametrize("name", ["maps/01_body_map.npz", "hops/01/law.npz"])
@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 and no more", b"\x80\x04pickle"])
def test_spoilt_numbers_are_refused_before_anything_is_served(
    copy: Copy, name: str, content: bytes
) -> None:
    folder = copy("transfer")
    (folder / name).write_bytes(content)
    told = story(folder)
    with pytest.raises(ViewError, match=r"it cannot be read") as caught:
        Performance(told, cast(told, ()))
    assert Path(name).name in caught.value.where


def test_a_map_between_other_bodies_moves_nothing(copy: Copy, wrote: dict[str, Path]) -> None:
    folder = copy("align")
    other = wrote["transfer"] / "maps/02_body_map.npz"
    (folder / "maps/01_body_map.npz").write_bytes(other.read_bytes())
    told = story(folder)
    assert Performance(told, cast(told, ())).maps == (None,)


def test_a_humanoid_on_a_board_is_drawn_with_its_own_shapes(copy: Copy) -> None:
    def boarded(said: dict) -> None:
        said["target"]["name"] = "humanoid+board(passive)"
        said["provenance"]["command"] = "morph align cartpole humanoid_passive --out DIR"

    told = story(copy("align", boarded))
    _, rider = cast(told, ())
    assert rider.figure is not None
    assert rider.body is not None
    assert not rider.whole
    drawn = {rider.figure.links[shape.body] for shape in rider.figure.shapes}
    # All that the humanoid itself shows is shown, each on its own link, and the board below it.
    own = figure(load("humanoid"))
    assert {own.links[shape.body] for shape in own.shapes} - {"world"} < drawn
    assert "board" in drawn
