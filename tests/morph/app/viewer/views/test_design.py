"""The view Design, seen by a person without a browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from morph.app.viewer.design.design_state import BodyPlan
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.design import DesignView, maker
from morph.body.load import load


@pytest.fixture(scope="module")
def biped() -> BodyPlan:
    return BodyPlan(load("biped"))


@pytest.fixture(scope="module")
def humanoid() -> BodyPlan:
    return BodyPlan(load("humanoid"))


def test_a_slider_moves_its_link_by_degrees_and_nothing_is_sent_anew(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    view = DesignView((humanoid,))
    page = opened(view)
    motion = page.content.actors[0].motion
    before = motion.turn.copy()
    page.knob("find").move("l_knee")
    knee = page.knob("l_knee_y", "slider")
    knee.move(knee.max / 2)
    assert page.shown == 0
    assert page.content.actors[0].motion is motion
    moved = {humanoid.original.figure.links[at] for at in np.where(motion.turn != before)[1]}
    link = humanoid.robot.joint("l_knee_y").link
    assert link in moved
    assert "head" not in moved
    handle = next(each for each in view.bench.posture.handles if each.joint == "l_knee_y")
    assert view.bench.position(handle) == pytest.approx(np.radians(knee.max / 2), abs=1e-9)


def test_a_text_leaves_only_the_sliders_that_it_finds(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    page = opened(DesignView((humanoid,)))
    folder = [each for each in page.knobs if each.kind == "slider"]
    assert len(folder) == 25 + len(humanoid.own)
    page.knob("find").move("hip_z")
    sliders = [each.label for each in page.knobs if each.kind == "slider"]
    assert [label for label in sliders if "_hip_" in label] == ["l_hip_z", "r_hip_z"]
    page.knob("find").move("tentacle")
    assert "no joint is found" in [each.label for each in page.knobs]


def test_what_is_pointed_at_is_highlighted(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    page = opened(DesignView((humanoid,)))
    number = page.knob("r_hip_x")._impl.uuid
    page.knob("pointed at").move(number)
    assert page.chosen[-1] == (0, humanoid.robot.joint("r_hip_x").link)
    page.knob("pointed at").move("")
    assert page.chosen[-1] == (0, None)
    page.knob("pointed at").move("<script>")
    assert page.chosen[-1] == (0, None)
    # A parameter's slider highlights what it changes.
    page.knob("pointed at").move(page.knob("head_mass")._impl.uuid)
    assert page.chosen[-1] == (0, "head")


def test_a_click_on_a_link_seeks_its_joint(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    page = opened(DesignView((humanoid,)))
    joint = humanoid.robot.joint("l_elbow_y")
    page.stage.picked(0, joint.link)
    assert page.knob("find").value == "l_elbow_y"
    assert page.chosen[-1] == (0, joint.link)


def test_a_click_on_a_link_while_parameters_are_shown_offers_the_links_own(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    page = opened(DesignView((humanoid,)))
    page.press("Parameters")
    page.stage.picked(0, "head")
    assert page.knob("change").value == "head"
    assert {page.knob("size").kind, page.knob("mass").kind} == {"slider"}


def test_a_parameter_changes_mass_and_shows_the_original_as_a_ghost(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    view = DesignView((biped,))
    page = opened(view)
    page.work()
    page.knob("left_foot_size").move(1.5)
    page.work()
    heavier = biped.robot.link("left_foot").mass * (1.5**3 - 1.0)
    assert view.bench.built.robot.mass == pytest.approx(biped.robot.mass + heavier, abs=1e-9)
    assert page.cell("mass (kg)", 1) == f"{biped.robot.mass + heavier:.4g}"
    design, ghost = page.content.actors
    assert ghost.ghost
    assert ghost.lane == design.lane
    assert ghost.figure is biped.original.figure
    page.knob("show original").move(False)
    assert len(page.content.actors) == 1


def test_the_ghost_takes_the_same_pose(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    view = DesignView((biped,))
    page = opened(view)
    page.knob("left_foot_size").move(1.5)
    page.work()
    hip = next(h for h in view.bench.posture.handles if h.link == "left_thigh")
    view.turn(hip.joint, 0.4 * hip.high)
    design, ghost = page.content.actors
    thigh = biped.original.figure.links.index("left_thigh")
    assert ghost.motion.turn[0, thigh] == pytest.approx(design.motion.turn[0, thigh], abs=1e-12)


def test_a_body_of_another_mass_alone_has_no_ghost(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    page = opened(DesignView((biped,)))
    page.knob("torso_mass").move(1.5)
    page.work()
    assert len(page.content.actors) == 1


def test_a_drag_builds_once_at_a_time_and_the_last_at_last(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    view = DesignView((biped,))
    page = opened(view)
    page.work()
    for at in range(100):
        page.knob("torso_mass").move(1.0 + 0.01 * at)
    assert len(page.jobs) == 1
    page.work()
    assert view.bench.built.values == {"torso_mass": 1.99}
    assert page.shown <= 3
    page.press("Undo")
    page.work()
    assert view.bench.built is biped.original


def test_a_lock_takes_its_slider_away_and_undo_brings_it_back(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    view = DesignView((biped,))
    page = opened(view)
    knee = next(h.joint for h in view.bench.posture.handles if h.link == "left_shank")
    page.knob("left_knee_locked_at").move(True)
    page.work()
    assert knee not in [each.label for each in page.knobs]
    page.press("Undo")
    page.work()
    assert knee in [each.label for each in page.knobs]
    assert page.knob("left_knee_locked_at").value is False


def test_undo_moves_the_slider_back(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    page = opened(DesignView((humanoid,)))
    slider = page.knob("head_z")
    slider.move(0.5 * slider.max)
    page.press("Undo")
    assert slider.value == 0.0
    page.press("Redo")
    assert slider.value == pytest.approx(0.5 * slider.max, abs=0.1)
    page.press("Rest")
    assert slider.value == 0.0
    page.press("Random")
    assert slider.value != 0.0


def test_nothing_to_undo_is_told(opened: Callable[[DesignView], Any], humanoid: BodyPlan) -> None:
    page = opened(DesignView((humanoid,)))
    page.press("Undo")
    page.press("Redo")
    assert page.said == ["there is nothing to undo", "there is nothing to do again"]


def test_keys_act_only_while_the_view_is_shown(
    opened: Callable[[DesignView], Any], humanoid: BodyPlan
) -> None:
    view = DesignView((humanoid,))
    page = opened(view)
    view.turn("head_z", 0.1)
    page.view = None  # type: ignore[assignment]
    page.knob("design: undo").move()
    assert view.bench.choice.pose
    page.view = view
    page.knob("design: undo").move()
    assert not view.bench.choice.pose


def test_general_parameters_serve_a_body_without_its_own(
    opened: Callable[[DesignView], Any],
) -> None:
    view = DesignView((BodyPlan(load("so101")),))
    page = opened(view)
    page.knob("size").move(1.5)
    page.work()
    # By the cube of 1.5.
    assert view.bench.built.robot.mass == pytest.approx(0.632006 * 3.375, rel=1e-9)
    links = list(page.knob("change").options)
    page.knob("change").move(links[1])
    page.knob("mass").move(1.2)
    page.work()
    assert set(view.bench.built.values) == {"whole body: size", f"{links[1]}: mass"}


def test_several_bodies_are_designed_one_at_a_time(
    opened: Callable[[DesignView], Any], biped: BodyPlan, humanoid: BodyPlan
) -> None:
    view = DesignView((biped, humanoid))
    page = opened(view)
    page.work()
    view.set("torso_mass", 1.5)
    page.work()
    page.knob("body").move("2: humanoid")
    page.work()
    assert page.content.actors[0].figure.name == "humanoid"
    assert page.cell("mass (kg)", 1) == "3"
    page.knob("body").move("1: biped")
    page.work()
    assert view.bench.built.values == {"torso_mass": 1.5}


def test_two_persons_have_designs_of_their_own(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    one, other = DesignView((biped,)), DesignView((biped,))
    opened(one)
    opened(other)
    one.turn(one.bench.posture.handles[0].joint, 0.1)
    assert one.bench.choice.pose
    assert not other.bench.choice.pose
    first, second = (view.content().actors[0].motion.position for view in (one, other))
    assert (first != second).any()


def test_a_design_is_saved_under_a_new_name(
    opened: Callable[[DesignView], Any],
    biped: BodyPlan,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("MORPH_SHELF", str(tmp_path))
    view = DesignView((biped,))
    page = opened(view)
    view.set("torso_mass", 1.5)
    page.work()
    page.knob("name").move("heavy_biped")
    page.knob("Save as a new body").move()
    page.work()
    assert page.said == ["saved; see it by: morph view heavy_biped"]
    assert load("heavy_biped").mass == pytest.approx(view.bench.built.robot.mass, abs=1e-9)


def test_the_view_is_made_of_what_is_given() -> None:
    make = maker(ViewRequest(robots=(load("pendulum"),), asked=("pendulum",)))
    one, other = make(), make()
    assert isinstance(one, DesignView)
    assert isinstance(other, DesignView)
    assert one is not other
    assert one.plans is not None
    assert one.plans[0] is other.plans[0]


def test_a_page_that_is_written_has_all_figures(biped: BodyPlan) -> None:
    view = DesignView((BodyPlan(biped.robot),))
    assert "…" in {str(cell) for row in view.content().tables[0].rows for cell in row}
    view.complete()
    assert "…" not in {str(cell) for row in view.content().tables[0].rows for cell in row}


def test_controls_that_are_off_the_page_are_left_alone(
    opened: Callable[[DesignView], Any], biped: BodyPlan
) -> None:
    view = DesignView((biped,))
    page = opened(view)
    headline = next(each for each in page.knobs if each.kind == "html")
    before = headline.content
    page.view = None  # type: ignore[assignment]
    view.set("torso_mass", 1.5)
    page.work()
    assert headline.content == before
    assert page.shown == 0
