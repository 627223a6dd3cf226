"""What is learned beside something that was believed before."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import torch

from morph.model.jointed.draws import draw
from morph.model.jointed.fit import JointedSettings, fit
from morph.model.jointed.jointed import Jointed
from morph.model.jointed.transition import JointTransitions
from morph.sim.threads import one_thread

PERIOD = 0.05
SETTINGS = JointedSettings(turning=(0,), command_size=(1.0,), names=("hinge",))


def law(position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor) -> torch.Tensor:
    return 10.0 * command - 8.0 * torch.sin(position) - 0.3 * velocity


def too_weak(position: torch.Tensor, velocity: torch.Tensor, command: torch.Tensor) -> torch.Tensor:
    return law(position, velocity, 0.5 * command)


@pytest.fixture(autouse=True)
def alone_on_its_core() -> Iterator[None]:
    """Keep numerical libraries to one thread: for sixty periods more of them only wait."""
    with one_thread():
        yield


@pytest.fixture(scope="module")
def data() -> JointTransitions:
    """Return periods that began within 0.5 rad of hanging, by the law in fine steps, with noise."""
    rng, steps = np.random.default_rng(0), 100
    q = torch.as_tensor(rng.uniform(-0.5, 0.5, (60, 1)))
    v = torch.as_tensor(rng.uniform(-2.0, 2.0, (60, 1)))
    u = torch.as_tensor(rng.uniform(-1.0, 1.0, (60, 1)))
    place, rate = q, v
    for _ in range(steps):
        rate = rate + PERIOD / steps * law(place, rate, u)
        place = place + PERIOD / steps * rate
    noise = 0.003 * rng.standard_normal((4, 60, 1))
    whole = [each.numpy() + off for each, off in zip((q, v, place, rate), noise, strict=True)]
    return JointTransitions(
        position=whole[0],
        velocity=whole[1],
        command=u.numpy(),
        next_position=whole[2],
        next_velocity=whole[3],
        period=PERIOD,
    )


@pytest.fixture(scope="module")
def corrected(data: JointTransitions) -> Jointed:
    with one_thread():
        return fit(data, SETTINGS, base=too_weak)


def grid() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return states about the top, where nothing was seen."""
    q = torch.linspace(2.5, 3.7, 9, dtype=torch.float64)[:, None]
    return q, torch.zeros_like(q), 0.5 * torch.ones_like(q)


def test_where_nothing_was_seen_a_right_base_is_kept(data: JointTransitions) -> None:
    at = grid()
    right = fit(data, SETTINGS, base=law).mean(*at) - law(*at)
    none = fit(data, SETTINGS).mean(*at) - law(*at)
    # Residuals are noise: 0.003 sqrt(2) / 0.05 = 0.085 in an acceleration.
    assert float(right.abs().max()) < 0.3
    assert float(none.abs().max()) > 1.0


def test_where_data_are_a_wrong_base_is_corrected(corrected: Jointed) -> None:
    q = torch.linspace(-0.4, 0.4, 9, dtype=torch.float64)[:, None]
    at = q, torch.zeros_like(q), 0.5 * torch.ones_like(q)
    # The base misses 10 * 0.5 * 0.5 = 2.5.
    assert float((too_weak(*at) - law(*at)).abs().min()) == pytest.approx(2.5)
    assert float((corrected.mean(*at) - law(*at)).abs().max()) < 0.3


def test_draws_stand_on_the_base_too(corrected: Jointed) -> None:
    at = grid()
    drawn = draw(corrected, 400, np.random.default_rng(0))
    many = drawn.accelerate(*(each[None].expand(400, -1, -1) for each in at))
    spread = float(many.std(dim=0).max())
    # The mean of 400 draws is within 5 / sqrt(400) = 1/4 of their standard deviation.
    assert float((many.mean(dim=0) - corrected.mean(*at)).abs().max()) < 0.25 * spread + 0.02
