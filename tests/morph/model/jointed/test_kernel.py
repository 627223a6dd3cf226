"""The kernel of a jointed body is the covariance of the law that it stands for."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from morph.model.jointed.kernel import KernelInputs, KernelLayout, gram

LAYOUT = KernelLayout(turning=(1,), sliding=(), joints=2, commands=1)


def seen(position: np.ndarray, velocity: np.ndarray, command: np.ndarray) -> KernelInputs:
    return KernelInputs(
        place=LAYOUT.place(torch.as_tensor(position)),
        velocity=torch.as_tensor(velocity),
        command=torch.as_tensor(command),
    )


def states(rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    return rng.normal(size=(rows, 2)), rng.normal(size=(rows, 2)), rng.normal(size=(rows, 1))


def test_the_covariance_is_the_formula_summed_by_hand() -> None:
    q, v, u = states(4)
    logs = torch.as_tensor(np.random.default_rng(2).normal(-0.5, 0.3, len(LAYOUT.prior[0])))
    # In the layout's order: length, constant, two speeds, two products, command, free, its
    # lengths (angle, two speeds, command), noise.
    length, one, s0, s1, p0, p1, push, free, fa, f0, f1, fu, _ = np.exp(logs.numpy())
    found = gram(LAYOUT, LAYOUT.scales(logs), seen(q, v, u), seen(q, v, u)).numpy()
    for i in range(4):
        for j in range(4):
            chord = 2.0 - 2.0 * math.cos(q[i, 1] - q[j, 1])
            a, b, c, d = v[i, 0], v[i, 1], v[j, 0], v[j, 1]
            law = one**2 + s0**2 * a * c + s1**2 * b * d
            law += (p0**2 * a * c + p1**2 * b * d) ** 2 + push**2 * u[i, 0] * u[j, 0]
            far = chord / fa**2 + ((a - c) / f0) ** 2 + ((b - d) / f1) ** 2
            far += ((u[i, 0] - u[j, 0]) / fu) ** 2
            by_hand = law * math.exp(-0.5 * chord / length**2) + free**2 * math.exp(-0.5 * far)
            assert found[i, j] == pytest.approx(by_hand, rel=1e-9)


def test_full_turns_and_the_place_on_a_free_rail_change_nothing() -> None:
    q, v, u = states(5)
    scales = LAYOUT.scales(LAYOUT.prior[0])
    moved = q + np.array([3.0, 4.0 * math.pi])
    here = gram(LAYOUT, scales, seen(q, v, u), seen(q, v, u))
    there = gram(LAYOUT, scales, seen(moved, v, u), seen(q, v, u))
    assert torch.allclose(here, there, atol=1e-12)


def test_no_setting_strays_far_from_its_prior() -> None:
    middle, spread = LAYOUT.prior
    wild = LAYOUT.scales(middle + 100.0 * spread)
    assert float(wild.noise) == pytest.approx(math.exp(-3.0 + 4.0 * 1.0))
