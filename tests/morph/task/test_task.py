"""Tasks against the thesis' own formulas, and what they refuse."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import RobotError, TaskError
from morph.task.moved import Moved
from morph.task.quantity import AngleSum, Commands, Direction, JointPositions, JointSpeeds, Point
from morph.task.start import Start
from morph.task.task import Task
from morph.task.tasks import TASKS, task
from morph.task.term import Goal, Term


@pytest.fixture(scope="module")
def swing() -> Task:
    return task("swing-up", load("cartpole"))


def moved(about: Task, position: Array, velocity: Array | None = None) -> Moved:
    """A motion of given positions, shape (rows, samples, nq), at the task's control times."""
    return Moved(
        robot=about.robot,
        model=about.simulator().model,
        time=about.period * np.arange(position.shape[-2]),
        position=position,
        velocity=np.zeros_like(position) if velocity is None else velocity,
        command=np.zeros((*position.shape[:-1], 1)),
    )


def test_the_swing_up_costs_what_the_thesis_says(swing: Task) -> None:
    rng = np.random.default_rng(0)
    q = rng.normal(size=(7, 61, 2)) * [0.5, 3.0]
    # d from the pole's tip (x + l sin, -l cos) to (0, l), l = 0.5 m; width 0.25 m.
    square = (q[..., 0] + 0.5 * np.sin(q[..., 1])) ** 2 + (-0.5 * np.cos(q[..., 1]) - 0.5) ** 2
    expected = (1.0 - np.exp(-square / (2.0 * 0.25**2))).sum(axis=-1)
    np.testing.assert_allclose(swing.loss(moved(swing, q)), expected, rtol=1e-12)
    assert swing.samples == 61


def test_hanging_for_the_whole_horizon_costs_nearly_one_a_sample(swing: Task) -> None:
    # d = 1 m: 61 (1 - exp(-8)) = 60.9795.
    assert swing.loss(moved(swing, np.zeros((1, 61, 2))))[0] == pytest.approx(60.97954, abs=1e-4)


@pytest.mark.parametrize(
    ("cart", "pole", "succeeds"),
    [
        (0.149, math.pi + 0.169, True),
        (0.149, -math.pi - 0.169, True),
        (0.149, 3.0 * math.pi - 0.169, True),
        (0.151, math.pi, False),
        (0.0, math.pi + 0.171, False),
    ],
)
def test_strict_means_within_15_cm_and_ten_degrees_however_often_it_turned(
    swing: Task, cart: float, pole: float, succeeds: bool
) -> None:
    assert bool(swing.succeeded(moved(swing, np.full((1, 61, 2), (cart, pole))))[0]) == succeeds


@pytest.mark.parametrize(("sample", "succeeds"), [(49, True), (50, False), (60, False)])
def test_strict_looks_at_the_last_half_second_alone(
    swing: Task, sample: int, succeeds: bool
) -> None:
    # Samples 50 to 60 lie at 2.5 to 3.0 s.
    q = np.full((1, 61, 2), (0.0, math.pi))
    q[0, sample, 0] = 0.5
    assert bool(swing.succeeded(moved(swing, q))[0]) == succeeds


def test_a_quadratic_term_is_half_the_squared_error_in_widths(swing: Task) -> None:
    term = Term(
        name="speed", quantity=JointSpeeds(joints=("hinge",)), target=(1.0,), width=2.0, weight=3.0
    )
    v = np.full((1, 61, 2), (9.0, 5.0))
    # 3 * ((5 - 1) / 2)^2 / 2 = 6.
    np.testing.assert_allclose(term.cost(moved(swing, np.zeros((1, 61, 2)), v)), 6.0)


