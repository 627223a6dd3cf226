"""Commands that excite a robot, each of a kind that other laws show under."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.actuators import strength
from morph.body.robot import Actuator, Robot
from morph.errors import DiagnosisError, SimulationFailed
from morph.experiment_design.followed import can_follow, follow, reference_channels, references
from morph.experiment_design.waves import quick_wave, waves
from morph.record.quantities import pose_channels
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

AMPLITUDES = (0.9, 0.6, 0.4, 0.25, 0.15, 0.08, 0.04)
"""Shares of each actuator's limits that are tried, the greatest that is safe and a small one of
which is kept."""
SMALLER = 0.3
"""That small one, over the greatest."""
MARGIN = 0.02
"""Share of a joint's range that a motion keeps from either end; a hinge without one may turn half
a turn either way."""
PRESSED = 0.1
"""Share of that margin by which a joint that begins at an end may be pressed into it."""
INSIDE, MOVING = 0.25, 2.0
"""Least share of its range from either end about which a servo moves, and seconds that it takes to
go there from home."""
FREE_SERVO = 1.0
"""How far a servo without a range is told to move either way, rad or m."""
FREE_SLIDE = 1.0
"""How far a slide without a range may go either way, m."""
FREE_LINK = 3.0
"""How far a link that moves freely may go along each axis, m."""
RESTS = 0.1
"""Acceleration of such a link at home up to which it rests there, m/s2."""
LED = (0.1, 1.5, -1.0)
"""Hz: the band of quick motions that are followed, and the power of the frequency that their sines
grow with."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Excitation:
    """What actuators are told, and what the description does under it."""

    kind: str
    """`quick`, `slow`, `steps`, `coast` or `one: ACTUATOR`; `follow: quick` or `follow: slow` where
    the robot's own controller follows positions."""
    amplitude: float
    """Share of the actuators' limits, or of how far joints can go."""
    recording: Recording
    """The simulated motion, with the commands."""
    references: Mapping[str, Channel] = field(default_factory=dict)
    """Where each joint is to be, by the name of its position's channel."""


def excitations(robot: Robot, seconds: float, step: float, seed: int) -> list[Excitation]:
    """Return motions from rest at home that stay within the limits of a robot.

    Of each kind there are two, at the greatest share of the actuators' limits of `AMPLITUDES` at
    which the described robot keeps from the ends of its joints and under their greatest speeds, and
    at a third of it. Kinds that are not safe at any are left out. Where home is near the end of a
    servo's range, the motion goes on about a place inside. A robot that its motors must hold up is
    not safe under commands alone: where all its joints together have no safe motion, positions are
    planned that its own controller follows.

    Args:
        robot: The description, at whose home position the motions begin.
        seconds: How long each lasts.
        step: Seconds a step of simulation.
        seed: Random seed of phases and levels.

    Raises:
        DiagnosisError: There is no actuator, an actuator has no limit, a link falls freely, or no
            motion is safe.
    """
    simulator = Simulator(robot, step=step)
    low, home, high = command_ranges(simulator)
    servos = np.array([each.kind == "position" for each in robot.actuators])
    inside = np.clip(home, low + INSIDE * (high - low), high - INSIDE * (high - low))
    middle = np.where(servos, inside, home)
    time: Array = np.asarray(step * np.arange(simulator.steps(seconds) + 1), dtype=float)
    gone = np.minimum(time / MOVING, 1.0)[:, None]
    about = home + gone * (middle - home)
    results: list[Excitation] = []
    for kind, wave in waves(robot, time, seed):
        # A one-sided motor idles where a wave is below zero.
        # A command stays within its range on the way there.
        wave = np.where(middle == home, 1.0, gone) * wave
        reach = np.where(wave > 0.0, high - middle, middle - low) * wave
        for amplitude in AMPLITUDES:
            made = _simulated(simulator, time, about + amplitude * reach)
            if made is not None:
                small = SMALLER * amplitude
                less = _simulated(simulator, time, about + small * reach)
                pairs = [(amplitude, made), (small, less)]
                results += [Excitation(kind=kind, amplitude=a, recording=r) for a, r in pairs if r]
                break
    if can_follow(robot) and not any(each.kind == "quick" for each in results):
        results += _followed(simulator, time, low, high, seed)
    if not results:
        raise DiagnosisError(
            f"no motion from home is safe, not even at {100 * AMPLITUDES[-1]:.0f} % of the "
            "actuators' limits: a joint comes to its end",
            where=f"robot {robot.name}",
            fix="describe a home position at which it rests, or wider ranges of its joints",
        )
    return results


def _followed(
    simulator: Simulator, time: Array, low: Array, high: Array, seed: int
) -> Iterator[Excitation]:
    """Yield motions that a controller follows, of each kind at the greatest safe amplitude."""
    rng, count = np.random.default_rng([seed, 1]), len(simulator.robot.actuators)
    quick = np.stack([quick_wave(time, rng, *LED) for _ in range(count)], axis=1)
    slow = dict(waves(simulator.robot, time, seed))["slow"]
    for kind, wave in (("quick", quick), ("slow", slow)):
        for amplitude in AMPLITUDES:
            wanted = references(simulator, time, amplitude * wave)
            made = follow(simulator, time, wanted, low, high)
            if made is not None and _safe(simulator.robot, made):
                told = dict(reference_channels(simulator.robot, time, wanted))
                yield Excitation(
                    kind=f"follow: {kind}", amplitude=amplitude, recording=made, references=told
                )
                break


