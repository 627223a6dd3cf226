"""One person's design of one body."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from morph.app.viewer.design.design_state import Bench, BodyPlan
from morph.app.viewer.design.figures import figures, headline, limits_note, motors
from morph.body.load import load
from morph.body.robot import Robot


@pytest.fixture(scope="module")
def biped() -> BodyPlan:
    return BodyPlan(load("biped"))


def rebuilt(bench: Bench) -> None:
    bench.take(bench.plan.built(bench.choice.values))


def test_a_parameter_makes_the_body_stale_until_it_is_built(biped: BodyPlan) -> None:
    bench = Bench(biped)
    assert not bench.stale
    bench.set("torso_mass", 1.5, 0.0)
    assert bench.stale
    assert bench.built.robot is biped.robot
    rebuilt(bench)
    torso = biped.robot.link("torso").mass
    assert not bench.stale
    assert bench.built.robot.mass == pytest.approx(biped.robot.mass + 0.5 * torso, abs=1e-9)


def test_a_parameter_where_it_changes_nothing_is_not_set(biped: BodyPlan) -> None:
    bench = Bench(biped)
    bench.set("torso_mass", 1.5, 0.0)
    bench.set("torso_mass", 1.0, 9.0)
    assert bench.choice.values == {}
    assert not bench.stale


def test_values_beyond_a_range_or_of_no_parameter_do_no_harm(biped: BodyPlan) -> None:
    bench = Bench(biped)
    bench.set("torso_mass", 1e9, 0.0)
    assert bench.choice.values == {"torso_mass": 2.0}
    bench.set("torso_mass", math.nan, 5.0)
    assert bench.choice.values == {}
    bench.set("wings", 2.0, 10.0)
    assert bench.choice.values == {}
    assert bench.turn("wing", 1.0, 15.0)


def test_a_turned_joint_stays_turned_when_the_body_is_built_anew(biped: BodyPlan) -> None:
    bench = Bench(biped)
    handle = bench.posture.handles[3]
    bench.turn(handle.joint, 0.5 * handle.high, 0.0)
    bench.set("torso_mass", 1.5, 5.0)
    rebuilt(bench)
    assert bench.position(handle) == pytest.approx(0.5 * handle.high, abs=1e-12)


def test_a_joint_that_was_locked_comes_back_where_it_was(biped: BodyPlan) -> None:
    bench = Bench(biped)
    knee = next(each for each in bench.posture.handles if each.link == "left_shank")
    bench.turn(knee.joint, 0.5 * (knee.low + knee.high), 0.0)
    turned = bench.position(knee)
    bench.set("left_knee_locked_at", 0.2, 5.0)
    rebuilt(bench)
    assert knee.joint not in [each.joint for each in bench.posture.handles]
    bench.turn(bench.posture.handles[0].joint, 0.01, 10.0)
    bench.set("left_knee_locked_at", None, 15.0)
    rebuilt(bench)
    assert bench.position(knee) == pytest.approx(turned, abs=1e-12)


def test_undo_takes_back_a_drag_and_then_a_parameter(biped: BodyPlan) -> None:
    bench = Bench(biped)
    bench.set("torso_mass", 1.5, 0.0)
    rebuilt(bench)
    joint = bench.posture.handles[0]
    for at in range(10):
        bench.turn(joint.joint, 0.01 * at, 5.0 + 0.05 * at)
    assert bench.history.undo()
    bench.adopt()
    assert bench.position(joint) == joint.rest
    assert bench.history.undo()
    assert bench.stale
    rebuilt(bench)
    assert bench.built.robot is biped.robot


def test_random_poses_are_within_limits_and_rest_undoes_them(biped: BodyPlan) -> None:
    bench = Bench(biped)
    bench.random(np.random.default_rng(1), 0.0)
    places = [bench.position(handle) for handle in bench.posture.handles]
    for handle, place in zip(bench.posture.handles, places, strict=True):
        assert handle.low <= place <= handle.high
    assert bench.choice.pose
    bench.rest(5.0)
    assert bench.choice.pose == {}
    assert [bench.position(handle) for handle in bench.posture.handles] == [
        handle.rest for handle in bench.posture.handles
    ]


def test_what_is_pointed_at_is_seen_even_if_it_is_not_drawn(biped: BodyPlan) -> None:
    bench = Bench(biped)
    links = {link.name for link in biped.robot.links}
    for joint in biped.robot.joints:
        assert bench.seen(joint.name) in links
    assert bench.seen("left_shank") == "left_shank"
    assert bench.seen("nothing") is None
    assert bench.seen(None) is None


def test_tables_hold_the_figures_and_what_changed(biped: BodyPlan) -> None:
    bench = Bench(biped)
    bench.set("torso_mass", 2.0, 0.0)
    rebuilt(bench)
    table = figures(bench, bench.built.measures, biped.original.measures)
    rows = {str(row[0]): row[1:] for row in table.rows}
    more = biped.robot.link("torso").mass / biped.robot.mass
    assert rows["mass (kg)"] == (
        f"{bench.built.robot.mass:.4g}",
        f"{biped.robot.mass:.4g}",
        f"{100 * more:+.1f} %",
    )
    assert rows["reach (m)"][2] == "="
    assert rows["margin, worst of 201 poses"][2] == "="
    loads = motors(bench, bench.built.measures)
    left = [float(str(row[4]).removesuffix(" %")) for row in loads.rows]
    assert left == sorted(left)
    assert len(left) == 6
    assert f"({100 * more:+.1f} %)" in headline(
        bench, bench.built.measures, biped.original.measures
    )


def test_figures_that_are_not_known_yet_are_told_as_such(biped: BodyPlan) -> None:
    bench = Bench(biped)
    rows = {str(row[0]): row[1:] for row in figures(bench, None, None).rows}
    assert rows["reach (m)"] == ("…", "…", "")
    assert {row[2] for row in motors(bench, None).rows} == {"…"}
    assert "reach" not in headline(bench, None, None)


def test_a_heavy_link_shows_in_the_margin_of_the_motor_that_holds_it(
    arm: Callable[..., Robot],
) -> None:
    plan = BodyPlan(arm())
    bench = Bench(plan)
    bench.set("lower: mass", 2.0, 0.0)
    rebuilt(bench)
    # Level, at rest: elbow 2 * 1 kg * 0.1 m * g = 1.962 N m of 4, shoulder
    # (2 * 0.2 + 2 * 0.5) * g = 13.734 N m of 20: 51 % and 31 % are left.
    rows = {str(row[0]): row[1:] for row in figures(bench, None, None).rows}
    assert rows["margin here"][0] == "31 % shoulder_\u200bmotor"
    held = {str(row[0]): row[1] for row in motors(bench, None).rows}
    assert held == {"shoulder_motor": "13.7", "elbow_motor": "1.96"}
    assert limits_note(bench.limits).endswith("2 of 2 motors have a known limit.")


def test_a_body_without_motors_has_figures_too(long_snake: Robot) -> None:
    bench = Bench(BodyPlan(long_snake))
    table = figures(bench, bench.built.measures, bench.built.measures)
    rows = {str(row[0]): row[1:] for row in table.rows}
    assert rows["margin here"][0] == "–"
    assert rows["margin, worst of 201 poses"][0] == "–"
    assert rows["joints"][0] == "48"
    assert motors(bench, None).rows == ()
