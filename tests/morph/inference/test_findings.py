"""Parameters of findings: in their units, of whole runs, and where they may be nothing."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.inference.findings import _may_be_idle
from morph.inference.intervals import Uncertainty, in_units, shifted
from morph.inference.quadratic import LogPosterior
from morph.inference.verdict import doubts
from morph.model.finding import Estimate, Finding
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import Knob
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.torque_saturation import TorqueSaturation
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.payload import Payload
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.sensor.timestamp_offset import TimestampOffset


def test_the_interval_of_a_limit_is_that_of_one_over_it() -> None:
    known = next(each for each in TorqueSaturation.free() if each.name == "limit")
    entry = Estimate(value=0.2, low90=0.16, high90=0.25, unit="-", bounded=False, prior_only=False)
    stated = in_units(entry, known, False)
    assert (stated.low90, stated.value, stated.high90) == pytest.approx((4.0, 5.0, 6.25))
    # An entry of nothing is no limit.
    none = in_units(replace(entry, low90=0.0), known, False)
    assert none.high90 == known.high


def late(value: float, half: float, effect: Effect) -> Finding:
    time = Estimate(value=value, low90=value - half, high90=value + half, unit="s")
    return Finding(
        effect=effect, probability=0.7, episodes=(), parameters={"T": time}, rivals=(),
        separate_by="", gain=0.5,
    )  # fmt: skip


@pytest.mark.parametrize(("times", "said"), [
    ((0.005, 0.0051), True), ((0.005, 0.009), False), ((0.005,), False),
])  # fmt: skip
def test_delays_of_all_actuators_may_be_one_clock_against_another(
    cartpole: Robot, times: tuple[float, ...], said: bool
) -> None:
    two = SimpleNamespace(actuators=("slide", "hinge"), joints=("slide", "hinge"))
    for law, first in ((ActuatorDelay, "All commands"), (TimestampOffset, "All readings")):
        places = (
            ("slide", "hinge") if law is ActuatorDelay else ("slide.position", "hinge.position")
        )
        found = [late(T, 2e-4, law.at(where)) for T, where in zip(times, places, strict=False)]
        lines = doubts(found, {}, two)  # type: ignore[arg-type]
        assert bool(lines) == said
        assert all(line.startswith(f"{first} are late by the same 5.05 ms") for line in lines)
        ahead = [late(-T, 2e-4, each.effect) for T, each in zip(times, found, strict=True)]
        lines = doubts(ahead, {}, two)  # type: ignore[arg-type]
        assert all(line.startswith(f"{first} are early by the same 5.05 ms") for line in lines)


def test_own_parameters_at_the_end_of_what_they_may_be_are_named(cartpole: Robot) -> None:
    ends = {
        name: Estimate(value=1.1, low90=1.0, high90=1.1, unit="-", bounded=True, prior_only=prior)
        for name, prior in (("com:pole", False), ("mass:cart", True))
    }
    found = [late(0.1, 0.01, ActuatorDelay(actuator="slide"))]
    (line,) = doubts(found, ends, cartpole)
    assert line.startswith("Refitted as far as --vary allows: com:pole. ")
    assert line.endswith(" --vary com:pole=0.3")
    assert doubts([], ends, cartpole) == ()


def test_intervals_of_an_event_shift_with_its_times() -> None:
    push = ExternalPush(body="disc", run="a from 30 s", start=1.0, end=1.2)
    entry = Estimate(value=1.0, low90=0.9, high90=1.1, unit="s")
    told = shifted(entry, push.within("a", 30.0), push, "start")
    assert (told.low90, told.value, told.high90) == pytest.approx((30.9, 31.0, 31.1))
    assert shifted(entry, push, push, "start") is entry


def uncertainty(robot: Robot, law: Effect, precision: Array, folds: int = 4) -> Uncertainty:
    """A quadratic about a law's parameters, of which each fold says the same."""
    hypothesis = Hypothesis(robot=robot, step=0.004, knobs=(), effects=(law,))
    gram = np.zeros((1 + len(precision), 1 + len(precision)))
    gram[1:, 1:] = precision / folds
    return Uncertainty.of(
        LogPosterior(
            hypothesis=hypothesis,
            point=hypothesis.start,
            grams=np.stack([gram] * folds),
            readings=400,
        )
    )


@pytest.mark.parametrize(("deviation", "idle"), [(0.02, False), (0.03, True)])
def test_a_push_of_which_one_component_shows_is_there_however_wide_the_others_are(
    pendulum: Robot, deviation: float, idle: bool
) -> None:
    push = ExternalPush(body=pendulum.links[-1].name, run="r1", y=0.1)
    entries = [each.name for each in push.free()]
    # x and y show as one force alone: 0.1 N with the deviation, at a temperature of 2.
    both = np.array([float(name in ("x", "y")) for name in entries])
    precision = np.outer(both, both) / deviation**2
    for name in ("start", "end"):
        precision[entries.index(name), entries.index(name)] = 1e8
    doubt = uncertainty(pendulum, push, precision)
    found, _ = doubt.estimates()
    # Their difference may be anything within the bounds, as may z.
    for known, entry in zip(push.free(), found, strict=True):
        if known.name in ("x", "y", "z"):
            assert entry.low90 < 0.5 * known.low
            assert entry.high90 > 0.5 * known.high
    # (0.1 / deviation)^2 / 2 beside 6.25, the 90 % point of chi square with 3 degrees of freedom.
    assert _may_be_idle(push, [*range(len(entries))], doubt) == idle