def command_ranges(simulator: Simulator) -> tuple[Array, Array, Array]:
    """Return each actuator's least command, the one at home and its greatest, (actuators,) each.

    At home a servo holds its joint, and a motor gives no force.

    Raises:
        DiagnosisError: There is no actuator, one has no range, or the robot does not rest at home.
    """
    robot, model = simulator.robot, simulator.model
    if not robot.actuators:
        raise DiagnosisError(
            "it has no actuator",
            where=f"robot {robot.name}",
            fix="give a description with motors or servos",
        )
    results = [_range(robot, actuator, model) for actuator in robot.actuators]
    low, home, high = np.array(results, dtype=float).T
    _check_rests(robot, model, home)
    outside = next((at for at in range(len(home)) if not low[at] <= home[at] <= high[at]), None)
    if outside is not None or not (high > low).any():
        name = robot.actuators[outside or 0].name
        raise DiagnosisError(
            f"actuator {name} cannot be told to stay at home: its commands go from "
            f"{low[outside or 0]:g} to {high[outside or 0]:g}",
            where=f"robot {robot.name}",
            fix="describe a home position within the range of its commands, and a range that is "
            "wider than none",
        )
    return low, home, high


def _check_rests(robot: Robot, model: mujoco.MjModel, home: Array) -> None:
    """Refuse a robot of which a link moves freely and leaves its home without a command."""
    data = mujoco.MjData(model)
    data.ctrl[:] = home
    mujoco.mj_forward(model, data)
    for joint in robot.joints:
        first = int(model.joint(joint.name).dofadr[0])
        if joint.kind == "free" and np.linalg.norm(data.qacc[first : first + 3]) > RESTS:
            raise DiagnosisError(
                f"link {joint.link} falls freely: no command is planned for what has to stand",
                where=f"robot {robot.name}",
                fix="describe the base as fixed, as on a stand, or what holds it up in water by "
                "`gravcomp`",
            )


def _range(robot: Robot, actuator: Actuator, model: mujoco.MjModel) -> tuple[float, float, float]:
    own = model.actuator(actuator.name)
    gain = float(own.gainprm[0])
    if model.actuator_dyntype[own.id] != int(mujoco.mjtDyn.mjDYN_NONE) or gain == 0.0:
        what = "has a state of its own" if gain else "has no gain"
        raise DiagnosisError(
            f"actuator {actuator.name} {what}: its force does not follow from its command",
            where=f"robot {robot.name}",
            fix="describe it as a motor or a servo without activation",
        )
    servo = actuator.kind == "position" and actuator.joint is not None
    home, low, high = 0.0, -math.inf, math.inf
    if servo:
        joint = robot.driven_by(actuator)
        rest = float(model.qpos0[model.joint(joint.name).qposadr[0]])
        # A servo is at rest where its force is none: gain u = -bias q gear.
        unit = -float(own.biasprm[1]) * float(own.gear[0]) / gain
        home = unit * rest
        ends = joint.limits or (rest - FREE_SERVO, rest + FREE_SERVO)
        low, high = sorted(unit * end for end in ends)
    elif actuator.limit is not None:
        force = actuator.limit / (abs(gain) * strength(model, own.id))
        low, high = -force, force
    if model.actuator_ctrllimited[own.id]:
        low, high = own.ctrlrange.tolist()
    if not math.isfinite(high - low):
        raise DiagnosisError(
            f"actuator {actuator.name} has no limit within which it may be commanded",
            where=f"robot {robot.name}",
            fix="give it a ctrlrange or a forcerange in the description, or a `limit` in the card",
        )
    return low, home, high


def _simulated(simulator: Simulator, time: Array, given: Array) -> Recording | None:
    """Return a run of the description, None of one that is not safe."""
    command = {
        each.name: Channel(time=time, value=given[:, at], hold=True)
        for at, each in enumerate(simulator.robot.actuators)
    }
    try:
        made = simulator.run(seconds=float(time[-1]), command=command, name="planned")
    except SimulationFailed:
        return None
    return made if _safe(simulator.robot, made) else None


def _safe(robot: Robot, made: Recording) -> bool:
    """Return whether joints keep from their ends, and under their greatest speeds."""
    for joint in robot.joints:
        if joint.kind == "free":
            place = np.stack([made[name] for name in pose_channels(joint)], axis=1)
            # Half a turn has a real part of zero.
            if (
                np.abs(place[:, :3] - place[0, :3]).max() > FREE_LINK
                or (place[:, 3:] @ place[0, 3:]).min() < 0.0
            ):
                return False
        if joint.kind not in {"hinge", "slide"}:
            continue
        place, speed = made[f"{joint.name}.position"], made[f"{joint.name}.velocity"]
        low, high = joint.limits or (-math.inf, math.inf)
        if joint.limits is None:
            far = math.pi if joint.kind == "hinge" else FREE_SLIDE
            low, high = place[0] - far, place[0] + far
        room = MARGIN * (high - low) if math.isfinite(high - low) else 0.0
        # A motion may begin at an end, into which its weight presses it a little.
        least, most = place[0] - PRESSED * room, place[0] + PRESSED * room
        if place.min() < min(low + room, least) or place.max() > max(high - room, most):
            return False
        if joint.velocity is not None and np.abs(speed).max() > joint.velocity:
            return False
    return True
