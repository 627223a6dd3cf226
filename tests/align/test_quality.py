"""How good a map between two bodies is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import BodyMap, MapData, Mapper
from morph.alignment.quality import quality, resampled
from morph.alignment.samples import Transitions

LEVEL = np.array([False, False])
A = np.array([[1.0, 0.1], [-0.2, 0.9]])
B = np.array([[0.0], [0.5]])


def step(x: Array, u: Array) -> Array:
    return np.asarray(x @ A.T + u @ B.T)


def run(rows: int, seed: int) -> Transitions:
    """Transitions of one run, each of which begins where the last one ended."""
    rng = np.random.default_rng(seed)
    x, u = [rng.standard_normal(2)], rng.standard_normal((rows, 1))
    for told in u:
        x.append(step(x[-1][None], told[None])[0])
    return Transitions(state=np.array(x[:-1]), command=u, after=np.array(x[1:]), turns=LEVEL)


def times(factor: float) -> AffineMap:
    """A target whose states are the source's over `factor`, and whose commands are the same."""
    law, none = factor * np.eye(2), np.zeros(2)
    return AffineMap(
        state_law=law, state_shift=none, lift_law=np.eye(2) / factor, lift_shift=none,
        action_law=np.eye(1), action_state=np.zeros((1, 2)), action_shift=np.zeros(1),
        read_law=np.eye(1), read_state=np.zeros((1, 2)), read_shift=np.zeros(1),
    )  # fmt: skip


def test_the_true_map_has_no_fault() -> None:
    seen = run(40, 101)
    target = replace(seen, state=seen.state / 3.0, after=seen.after / 3.0)
    found = quality(times(3.0), run(40, 100), target, step, steps=5)
    # Rounding of the scaled target breaks no row: x / 3 is divided alike on both sides of a step.
    assert found.steps == 5
    assert max(v for k, v in found.numbers().items() if k != "steps") < 1e-14


def test_commands_read_with_the_wrong_sign_miss_four_times_their_share() -> None:
    # Off by 2 B u where the change is (A - 1) x + B u: the second number alone is off.
    seen = run(400, 101)
    wrong = replace(times(1.0), read_law=-np.eye(1), action_law=-np.eye(1))
    found = quality(wrong, run(40, 100), seen, step, steps=1)
    moved = seen.after - seen.state
    share = np.square(2.0 * seen.command @ B.T).mean(axis=0) / np.square(moved).mean(axis=0)
    assert found.one_step == pytest.approx(share.mean(), rel=1e-9)
    assert found.command_round_trip == 0.0


def test_a_way_back_that_is_none_is_told() -> None:
    # state(state_back(x)) is 1.1 x: a tenth of x, whose root mean square is near its spread.
    seen = run(300, 100)
    half = replace(times(1.0), lift_law=1.1 * np.eye(2))
    size = np.sqrt(np.square(seen.state / seen.state.std(axis=0)).mean())
    assert quality(half, seen, seen, step).round_trip == pytest.approx(0.1 * size)


def test_transitions_that_do_not_follow_each_other_count_one_by_one() -> None:
    seen = run(40, 101)
    apart = Transitions(
        state=seen.state[::2], command=seen.command[::2], after=seen.after[::2], turns=LEVEL
    )
    found = quality(times(1.0), seen, apart, step)
    assert (found.steps, found.many_steps) == (1, found.one_step)


def test_a_simulator_that_fails_foresees_nothing() -> None:
    seen = run(40, 101)
    found = quality(times(1.0), seen, seen, lambda x, u: np.full_like(x, np.nan))
    assert found.one_step == pytest.approx(1.0)


def test_a_source_that_never_moved_is_refused() -> None:
    still = Transitions(state=np.ones((5, 2)), command=np.ones((5, 1)), after=np.ones((5, 2)),
                        turns=LEVEL)  # fmt: skip
    with pytest.raises(SamplesError, match=r"ever changed"):
        quality(times(1.0), still, still, step)


@dataclass(frozen=True, kw_only=True)
class Scaling(Mapper):
    """Learns by how much the source's states are larger, from spreads alone."""

    name: ClassVar[str] = "scaling"

    def estimate(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return it."""
        return times(float(given.source.state.std() / given.target.state.std()))


def test_the_bootstrap_is_as_wide_as_the_spread_of_a_known_statistic() -> None:
    # A deviation of n normal numbers has itself a relative deviation of 1 / sqrt(2 n): of 2 x 100,
    # 0.05, and so has the factor 1 / deviation. Forty draws know that to 1 / sqrt(80) = 11 %, and
    # the sample's own kurtosis, 3 +- sqrt(24 / 200), to another 12 %: three times both is half.
    rng = np.random.default_rng(102)
    x = rng.standard_normal((100, 2))
    seen = Transitions(state=x, command=x[:, :1], after=x, turns=LEVEL)
    given = MapData(source=seen, target=seen)
    found = resampled(Scaling(), given, np.random.default_rng(103), rounds=40)
    assert found == pytest.approx(0.05, rel=0.5)