def test_a_saturating_term_is_the_quadratic_one_near_its_target_and_never_above_its_weight(
    swing: Task,
) -> None:
    near = np.zeros((1, 61, 2))
    near[..., 0] = 1e-3
    quantity = JointPositions(joints=("slide",))
    kinds = [
        Term(name="place", quantity=quantity, target=(0.0,), width=0.5, weight=2.0, norm=norm)
        for norm in ("quadratic", "saturating")
    ]
    square, saturating = (term.cost(moved(swing, near)) for term in kinds)
    # 1 - exp(-a) = a - a^2/2, a = 2e-6.
    np.testing.assert_allclose(square, saturating, rtol=2e-6)
    assert kinds[1].cost(moved(swing, near * 1e5)).max() == pytest.approx(2.0)


def test_the_direction_of_a_pole_is_a_unit_vector_that_turns_with_it(swing: Task) -> None:
    angle = np.linspace(-4.0, 4.0, 9)
    q = np.stack([np.zeros(9), angle], axis=-1)[None]
    found = Direction(link="pole", axis=(0.0, 0.0, -1.0)).value(moved(swing, q))[0]
    expected = np.stack([np.sin(angle), np.zeros(9), -np.cos(angle)], axis=-1)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_the_start_spreads_every_state_as_told(swing: Task) -> None:
    model = swing.simulator().model
    q, v = swing.start.sample(swing.robot, model, 4000, np.random.default_rng(5))
    spread = np.concatenate([q, v], axis=1).std(axis=0)
    # A standard deviation from 4000 samples is within 1 / sqrt(8000) = 1.1 % one time in three.
    np.testing.assert_allclose(spread, 0.01, rtol=0.05)
    middle = swing.start.sample(swing.robot, model, 2, None)
    np.testing.assert_array_equal(np.concatenate(middle, axis=1), 0.0)


def test_the_hash_tells_tasks_apart_and_not_bodies(swing: Task) -> None:
    assert replace(swing, horizon=4.0).sha256 != swing.sha256
    assert replace(swing, noise=0.02).sha256 != swing.sha256
    assert replace(swing).sha256 == swing.sha256
    assert task("swing-up", load("cartpole")).sha256 == swing.sha256


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"horizon": 0.05}, None),
        ({"horizon": 0.0}, "horizon 0 s"),
        ({"horizon": 0.12}, "horizon 0.12 s"),
        ({"horizon": math.nan}, "horizon nan s"),
        ({"horizon": math.inf}, "horizon inf s"),
        ({"period": 0.0}, "period 0 s"),
        ({"period": 0.052}, "period 0.052 s"),
        ({"step": 0.0}, "step 0 s"),
        ({"step": 0.1}, "step 0.1 s"),
        ({"noise": -1.0}, "noise -1"),
        ({"noise": math.nan}, "noise nan"),
    ],
)
def test_times_and_noise_that_make_no_sense_are_refused(
    swing: Task, change: dict[str, float], message: str | None
) -> None:
    if message is None:
        # A horizon of one step is short, but it is a task.
        assert replace(swing, **change).samples == 2
        return
    with pytest.raises(TaskError, match=message):
        replace(swing, **change)


def test_a_body_without_actuators_has_no_task(swing: Task) -> None:
    with pytest.raises(TaskError, match="no actuator"):
        replace(swing, robot=replace(swing.robot, actuators=()))


def test_a_task_for_parts_that_the_body_lacks_is_refused_by_their_names(swing: Task) -> None:
    term = Term(name="place", quantity=Point(link="tail"), target=(0.0, 0.0, 0.0))
    with pytest.raises(RobotError, match="no link 'tail'"):
        replace(swing, terms=(term,))
    goal = Goal(name="there", quantity=AngleSum(joints=("knee",)), target=(0.0,), within=0.1)
    with pytest.raises(RobotError, match="no joint 'knee'"):
        replace(swing, goals=(goal,))
    effort = Term(name="effort", quantity=Commands(actuators=("elbow",)), target=(0.0,))
    with pytest.raises(RobotError, match="no actuator 'elbow'"):
        replace(swing, terms=(effort,))


def test_a_target_of_another_size_is_refused(swing: Task) -> None:
    term = Term(name="place", quantity=Point(link="pole", axes="xz"), target=(0.0, 0.0, 0.0))
    with pytest.raises(TaskError, match="has 3 targets, and point has 2 numbers"):
        replace(swing, terms=(term,))


