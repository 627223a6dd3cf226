"""The search for a map that agrees with transitions: its slopes, its cubic, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError, SettingError
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.consistent import Agreement, Guess, ScaledTransitions, descended
from morph.alignment.maps.feature_warping import (
    InvertibleWarp,
    flat_curves,
    idle_network,
    no_curves,
)
from morph.alignment.maps.maps import mapper
from morph.alignment.maps.multistart import FitBudget
from morph.alignment.maps.surrogate import surrogate
from morph.alignment.samples import Transitions

from .conftest import LEVEL, Planted, draw, swing, wear


def waves(x: Array, u: Array) -> tuple[Array, Array, Array]:
    """Moves of a source with slopes in closed form, n = 3 and k = 1."""
    law = np.array([[0.5, 1.0, 0.0], [-1.0, 0.3, 0.2], [0.1, 0.0, 0.7]])
    at = x @ law.T
    slope = 0.1 * np.cos(at)[:, :, None] * law
    return 0.1 * np.sin(at) + u, slope, np.ones((len(x), 3, 1))


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("network", [False, True])
def test_slopes_of_what_is_off_are_those_of_finite_differences(bent: bool, network: bool) -> None:
    rng = np.random.default_rng(100)

    def some(m: int) -> InvertibleWarp:
        if not bent:
            return no_curves(m)
        return idle_network(m, 4, rng) if network else flat_curves(m, 3, 2.0)

    guess = Guess(
        S=rng.standard_normal((3, 4)), s=rng.standard_normal(3), R=rng.standard_normal((1, 2)),
        r=np.zeros(1), L=0.5 * rng.standard_normal((4, 3)), b=np.zeros(4),
        states=some(4), commands=some(2),
    )  # fmt: skip
    guess = guess.at(guess.vector + 0.03 * rng.standard_normal(guess.vector.size))
    t, a, after = (rng.standard_normal((9, width)) for width in (4, 2, 4))
    seen = ScaledTransitions(before=t, command=a, after=after)
    agree = Agreement(seen=seen, moves=waves, weight=rng.uniform(0.5, 2.0, size=(2, 4)))
    found = agree.slopes(guess, agree.errors(guess)[1])
    rows = 1e-5 * np.eye(guess.vector.size)
    told = [
        agree.errors(guess.at(guess.vector + sign * row))[0] for row in rows for sign in (1, -1)
    ]
    differences = (np.array(told[::2]) - np.array(told[1::2])).T / 2e-5
    # Slopes are up to 30 here; 1e-10 of the third derivatives, and 1e-14 / 1e-5 of rounding.
    np.testing.assert_allclose(found, differences, atol=1e-6)


def test_a_map_that_sends_all_to_rest_agrees_worse_than_the_truth() -> None:
    # In the source's numbers a map to rest would agree perfectly: rest stays rest under f.
    rng = np.random.default_rng(101)
    x, u, after = draw(50, rng)
    seen = ScaledTransitions(before=x, command=u, after=after)

    def moves(state: Array, told: Array) -> tuple[Array, Array, Array]:
        return swing(state, told) - state, np.zeros((50, 2, 2)), np.zeros((50, 2, 1))

    agree = Agreement(seen=seen, moves=moves, weight=seen.plain)
    one, none = np.eye(2), np.zeros(2)
    straight = {"states": no_curves(2), "commands": no_curves(1), "s": none, "b": none}
    truth = Guess(S=one, R=np.eye(1), r=np.zeros(1), L=one, **straight)
    rest = Guess(S=0.0 * one, R=np.zeros((1, 1)), r=np.zeros(1), L=0.0 * one, **straight)
    off = {name: np.square(agree.errors(g)[0]).mean() for name, g in (("t", truth), ("r", rest))}
    assert off["t"] < 1e-30
    assert off["r"] > 1.0


def test_a_descent_never_ends_higher_than_it_began() -> None:
    rng = np.random.default_rng(102)
    x, u, after = draw(40, rng)
    seen = ScaledTransitions(before=wear(x), command=u, after=wear(after))
    source = Transitions(state=x, command=u, after=after, turns=LEVEL)
    cubic = surrogate(source, swing, rng)
    agree = Agreement(seen=seen, moves=cubic.moves, weight=seen.plain)
    S, L = rng.standard_normal((2, 2, 2))
    start = Guess(S=S, s=np.zeros(2), R=np.eye(1), r=np.zeros(1), L=L, b=np.zeros(2),
                  states=no_curves(2), commands=no_curves(1))  # fmt: skip
    losses = [descended(start, agree, rounds=rounds, hold=0.0).loss for rounds in (0, 1, 5, 25)]
    assert losses == sorted(losses, reverse=True)


def test_the_cubic_moves_as_a_cubic_does_and_knows_its_slopes() -> None:
    # x' = x + 0.1 x^3 - 0.2 x u: inside the family, so that only the ridge of 1e-4 errs.
    def step(x: Array, u: Array) -> Array:
        return x + 0.1 * x**3 - 0.2 * x * u

    rng = np.random.default_rng(103)
    x, u = rng.standard_normal((2, 60, 1))
    source = Transitions(state=x, command=u, after=step(x, u), turns=LEVEL[:1])
    cubic = surrogate(source, step, rng)
    t, told = (x - cubic.middle) / cubic.spread, (u - cubic.command_middle) / cubic.command_spread
    move, by_x, by_u = cubic.moves(t, told)
    np.testing.assert_allclose(move * cubic.spread, step(x, u) - x, atol=1e-5)
    np.testing.assert_allclose(by_x[:, :, 0], 0.3 * x**2 - 0.2 * u, atol=1e-4)
    np.testing.assert_allclose(
        by_u[:, :, 0] * cubic.spread / cubic.command_spread, -0.2 * x, atol=1e-4
    )
    assert cubic.missed < 1e-6


def test_a_bent_pendulum_is_found_by_curves_and_not_by_an_affine_map() -> None:
    def bend(x: Array) -> Array:
        z = np.stack([-x[:, 1] / 2.0, x[:, 0]], axis=1)
        return np.asarray(np.array([3.0, 0.7]) * (z + 0.35 * np.sin(1.3 * z + 0.5)))

    rng = np.random.default_rng(104)
    x, u, after = draw(200, rng)
    source = Transitions(state=x, command=u, after=after, turns=LEVEL)
    x, u, after = draw(200, rng)
    target = Transitions(state=bend(x), command=-2.0 * u, after=bend(after), turns=LEVEL)
    given = MapData(source=source, target=target, step=swing)
    unseen, _, _ = draw(500, rng)
    missed = {}
    for name in ("transition", "transition_kernel"):
        said = mapper(name).fit(given, np.random.default_rng(104)).state(bend(unseen))
        said = said * np.sign(said[:, 0] @ unseen[:, 0])
        missed[name] = np.square(said - unseen).mean(axis=0).max()
    variance = unseen.var(axis=0).min()
    assert missed["transition_kernel"] < 0.005 * variance
    assert missed["transition"] > 4.0 * missed["transition_kernel"]


def test_a_source_whose_commands_do_nothing_is_refused(planted: Planted) -> None:
    given = replace(planted.given, step=lambda x, u: swing(x, 0.0 * u))
    with pytest.raises(SamplesError, match=r"command 0 of the source moves nothing"):
        mapper("transition").fit(given, np.random.default_rng(105))


def test_a_simulator_that_loses_its_steps_is_refused(planted: Planted) -> None:
    given = replace(planted.given, step=lambda x, u: np.full_like(x, np.nan))
    with pytest.raises(SamplesError, match=r"the simulator lost 2400 of 2400 steps"):
        mapper("transition").fit(given, np.random.default_rng(106))


def test_an_effort_of_nothing_is_refused() -> None:
    with pytest.raises(SettingError, match=r"count below 1.*\n  fix: "):
        FitBudget(starts=0)
