from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.physics.joint.armature import Armature
from morph.physics.joint.backlash import Backlash
from morph.sim.simulator import Simulator

LINK, ROTOR, GAP, TURN = 0.25, 0.1, 0.04, 0.25
"""kg m2, kg m2, rad, and the time at which the torque of 1 N m turns, s."""


def pushed(time: np.ndarray) -> np.ndarray:
    return np.where(time < TURN - 1e-9, 1.0, -1.0)


@pytest.mark.parametrize(("described", "way"), [(True, 1.0), (False, -1.0)])
def test_a_link_coasts_while_its_rotor_crosses_the_gap(
    wheels: Callable[..., Robot], described: bool, way: float
) -> None:
    step = 0.001
    # The rotor is of the description or of an effect.
    robot = wheels(f'armature="{ROTOR}"' if described else "")
    more = () if described else (Armature(joint="axle", J=ROTOR),)
    run = Simulator(robot, (Backlash(joint="axle", gap=GAP), *more), step=step).run(
        seconds=0.8, command={"axle": lambda t: way * pushed(t)}
    )
    time, v = run.channel("axle.velocity").time, way * run["axle.velocity"]
    together, fast = 1.0 / (LINK + ROTOR), 1.0 / (LINK + ROTOR) * TURN
    # As one up to the turn. Then the rotor falls back by 1 / J t^2 / 2 = gap, while the link
    # coasts, and meets it slower by t / J: momentum gives both J / (I + J) of that.
    crossing = np.sqrt(2.0 * GAP * ROTOR)
    met = fast - crossing * together
    due = np.where(time <= TURN, together * time, fast)
    after = time - TURN - crossing
    due = np.where(after > 0.0, met - together * after, due)
    # The teeth meet at the step that comes next, which loses no momentum: only then is it off.
    blurred = np.abs(after) < 2.0 * step
    assert np.abs(v - due)[~blurred].max() < 1e-12
    # The impact takes off most of what the link had.
    assert fast - met > 0.2


def test_a_servo_holds_its_link_no_better_than_the_gap(wheels: Callable[..., Robot]) -> None:
    servo = '<position name="axle" joint="axle" kp="50" kv="2"/>'
    robot = wheels('armature="0.05"', servo)
    law = Backlash(joint="axle", gap=GAP)
    # The other motor pushes nothing here; a spring of 1 N m/rad draws the link to 1 rad.
    run = Simulator(wheels('armature="0.05" stiffness="1" springref="1"', servo), (law,)).run(
        seconds=3.0
    )
    # Rest: 50 (0 - q_m) = 1 (q - 1) with q_m = q - gap / 2, for the rotor holds the link back.
    due = (1.0 + 50.0 * 0.5 * GAP) / 51.0
    # The slow root of 0.3 x^2 + 2 x + 51 decays with 2 / 0.6 = 3.3 / s: exp(-10) = 5e-5 of 0.04.
    assert run["axle.position"][-1] == pytest.approx(due, abs=2e-6)
    # A link that nothing pushes may rest anywhere in the gap.
    still = Simulator(robot, (law,)).run(seconds=1.0, start={"axle": 0.5 * GAP * 0.99})
    assert np.abs(still["axle.position"] - 0.5 * GAP * 0.99).max() < 0.02 * GAP


def test_a_rotor_without_inertia_crosses_at_once(wheels: Callable[..., Robot]) -> None:
    def run(*effects: Backlash) -> np.ndarray:
        told = {"axle": pushed}
        return Simulator(wheels(), effects).run(seconds=0.5, command=told)["axle.velocity"]

    # A motor's torque reaches the link in the very step; a rotor of 1e-12 kg m2 keeps as little.
    assert np.abs(run(Backlash(joint="axle", gap=GAP)) - run()).max() < 1e-9