@pytest.mark.parametrize("width", [0.0, -1.0, math.nan, math.inf])
def test_a_width_that_is_none_is_refused(width: float) -> None:
    with pytest.raises(TaskError, match="its width is"):
        Term(name="x", quantity=JointPositions(joints=("a",)), target=(0.0,), width=width)


def test_a_cost_that_is_no_number_is_told_by_its_term(swing: Task) -> None:
    q = np.zeros((1, 61, 2))
    q[0, 3, 0] = np.nan
    with pytest.raises(TaskError, match="'tip' is no number"):
        swing.loss(moved(swing, q))


def test_an_unknown_task_is_refused_with_the_nearest() -> None:
    with pytest.raises(TaskError, match="nearest are 'swing-up'"):
        task("swingup", load("cartpole"))


def test_a_negative_spread_is_refused() -> None:
    with pytest.raises(TaskError, match="its spread is -1"):
        Start(spread=-1.0)


@pytest.mark.parametrize("name", ["swing-up", "balance"])
def test_a_body_that_cannot_stand_upright_is_told_which_joint_hinders_it(name: str) -> None:
    assert name in TASKS
    if name == "swing-up":
        with pytest.raises(TaskError, match=r"'ankle' would have to stand at 3.14 rad"):
            task(name, load("rider_two_links_driven"))
    else:
        # Its arms cannot be held up, so they hang.
        assert task(name, load("rider_five_links_driven")).start.position["shoulder"] == 0.0


def test_a_run_that_became_unstable_never_succeeds_and_costs_more_than_any_other(
    swing: Task,
) -> None:
    q = np.full((2, 61, 2), (0.0, math.pi))
    seen = replace(moved(swing, q), stable=np.array([True, False]))
    np.testing.assert_array_equal(swing.succeeded(seen), [True, False])
    np.testing.assert_allclose(swing.loss(seen), [0.0, 1e9], atol=1e-9)


TURNED = """<mujoco><worldbody><body name="a"><joint name="one" axis="0 {first} 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02"/><body name="b" pos="0 0 -0.3">
<joint name="two" axis="0 {second} 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02"/>
</body></body></worldbody><actuator><motor joint="one" ctrlrange="-1 1"/>
<motor joint="two" ctrlrange="-1 1"/></actuator></mujoco>"""


@pytest.mark.parametrize("axes", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_how_a_link_leans_does_not_depend_on_which_way_its_hinges_count(
    axes: tuple[int, int], tmp_path: Path
) -> None:
    (tmp_path / "robot.xml").write_text(TURNED.format(first=axes[0], second=axes[1]))
    about = task("balance", load(tmp_path / "robot.xml"))
    rng = np.random.default_rng(2)
    q = np.array(list(about.start.position.values())) + rng.uniform(-0.5, 0.5, (50, 2))
    seen = moved(about, q[:, None])
    # The outer link, drawn downward in its own frame, points up where it stands.
    up = -seen.pose(about.simulator().model.body("b").id).rotation[:, 0, 2, 2]
    lean = np.abs(about.goals[1].quantity.error(seen, about.goals[1].target))[:, 0, 0]
    np.testing.assert_allclose(np.cos(lean), up, atol=1e-9)


def test_goals_that_ask_for_nothing_and_names_that_stand_twice_are_refused(swing: Task) -> None:
    quantity = JointPositions(joints=("slide",))
    with pytest.raises(TaskError, match="whatever happens reaches it"):
        Goal(name="there", quantity=quantity, target=(0.0,))
    with pytest.raises(TaskError, match="its target is no finite number"):
        Goal(name="there", quantity=quantity, target=(math.nan,), within=1.0)
    for change in ({"goals": ()}, {"terms": ()}, {"terms": swing.terms * 2}):
        with pytest.raises(TaskError, match="each with a name of its own"):
            replace(swing, **change)
    with pytest.raises(TaskError, match="its start names 'knee'"):
        replace(swing, start=Start(position={"knee": 1.0}))
