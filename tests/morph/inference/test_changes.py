"""When a robot changed: a wheel whose bearing begins or ceases to drag during its runs."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.inference.diagnose import diagnose
from morph.physics.body.external_push import ExternalPush
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.record.recording import Channel, Recording
from tests.morph.inference.dry_disc import STEP, turned
from tests.morph.inference.dry_wheel import WHEEL

SECONDS, DRAG, NOISE = 4.0, 0.002, 1e-3
"""Of each run; N m s/rad; and rad, above what steps of 0.25 ms are off in a run."""
Drags = Callable[[int, float], bool]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """A disc of 0.02 kg m2 on a motor."""
    path = tmp_path_factory.mktemp("wheel") / "wheel.xml"
    path.write_text(WHEEL)
    return load(path)


def runs(
    drags: Drags,
    *,
    count: int = 4,
    seconds: float = SECONDS,
    drag: float = DRAG,
    pushed: Callable[[int, float, float], float] = lambda run, at, q: 0.0,
) -> list[Recording]:
    """Return runs in which the bearing drags at some times, told the run and the time.

    Args:
        drags: Whether it does in a run at a time.
        count: How many runs.
        seconds: How long each is.
        drag: How much it drags, N m s/rad.
        pushed: Another torque by run, time and angle, N m.
    """
    rng, found = np.random.default_rng(0), []
    time = STEP * np.arange(round(seconds / STEP))
    for number in range(count):
        torque = 0.2 * np.cos((3.0 + number) * time) + 0.1 * np.cos(11.0 * time)
        dragged = drag * np.array([drags(number, at) for at in time.tolist()])

        def driven(at: float, q: float, v: float, u=torque, b=dragged, run=number) -> float:  # type: ignore[no-untyped-def]
            return float(u[int(at)] - b[int(at)] * v) + pushed(run, STEP * at, q)

        read = turned(range(len(time)), driven, coulomb=0.0)
        channels = {
            "axle.position": Channel(time=time, value=read + NOISE * rng.normal(size=len(time))),
            "motor.command": Channel(time=time, value=torque, hold=True),
        }
        found.append(Recording(name=f"run_{number}", channels=channels))
    return found


def test_a_law_that_begins_during_a_run_is_told_with_its_time(wheel: Robot) -> None:
    found = diagnose(wheel, runs(lambda run, at: run > 1 or (run == 1 and at >= 1.5)))
    (change,), (finding,) = found.changes, found.findings
    assert change.after.label == finding.effect.label == "viscous_friction@axle"
    assert (change.episode, change.since) == ("run_1", True)
    # Times are tried every 0.025 s; friction of 0.006 N m moves the disc by more than the noise of
    # 1e-3 rad, 0.5 * 0.006 / 0.02 * t^2, after 0.08 s.
    assert change.time == pytest.approx(1.5, abs=0.25)
    assert finding.onset == change.time == finding.as_json()["onset_s"]
    assert isinstance(finding.effect, ViscousFriction)
    assert finding.effect.b == pytest.approx(DRAG, rel=0.1)
    first, second, *_ = found.summary()
    assert first.startswith("From ")
    assert "of run_1 on, and not before: Joint axle loses 0.00" in first
    assert "since then" in second
    # Only what came after the change was fitted, and it is told where that lies in its recording.
    assert {each.episode for each in found.traces} == {"run_3"}
    assert (found.train, found.held_out) == (("run_1", "run_2"), ("run_3",))


def test_a_law_that_ceases_leaves_nothing_missing(wheel: Robot) -> None:
    found = diagnose(wheel, runs(lambda run, at: run == 0 or (run == 1 and at < 1.5)))
    (change,) = found.changes
    assert found.verdict == "consistent"
    assert found.summary()[0].startswith("Until ")
    assert change.ceases
    assert isinstance(change.before, ViscousFriction)
    assert change.before.b == pytest.approx(DRAG, rel=0.1)
    assert change.as_json()["before"] == {"b": change.before.b}


@pytest.mark.parametrize("always", [True, False])
def test_a_law_that_always_acts_or_never_is_no_change(wheel: Robot, always: bool) -> None:
    found = diagnose(wheel, runs(lambda run, at: always))
    assert not found.changes
    assert [each.onset for each in found.findings] == ([None] if always else [])


def test_a_sensor_that_changes_is_told_to_the_reading(wheel: Robot) -> None:
    # Laws that push are tried every 0.025 s; here readings jump 5 ms from such a time, by 0.06 rad.
    *others, last = runs(lambda run, at: False, seconds=6.0)
    channel, when = last.channels["axle.position"], 1.505
    value = np.where(channel.time >= when, 1.1, 1.0) * channel.value
    channels = last.channels | {"axle.position": replace(channel, value=value)}
    (change,) = diagnose(wheel, [*others, replace(last, channels=channels)]).changes
    assert (change.after.label, change.episode) == ("sensor_scale@axle.position", "run_3")
    # The first reading that jumps is at 1.508 s, and readings carry noise.
    assert change.time == pytest.approx(1.508, abs=1.5 * STEP)


def test_a_change_that_explains_nothing_is_not_told(
    wheel: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("LIKELY", "BELIEVED"):
        monkeypatch.setattr(importlib.import_module("morph.inference.changed"), name, -1.0)
    assert not diagnose(wheel, runs(lambda run, at: run > 1 or (run == 1 and at >= 1.5))).changes


def test_one_recording_that_changes_near_its_end_is_told_by_its_own_time(wheel: Robot) -> None:
    whole = runs(lambda run, at: at >= 19.0, count=1, seconds=24.0)
    found = diagnose(wheel, whole)
    (change,) = found.changes
    # Of 24 seconds the last six were set aside, and five of these are since the change: they
    # confirm it, and what came before is longer.
    assert change.time == pytest.approx(19.0, abs=0.25)
    assert (change.episode, change.since) == ("run_0", False)
    assert found.verdict == "consistent"
    assert found.summary()[1].endswith("of the runs until then.")
    assert not any("left out" in note for note in found.notes)
    assert whole[0].end == pytest.approx(24.0 - STEP)


def test_a_push_in_the_run_that_was_set_aside_is_fitted(tmp_path: Path) -> None:
    path = tmp_path / "wheel.xml"
    # The same inertia about the axle, 0.016 + 0.1 * 0.2^2 kg m2, with the weight on one side.
    path.write_text(
        WHEEL.replace('pos="0 0 0" mass="1"', 'pos="0.2 0 0" mass="0.1"').replace("0.02", "0.016")
    )

    def pushed(run: int, at: float, q: float) -> float:
        return 0.2 * float(np.cos(q)) if run == 3 and 2.0 <= at < 2.2 else 0.0

    found = diagnose(load(path), runs(lambda run, at: False, pushed=pushed))
    assert not found.changes
    (finding,) = found.findings
    assert isinstance(finding.effect, ExternalPush)
    assert (finding.effect.run, found.held_out) == ("run_3", ("run_2",))
    # A newton along y for 0.2 s; the arm at which it pulls is known to 10 %, the torque to 5 %.
    start, end = finding.as_json()["interval_s"]
    assert (start, end) == (pytest.approx(2.0, abs=0.05), pytest.approx(2.2, abs=0.05))
    assert finding.effect.y == pytest.approx(0.2, rel=0.16)


def test_a_law_too_weak_to_be_found_alone_is_told_beside_the_runs_until_then(wheel: Robot) -> None:
    # In 7 s it turns the disc by less than figures of the description may, which 9 s tell apart.
    found = diagnose(
        wheel, runs(lambda run, at: run == 3 or (run == 2 and at >= 1.0), drag=0.15 * DRAG)
    )
    (change,) = found.changes
    assert (change.after.label, change.episode) == ("viscous_friction@axle", "run_2")
    assert change.time == pytest.approx(1.0, abs=0.25)
    assert (change.since, found.findings) == (False, ())