@pytest.mark.parametrize(("limit", "idle"), [(1.0, False), (1e9, True)])
def test_a_limit_without_end_may_be_none(pendulum: Robot, limit: float, idle: bool) -> None:
    law = TorqueSaturation(actuator="motor", limit=limit)
    assert _may_be_idle(law, [0], uncertainty(pendulum, law, np.array([[1e3]]))) == idle


def test_where_a_weight_is_says_nothing_of_whether_there_is_one(pendulum: Robot) -> None:
    weight = Payload(body=pendulum.links[-1].name, m=0.1, x=0.2)
    entries = [each.name for each in weight.free()]
    surely = np.diag([1e8 if name != "m" else 100.0 for name in entries])
    # A mass of 0.1 kg, off by 0.1: one deviation of 1.645, at a temperature of 2 less.
    assert _may_be_idle(weight, [*range(len(entries))], uncertainty(pendulum, weight, surely))
    assert not _may_be_idle(
        weight, [*range(len(entries))], uncertainty(pendulum, weight, 1e4 * surely)
    )


@pytest.mark.parametrize("run", ["r1", ""])
def test_the_interval_of_what_acts_once_is_that_of_its_run(pendulum: Robot, run: str) -> None:
    push = ExternalPush(body=pendulum.links[-1].name, run=run, y=1.0)
    hypothesis = Hypothesis(robot=pendulum, step=0.004, knobs=(), effects=(push,))
    entries = len(push.free())
    # One run tells of it; by what little is left of the others it is 30 away from there.
    grams = np.zeros((4, 1 + entries, 1 + entries))
    grams[0, 1:, 1:] = 1e4 * np.eye(entries)
    grams[1:, 1:, 1:] = 1e-4 * np.eye(entries)
    grams[1:, 0, 1:] = grams[1:, 1:, 0] = 30e-4
    about = LogPosterior(hypothesis=hypothesis, point=hypothesis.start, grams=grams, readings=1000)
    (*_, last), _ = Uncertainty.of(about).estimates()
    # A standard deviation of 0.01 at a temperature of 2, or of tens.
    width = 1.645 * np.sqrt(2.0) * 0.01
    if run:
        assert last.high90 - last.low90 == pytest.approx(2.0 * width, rel=1e-3)
    else:
        assert last.high90 - last.low90 > 10.0


def test_what_no_reading_tells_may_be_anything_within_its_bounds(pendulum: Robot) -> None:
    law = StribeckFriction(joint="hinge", c=0.1, s=0.2, vs=0.2)
    hypothesis = Hypothesis(robot=pendulum, step=0.004, knobs=(), effects=(law,))
    gram = np.diag([1.0, 1e6, 1e6, 0.0])
    about = LogPosterior(
        hypothesis=hypothesis, point=hypothesis.start, grams=np.stack([gram] * 4), readings=400
    )
    found, sure = Uncertainty.of(about).estimates()
    assert [known.name for known in law.free()] == ["c", "s", "vs"]
    assert sure.tolist() == [True, True, False]
    assert found[0].high90 - found[0].low90 < 0.01
    assert found[2].prior_only
    # A uniform distribution over the bounds has a twelfth of their distance squared as variance.
    low, high = hypothesis.low[2], hypothesis.high[2]
    assert found[2].high90 - found[2].low90 > 0.5 * (high - low)


def test_a_figure_at_its_bound_is_still_as_uncertain_as_beforehand(pendulum: Robot) -> None:
    # Gain and friction on one scale: readings tell their difference alone, to 1e-3.
    gain = Knob(kind="gain", part="hinge", what="gain", fraction=0.05)
    law = CoulombFriction(joint="hinge", c=1.0)
    hypothesis = Hypothesis(robot=pendulum, step=0.004, knobs=(gain,), effects=(law,))
    inner = 1e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    gram = np.zeros((3, 3))
    gram[1:, 1:] = inner
    grams, at = np.stack([gram / 4.0] * 4), np.array([hypothesis.high[0], 1.0])
    about = LogPosterior(hypothesis=hypothesis, point=at, grams=grams, readings=400)
    found, _ = Uncertainty.of(about).estimates()
    # The friction is as uncertain as the gain, 5 %, at a temperature of 2: sqrt(2) 1.645 5 %.
    assert found[1].high90 - found[1].value == pytest.approx(np.sqrt(2.0) * 1.645 * 0.05, rel=0.02)
