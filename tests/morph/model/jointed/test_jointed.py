"""What is learned of a body whose equation is known: a = (u - b v - m g l sin q) / (m l^2)."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.jointed.draws import draw
from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed, through
from morph.model.jointed.kernel import gram
from morph.model.jointed.transition import JointTransitions, transitions

H = 0.05
PUSH = 3.0
NOISE = 0.005


def acceleration(q: Array, v: Array, u: Array) -> Array:
    """Return that of a pendulum of 1 kg, 0.5 m and 0.1 N m s."""
    return (u - 0.1 * v - 9.81 * 0.5 * np.sin(q)) / 0.25


def later(q: float, v: float, u: float, steps: int = 50) -> tuple[float, float]:
    """Return position and velocity a period later, by the midpoint rule in small steps."""
    h = H / steps
    for _ in range(steps):
        w = v + 0.5 * h * float(acceleration(np.array(q), np.array(v), np.array(u)))
        v += h * float(acceleration(np.array(q + 0.5 * h * v), np.array(w), np.array(u)))
        q += h * w
    return q, v


def pushed(periods: int, noise: float = NOISE, push: float = PUSH) -> JointTransitions:
    """Return periods under random torques, each held for four."""
    rng = np.random.default_rng(3)
    u = np.repeat(rng.uniform(-push, push, periods // 4 + 1), 4)[:periods]
    state = [(0.0, 0.0)]
    for each in u:
        state.append(later(*state[-1], float(each)))
    q, v = np.array(state).T[:, :, None]
    blur = noise * rng.standard_normal((2, periods + 1, 1))
    return transitions([(q + blur[0], v + blur[1], u[:, None])], H)


@pytest.fixture(scope="module")
def learned() -> Jointed:
    return fit(pushed(120), JointedSettings(turning=(0,), command_size=(PUSH,)))


def asked(rows: int) -> tuple[torch.Tensor, ...]:
    rng = np.random.default_rng(4)
    q, v, u = (
        rng.uniform(-np.pi, np.pi, rows),
        rng.uniform(-5.0, 5.0, rows),
        rng.uniform(-3, 3, rows),
    )
    return tuple(torch.as_tensor(a[:, None]) for a in (q, v, u))


def missed(model: Jointed) -> float:
    """Return by how much a model misses accelerations under large torques, near the rest below."""
    q, v, u = asked(300)
    q, v = 0.1 * q, 0.2 * v
    known = acceleration(*(a.numpy() for a in (q, v, u)))
    return float(np.sqrt(np.mean((model.mean(q, v, u).numpy() - known) ** 2)) / known.std())


def test_a_law_tells_what_torques_do_that_were_never_tried() -> None:
    # Torques of up to 0.6 N m were seen, and five times as much is asked about. The law is affine
    # in torques; its slope, 1 / (m l^2) = 4, comes of 120 accelerations of which each says
    # 4 * 0.35 = 1.4 of it in noise of 0.14: 0.14 / 1.4 / sqrt(120) = 1 %, and a few times more
    # as the slope may change with the posture, for all that is known.
    data = pushed(120, push=0.6)
    law, free = (
        fit(data, JointedSettings(turning=(0,), command_size=(PUSH,), lawful=lawful))
        for lawful in (True, False)
    )
    assert missed(law) < 0.08
    assert missed(law) < 0.5 * missed(free)


def test_the_noise_that_was_added_is_found(learned: Jointed) -> None:
    # Noise in positions adds up to g / l 0.005 0.05, a tenth, to that of velocities.
    assert learned.velocity_noise == pytest.approx([NOISE], rel=0.25)


def test_a_step_through_a_whole_period_is_right(learned: Jointed) -> None:
    q, v, u = (0.5 * each for each in asked(50))
    found_q, found_v = (a.numpy()[:, 0] for a in through(learned.mean, q, v, u, H))
    begun = torch.cat([q, v, u], dim=-1).tolist()
    known = np.array([later(at, speed, push) for at, speed, push in begun])
    # An acceleration that errs by 2 % of 15 moves a velocity by 0.015 in a period.
    assert np.abs(found_v - known[:, 1]).max() < 0.06
    assert np.abs(found_q - known[:, 0]).max() < 0.003


def test_the_mean_is_that_of_the_textbook(learned: Jointed) -> None:
    q, v, u = asked(40)
    scales, here = learned.parts[0].scales, learned.look(q, v, u)
    K = gram(learned.layout, scales, learned.seen, learned.seen).numpy()
    K += (float(scales.noise) ** 2 + 1e-6) * np.eye(len(K))
    across = gram(learned.layout, scales, here, learned.seen).numpy()
    textbook = across @ np.linalg.solve(K, learned.target.numpy()) * float(learned.size)
    # Landmarks leave out 1e-4 of the prior's variance, so 1e-2 of its deviation where no data are.
    off = np.abs(textbook - learned.mean(q, v, u).numpy()).max()
    assert off < 0.01 * float(learned.size)


def test_draws_have_the_mean_and_the_variance_that_are_believed(learned: Jointed) -> None:
    q, v, u = asked(12)
    count = 4000
    drawn = draw(learned, count, np.random.default_rng(5))
    many = (a.expand(count, -1, -1) for a in (q, v, u))
    told = drawn.accelerate(*many)[..., 0].numpy()
    mean, deviation = learned.mean(q, v, u)[:, 0], learned.variance(q, v, u)[:, 0].sqrt()
    # The standard error of a mean is 1 / sqrt(4000), of a deviation 1 / sqrt(8000); five of each.
    off = (told.mean(axis=0) - mean.numpy()) / deviation.numpy()
    assert np.abs(off).max() < 5.0 / np.sqrt(count)
    assert told.std(axis=0) == pytest.approx(deviation.numpy(), rel=5.0 / np.sqrt(2.0 * count))


def test_draws_of_a_body_without_a_law_spread_like_its_belief() -> None:
    learned = fit(pushed(40), JointedSettings(turning=(0,), command_size=(PUSH,), lawful=False))
    q, v, u = asked(8)
    drawn = draw(learned, 2000, np.random.default_rng(6))
    told = drawn.accelerate(*(a.expand(2000, -1, -1) for a in (q, v, u)))[..., 0].numpy()
    deviation = learned.variance(q, v, u)[:, 0].sqrt().numpy()
    # The prior has 64 waves in place of all: its variance errs by about 1 / sqrt(64).
    assert told.std(axis=0) == pytest.approx(deviation, rel=0.3)


def test_more_data_leave_less_doubt(learned: Jointed) -> None:
    few = fit(pushed(40), JointedSettings(turning=(0,), command_size=(PUSH,)))
    q, v, u = (0.3 * each for each in asked(50))
    # Three times the data leave a third of the variance, if the settings were the same.
    assert learned.variance(q, v, u).mean() < 0.7 * few.variance(q, v, u).mean()


def test_dry_friction_is_left_to_the_free_part() -> None:
    """The same pendulum, slowed by 1 N m of friction that turns with the velocity's sign."""
    rng = np.random.default_rng(7)
    q, v = rng.uniform(-np.pi, np.pi, (200, 1)), rng.uniform(-4.0, 4.0, (200, 1))
    u = rng.uniform(-PUSH, PUSH, (200, 1))
    change = H * (acceleration(q, v, u) - 4.0 * np.tanh(4.0 * v))
    data = JointTransitions(
        position=q,
        velocity=v,
        command=u,
        next_position=q + H * (v + 0.5 * change),
        next_velocity=v + change,
        period=H,
    )
    found = fit(data, JointedSettings(turning=(0,), command_size=(PUSH,)))
    assert float(found.parts[0].scales.free) > 0.0
    smooth = fit(pushed(120), JointedSettings(turning=(0,), command_size=(PUSH,)))
    assert float(smooth.parts[0].scales.free) == 0.0


def test_a_joint_that_never_moved_is_refused() -> None:
    still = pushed(40)
    data = JointTransitions(
        **{
            name: np.concatenate([value, np.zeros_like(value)], axis=1)
            if name != "command"
            else value
            for name, value in vars(still).items()
            if name != "period"
        },
        period=H,
    )
    with pytest.raises(SearchError, match="joint number 1 kept its velocity"):
        fit(data, JointedSettings(turning=(0, 1), command_size=(PUSH,)))
