"""When what remains is taken for physics without a name."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

import morph.inference.diagnose  # noqa: F401 -- what is replaced below
from morph.inference.remains import (
    MOST_UNKNOWN,
    NATS,
    SHARE,
    SMALL,
    STEEP,
    UNTOLD,
    Remains,
    by_step,
)
from morph.model.deadline import Deadline


def chance(*, share: float, nats: float) -> float:
    """Return the probability that physics is left."""
    return Remains(share=share, channels={}, nats=nats, in_noise=1.0).any_physics


def test_what_is_left_may_be_a_law_that_was_missed() -> None:
    left = Remains(share=1.0, channels={}, nats=1e6, in_noise=1.0)
    assert left.any_physics == pytest.approx(1.0, abs=1e-4)
    assert left.probability == MOST_UNKNOWN
    little = Remains(share=SHARE, channels={}, nats=NATS, in_noise=1.0)
    assert little.probability == little.any_physics


@pytest.mark.parametrize(
    ("named", "in_noise", "most"),
    [(True, 1.2, SMALL), (True, 2.0, MOST_UNKNOWN), (False, 1.2, MOST_UNKNOWN)],
)
def test_effects_that_predict_to_the_noise_leave_little(
    named: bool, in_noise: float, most: float
) -> None:
    left = Remains(share=1.0, channels={}, nats=1e6, in_noise=in_noise, named=named)
    assert left.probability == most


def test_at_the_thresholds_it_is_as_probable_as_not() -> None:
    assert chance(share=SHARE, nats=NATS) == pytest.approx(0.5)
    # The odds are the ratio to the nearer threshold, to the power `STEEP`.
    odds = 1.5**STEEP
    assert chance(share=1.5 * SHARE, nats=1e6) == pytest.approx(odds / (1.0 + odds))
    assert chance(share=1.0, nats=1.5 * NATS) == pytest.approx(odds / (1.0 + odds))


@pytest.mark.parametrize(
    ("share", "nats", "unknown"),
    [
        (0.5, 1.0, False),  # A force that readings do not ask for.
        (0.003, 1e5, False),  # What steps and sticking cost.
        (0.03, 1e3, True),
        (0.0, 0.0, False),
    ],
)
def test_a_force_must_be_more_than_rounding_and_sure(
    share: float, nats: float, unknown: bool
) -> None:
    assert (chance(share=share, nats=nats) > 0.5) == unknown


@pytest.mark.parametrize(
    ("named", "by_starts", "in_motion", "most"),
    [
        (False, 10.0, 0.1, MOST_UNKNOWN),
        (False, 60.0, 0.1, UNTOLD),
        (False, 10.0, 0.001, UNTOLD),
        (False, 10.0, 5.0, UNTOLD),
        (True, 10.0, 0.1, UNTOLD),
    ],
)
def test_in_contact_errors_count_beside_those_of_the_starts_and_the_motion(
    named: bool, by_starts: float, in_motion: float, most: float
) -> None:
    left = Remains(
        share=30.0, channels={}, nats=1e6, in_noise=100.0, named=named, touching=True,
        by_starts=by_starts, in_motion=in_motion,
    )  # fmt: skip
    assert left.probability == most


@pytest.mark.parametrize(
    ("missing", "doubtful"),
    [
        # Above 0.3 % of the inertial force, and below three times what the step leaves there.
        ([0.0, 0.0050], True),
        ([0.0, 0.0070], False),
        ([0.0, 0.0029], False),
        # The worst joint counts: at the first one the step leaves nothing.
        ([0.0080, 0.0050], False),
    ],
)
def test_what_remains_may_be_of_the_step_where_that_leaves_a_third_of_it(
    monkeypatch: pytest.MonkeyPatch, missing: list[float], doubtful: bool
) -> None:
    monkeypatch.setattr("morph.inference.remains.missing_by_joint", lambda runs: np.array(missing))
    monkeypatch.setattr(
        "morph.inference.remains.velocity_lag", lambda robot, episodes, step: np.array([0.0, step])
    )
    nominal = SimpleNamespace(robot=None, step=0.002)
    assert by_step(nominal, (), ()) == doubtful  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("doubtful", "stopped", "steps", "answer"),
    [
        (False, (False,), [0.004], 0.004),
        (True, (False, False), [0.004, 0.002], 0.002),
        # The budget ended the second search, which may have found less than the first.
        (True, (False, True), [0.004, 0.002], 0.004),
        (True, (True,), [0.004], 0.004),
    ],
)
def test_half_the_step_is_tried_once_where_what_remains_may_be_of_it(
    monkeypatch: pytest.MonkeyPatch,
    doubtful: bool,
    stopped: tuple[bool, ...],
    steps: list[float],
    answer: float,
) -> None:
    tried: list[float] = []

    @dataclass(frozen=True)
    class Ready:
        nominal: SimpleNamespace
        train: tuple[()] = ()
        aside: tuple[()] = ()

    def prepared(*given: object, most: float, **settings: object) -> Ready:
        tried.append(min(0.004, most))
        return Ready(nominal=SimpleNamespace(step=tried[-1]))

    @dataclass(frozen=True)
    class Ranked:
        stopped: bool
        best: SimpleNamespace

    starts = []

    def ranked(
        *given: object, start: object, coarse: Callable[[object], bool], **settings: object
    ) -> Ranked:
        starts.append((start, coarse(())))
        best = SimpleNamespace(refit=SimpleNamespace(runs=()), step=tried[-1])
        return Ranked(stopped=stopped[len(tried) - 1], best=best)

    place = "morph.inference.diagnose"
    module = sys.modules[place]
    for name, fake in (("prepared", prepared), ("ranked", ranked)):
        monkeypatch.setattr(module, name, fake)
    monkeypatch.setattr(module, "in_whole", lambda episodes, whole: episodes)
    monkeypatch.setattr(module, "stretches", lambda episodes, most: episodes)
    monkeypatch.setattr(module, "by_step", lambda nominal, episodes, runs: doubtful)
    ready, result = module._ranked(
        None,
        (),
        held_out=(),
        whole={},
        vary=None,
        known=(),
        deadline=Deadline(time=0.0),
        say=lambda *told: None,
    )  # fmt: skip
    assert tried == steps
    # The second search goes on from the first one's set, and is not asked again.
    (start, asked), *others = starts
    assert (start, asked) == (None, doubtful)
    assert [(each.step, again) for each, again in others] == [(0.004, False)] * (len(steps) - 1)
    assert ready.nominal.step == answer
    assert result.stopped == any(stopped)
