"""States and parameters together, against exact Gaussian algebra and against the truth."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from scipy.stats import multivariate_normal

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.hypothesis import Hypothesis
from morph.model.latent.infer import infer
from morph.model.latent.run import Run
from morph.model.latent.unknowns import turned, unknowns

NOISE = np.full(4, 0.01)


def hypothesis(robot: Robot, width: float = 1.2) -> Hypothesis:
    return Hypothesis(robot=robot, step=0.01, knobs=unknowns(robot, width))


def test_the_evidence_is_that_of_exact_algebra_where_everything_is_linear(
    tmp_path: pytest.TempPathFactory,
) -> None:
    # A mass on a slide with a damper is linear, so the readings are jointly normal: with
    # x_(t+1) = A x_t + b u_t + w the covariance of all of them is written down whole. The first
    # state has no prior: a very wide one of variance V adds -log(2 pi V) over its two numbers.
    from morph.body.load import load

    folder = tmp_path / "mass"  # type: ignore[operator]
    folder.mkdir()
    (folder / "mass.xml").write_text(
        """<mujoco model="mass"><worldbody><body name="mass">
        <inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>
        <joint name="slide" type="slide" axis="1 0 0" damping="0.3"/></body></worldbody>
        <actuator><motor name="slide" joint="slide" ctrllimited="true" ctrlrange="-9 9"/></actuator>
        </mujoco>"""
    )
    robot = load(folder / "mass.xml")
    rng = np.random.default_rng(1)
    periods, period, noise = 12, 0.05, 0.01
    decay = np.exp(-0.3 / 2.0 * period)
    A = np.array([[1.0, (1.0 - decay) * 2.0 / 0.3], [0.0, decay]])
    b = np.array([(period - (1.0 - decay) * 2.0 / 0.3) / 0.3, (1.0 - decay) / 0.3])
    u = rng.uniform(-5.0, 5.0, periods)
    x = np.zeros((periods + 1, 2))
    for t in range(periods):
        x[t + 1] = A @ x[t] + b * u[t]
    y = x + noise * rng.standard_normal(x.shape)
    run = Run(position=y[:, :1], velocity=y[:, 1:], command=u[:, None], period=period)
    found = infer(
        Hypothesis(robot=robot, step=0.01, knobs=()), [run], np.full(2, noise), integrator="rk4"
    )
    V = 1e2
    mean, covariance = _joint(A, b, u, 1.0 / found.trust.moved, V)
    covariance += noise**2 * np.eye(len(covariance))
    exact = multivariate_normal(mean, covariance).logpdf(y.ravel())
    exact += 2 * 0.5 * np.log(2.0 * np.pi * V)
    # Rounding of a 26 by 26 covariance of condition 1e8, and the finite V: 1e-3 is generous.
    assert found.evidence == pytest.approx(exact, abs=2e-3)


def _joint(A: Array, b: Array, u: Array, Q: Array, V: float) -> tuple[Array, Array]:
    n, times = 2, len(u) + 1
    mean = np.zeros((times, n))
    reach = np.zeros((times * n, times * n))
    power = [np.eye(n)]
    for _ in u:
        power.append(A @ power[-1])
    for t in range(times):
        if t:
            mean[t] = A @ mean[t - 1] + b * u[t - 1]
        for s in range(t + 1):
            reach[t * n : t * n + n, s * n : s * n + n] = power[t - s]
    chance = np.concatenate([np.full(n, V), np.tile(Q, len(u))])
    return mean.ravel(), reach @ np.diag(chance) @ reach.T


@pytest.mark.parametrize(
    ("name", "factor"), [("length:pole", 2.0), ("weight:cart", 4.0), ("damping:slide", 0.25)]
)
def test_a_figure_that_is_far_off_is_found_within_four_deviations(
    cartpole: Robot, shown, name: str, factor: float
) -> None:
    run = shown(turned(cartpole, {name: factor}), seed=3)
    # Only what differs is free: weights, gain and damping share a scale that no run tells.
    knobs = tuple(knob for knob in unknowns(cartpole, 1.2) if knob.name == name)
    found = infer(
        Hypothesis(robot=cartpole, step=0.01, knobs=knobs), [run], NOISE, integrator="rk4"
    )
    off = abs(found.point[0] - np.log(factor))
    assert off < 4.0 * np.sqrt(found.covariance[0, 0])
    assert off < 0.05


def test_intervals_hold_as_often_as_they_say(cartpole: Robot, shown) -> None:
    # 12 runs, 5 free figures each (all but the gain), 90 % intervals: 60 that hold with
    # probability 0.9. Figures of one run are dependent, so count as about 24 independent ones:
    # deviation sqrt(0.9 * 0.1 / 24) = 0.061, and 0.72 to 1 are three of them.
    knobs = tuple(knob for knob in unknowns(cartpole, 1.2) if knob.kind != "gain")
    truth = {"length:pole": 1.2, "weight:pole": 0.9}
    robot = turned(cartpole, truth)
    expected = np.array([np.log(truth.get(knob.name, 1.0)) for knob in knobs])
    held = []
    for seed in range(12):
        whole = Hypothesis(robot=cartpole, step=0.01, knobs=knobs)
        found = infer(whole, [shown(robot, seed=seed)], NOISE, integrator="rk4")
        deviation = np.sqrt(np.diag(found.covariance))
        held.append(np.abs(found.point - expected) < 1.645 * deviation)
    assert np.mean(held) > 0.72


def test_noise_counts_once_though_it_enters_two_transitions(cartpole: Robot, shown) -> None:
    # The true states of a perfect model are found better than they were read: with about as many
    # free numbers as four states and five figures, far below the noise.
    robot = cartpole
    model = hypothesis(robot, 0.05)
    run = shown(robot, seed=5)
    found = infer(model, [run], NOISE, integrator="rk4")
    clean = _true_states(robot, run)
    off = np.sqrt(np.mean((found.states[0] - clean) ** 2))
    # 9 numbers from 244 readings: noise * sqrt(9 / 244) = 0.0019; twice that.
    assert off < 0.004


def _true_states(robot: Robot, run: Run) -> Array:
    """The same run, simulated anew: its start is known to be drawn first by the same chance."""
    from morph.task.swing_up import swing_up

    task = swing_up(robot)
    model = task.simulator().model
    rng = np.random.default_rng(5)
    rng.uniform(-8.0, 8.0, (15, 1))
    q, v = task.start.sample(robot, model, 1, rng)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q[0], v[0]
    states = [np.concatenate([data.qpos, data.qvel])]
    for command in run.command:
        data.ctrl[:] = command
        mujoco.mj_step(model, data, nstep=5)
        states.append(np.concatenate([data.qpos, data.qvel]))
    return np.array(states)


def test_a_motion_that_no_parameter_reaches_is_still_followed(cartpole: Robot, shown) -> None:
    # A spring that the model has no figure for: what is left out must be said to be much.
    from morph.physics import EFFECTS

    spring = next(each for each in EFFECTS if each.name == "joint_stiffness")
    run = shown(cartpole, (spring(joint="slide", k=15.0),), seed=1)
    found = infer(hypothesis(cartpole), [run], NOISE, integrator="rk4")
    clean = infer(hypothesis(cartpole), [shown(cartpole, seed=1)], NOISE, integrator="rk4")
    assert found.unsaid > 10.0 * clean.unsaid
    # Read with a deviation of 0.01: no state is moved by more than five.
    assert np.abs(found.states[0] - run.state).max() < 0.05


def test_runs_of_different_clocks_are_refused(cartpole: Robot, shown) -> None:
    run = shown(cartpole, seed=0)
    other = Run(position=run.position, velocity=run.velocity, command=run.command, period=0.1)
    with pytest.raises(DiagnosisError, match=r"control periods of \[0.05, 0.1\] s"):
        infer(hypothesis(cartpole), [run, other], NOISE)


def test_a_body_that_floats_is_refused() -> None:
    from morph.body.load import load

    swimmer = load("hexapod_swimmer")
    run = Run(
        position=np.zeros((5, 13)), velocity=np.zeros((5, 12)), command=np.zeros((4, 6)), period=0.1
    )
    with pytest.raises(DiagnosisError, match="hinges and slides alone"):
        infer(Hypothesis(robot=swimmer, step=0.01, knobs=()), [run], np.full(24, 0.01))
