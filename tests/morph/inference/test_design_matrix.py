"""Columns of effects along runs: which shapes go on to the search, and of which run they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.columns import Columns
from morph.inference.design_matrix import (
    SCREENED,
    SHAPES,
    _without,
    believed,
    effect_columns,
    screened,
)
from morph.inference.dictionary import _prior, dictionary, search_beside
from morph.inference.quadratic import quadratic
from morph.inference.refit import Refit, refitted, seen
from morph.inference.sticking import sensed
from morph.inference.whitened import whitened
from morph.model.episodes import Episode, episode
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Channel, Recording

STEP, FINE, INERTIA, LIMIT, NOISE = 0.004, 16, 0.02, 0.3, 1e-4
WHEELS = f"""
<mujoco model="wheels">
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="one"><joint name="first" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body>
    <body name="two"><joint name="second" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="{INERTIA} {INERTIA} {INERTIA}"/></body>
  </worldbody>
  <actuator><motor name="first" joint="first"/><motor name="second" joint="second"/></actuator>
</mujoco>
"""


def turned(torque: Array) -> Array:
    """Return the angle of a wheel whose motor gives no more than its limit, at each sample."""
    angle, rate, angles = 0.0, 0.0, []
    for now in np.clip(torque, -LIMIT, LIMIT).tolist():
        angles.append(angle)
        rate += STEP * now / INERTIA
        angle += STEP * (rate - 0.5 * STEP * now / INERTIA)
    return np.array(angles)


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """Return two wheels."""
    path: Path = tmp_path_factory.mktemp("wheels") / "wheels.xml"
    path.write_text(WHEELS)
    return load(path)


@pytest.fixture(scope="module")
def episodes(robot: Robot) -> list[Episode]:
    """Return a long calm run and a short wild one."""
    rng, runs = np.random.default_rng(0), []
    for name, size, samples in (("calm", 0.1, 1500), ("wild", 0.5, 500)):
        time = STEP * np.arange(samples)
        torque = {"first": size * np.cos(6.0 * time), "second": 0.2 * np.cos(4.0 * time)}
        channels = {
            f"{n}.command": Channel(time=time, value=u, hold=True) for n, u in torque.items()
        }
        for joint, u in torque.items():
            read = turned(u) + NOISE * rng.normal(size=samples)
            channels[f"{joint}.position"] = Channel(time=time, value=read)
        runs.append(episode(Recording(name=name, channels=channels), robot, STEP))
    return runs


@pytest.fixture(scope="module")
def base(robot: Robot, episodes: list[Episode]) -> Refit:
    """Return a refit of the wheels without an effect."""
    nominal = Hypothesis(robot=robot, step=STEP, knobs=())
    return refitted(nominal, nominal.start, episodes)


def shapes(robot: Robot, base: Refit, label: str) -> tuple[Effect, ...]:
    """Return the shapes of an effect in the dictionary."""
    return next(grid for grid in dictionary(robot, base.runs, ()) if grid[0].label == label)


def test_limits_are_tried_up_to_the_greatest_torque_of_any_run(robot: Robot, base: Refit) -> None:
    grid = shapes(robot, base, "torque_saturation@first")
    limits = [shape.limit for shape in grid if isinstance(shape, TorqueSaturation)]
    # The calm run is longer, but its torque is 0.1 N m.
    shares = [0.01, 0.02, 0.03, *(0.05 * twentieth for twentieth in range(1, 20))]
    assert limits == pytest.approx([0.5 * share for share in shares], rel=1e-3)


def test_what_acts_everywhere_is_looked_for_once(robot: Robot, base: Refit) -> None:
    labels = [grid[0].label for grid in dictionary(robot, base.runs, ())]
    assert [label for label in labels if label.startswith("voltage_sag")] == ["voltage_sag@first"]
    assert sum(label.startswith("torque_scale") for label in labels) == 2


@pytest.mark.parametrize("law", ["coulomb_friction", "series_elasticity"])
def test_a_law_of_drives_is_one_proposal_at_all_driven_joints(base: Refit, law: str) -> None:
    search = search_beside(base, (), None, 1)
    both = {f"{law}@first", f"{law}@second"}
    groups = [{search.columns[at].label for at in group} for group in search.groups]
    assert both in groups
    # The price of one at the same number of shapes, not of two.
    assert search.prior.price(both) < sum(search.prior.alone[label] for label in both) - 3.0


def test_the_shapes_that_alone_gain_most_are_searched(robot: Robot, base: Refit) -> None:
    grids = [shapes(robot, base, f"{law}@first") for law in ("torque_saturation", "backlash")]
    own = Columns.of(base.hypothesis, base.point)
    kept = screened(own, grids, base.runs)
    for grid, few in zip(grids, kept, strict=True):
        gains = []
        for level in SCREENED:
            gains.append([alone(base, shape, level) for shape in grid])
        best = {int(at) for each in gains for at in np.argsort(each)[-SHAPES:]}
        assert few == tuple(grid[at] for at in sorted(best))


def test_no_run_tells_torques_and_inertias_that_are_off_by_one_factor(
    robot: Robot, episodes: list[Episode], base: Refit
) -> None:
    vary = {"mass": 0.0, "com": 0.0, "inertia": 0.1, "gain": 0.1}
    limit = TorqueSaturation(actuator="first", limit=LIMIT)
    whole = Hypothesis(robot=robot, step=STEP, knobs=knobs(robot, vary), effects=(limit,))
    runs = seen(whole, whole.start, episodes, base.runs)
    gram = quadratic(whole, whole.start, runs).grams.sum(axis=0)[1:, 1:]
    off = np.zeros(len(whole.names))
    off[[whole.names.index(name) for name in ("inertia:one", "gain:first")]] = 1.0
    gain = np.where(np.char.startswith(whole.names, "gain:first"), 1.0, 0.0)
    # The entry of a limit is one over it.
    off[-1] = -whole.start[-1]
    # A difference by a thousandth of the limit errs by as much, at as few samples: 1e-3 cubed.
    assert off @ gram @ off < 1e-9 * (gain @ gram @ gain)


def alone(base: Refit, shape: Effect, level: float) -> float:
    """Return what an effect at one shape and any strength gains, nats, by the whole Gram matrix."""
    gram = np.zeros((2, 2))
    for run in base.runs:
        about = run.about
        force = shape.regressor(sensed(list(run.motion.joints), run.motion, about))
        moved = np.concatenate([-about.acceleration[:, :, None], about.mobility @ force], axis=2)
        shown = np.concatenate([about.error[:, :, None], np.zeros_like(moved[:, :, 1:])], axis=2)
        gram += whitened(about.tangent, about.leaving(level), shown, moved).gram
    (column,) = effect_columns([(shape,)])
    low, high = column.bounds
    best = float(np.clip(gram[0, 1] / max(gram[1, 1], 1e-300), low[0], high[0]))
    return float(best * gram[0, 1] - 0.5 * best**2 * gram[1, 1])


def test_a_prior_is_as_good_as_readings_of_the_figures() -> None:
    rng = np.random.default_rng(0)
    columns, error, effects = (rng.normal(size=(30, k)) for k in (3, 1, 2))
    trust, point = np.array([4.0, 100.0, 0.5]), np.array([0.3, -0.1, 0.2])
    whole = np.column_stack([error, columns, effects])
    rows = np.zeros((3, 6))
    rows[:, 0], rows[:, 1:4] = -np.sqrt(trust) * point, np.diag(np.sqrt(trust))
    stacked = np.concatenate([whole, rows])
    gram, exact = whole.T @ whole, stacked.T @ stacked
    assert np.allclose(believed(gram, trust, point), exact, atol=1e-12)
    # Also of some rows: what is left of errors and effects without own parameters.
    own = np.concatenate([columns, rows[:, 1:4]])
    rest = stacked - own @ np.linalg.lstsq(own, stacked, rcond=None)[0]
    along, square = _without(believed(gram[:4], trust, point), np.diag(exact), 3)
    assert along == pytest.approx((rest.T @ rest)[0, 4:], abs=1e-12)
    assert square == pytest.approx(np.diag(rest.T @ rest)[4:], abs=1e-12)


def test_of_a_joint_that_never_moves_no_law_is_looked_for(
    robot: Robot, episodes: list[Episode]
) -> None:
    held = [replace(run, reading=run.reading * np.array([1.0, 0.0])) for run in episodes]
    nominal = Hypothesis(robot=robot, step=STEP, knobs=())
    base = refitted(nominal, nominal.start, held)
    names: dict[str, set[str]] = {"first": set(), "second": set()}
    motors = set()
    for grid in dictionary(robot, base.runs, ()):
        if grid[0].where in names and grid[0].kind == "joint":
            names[grid[0].where].add(grid[0].name)
        if grid[0].kind == "actuator":
            motors.add(robot.actuator(grid[0].where).joint)
    assert motors == {"first"}
    assert {"armature", "viscous_friction", "coulomb_friction"} < names["first"]
    assert not names["second"]


def test_one_law_at_all_joints_costs_as_one_where_another_is_looked_for_at_some() -> None:
    joints = {"a", "b", "held"}
    dry = [(CoulombFriction(joint=joint, c=1.0),) for joint in sorted(joints)]
    wet = [(ViscousFriction(joint=joint, b=1.0),) for joint in ("a", "b")]
    prior = _prior([*dry, *wet], joints, wet=False)
    everywhere = [f"coulomb_friction@{joint}" for joint in joints]
    beside = [*everywhere, "viscous_friction@a", "viscous_friction@b"]
    assert (
        prior.price(beside)
        == prior.price(everywhere)
        < sum(prior.alone[label] for label in everywhere)
    )
    # What was not looked for costs as the dearest.
    assert prior.price(["tether@c"]) == max(prior.alone.values())
