"""What comes off the printer: how each link differs from its description, and recordings of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from experiments.print_loop.bodies import Subject, commands
from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.printed import designed, printed_robot
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.effect import Effect
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.print.weight import Weight
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

KINDS = ("all", "one", "none", "friction")
"""All links printed; one of them; none; none, and dry friction left out in one joint."""
RUNS, SECONDS = 6, 8.0
STEP, EVERY = 0.0005, 20
"""Seconds a step of the true simulation, and steps a reading."""
COUNT = 2.0 * np.pi / 4096.0
"""rad: what an encoder of 12 bits tells apart."""
TENTH_MM = 1e-4
"""m: the same on a slide."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Change:
    """How a link differs from its description."""

    mass: float
    """Factor on its mass."""
    inertia: float
    """Factor on its inertia about its centre of mass."""
    offset: Array
    """Of its centre of mass, m, shape (3,)."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """One case."""

    subject: Subject
    """The body as described."""
    kind: str
    """One of `KINDS`."""
    robot: Robot
    """The body as it came off the printer."""
    changes: Mapping[str, Change]
    """How each link differs that does."""
    effects: tuple[Effect, ...]
    """What else differs: torques by up to 3 %, and the friction of such a case."""
    recordings: tuple[Recording, ...] = field(default=())
    """What it did."""


def truth(body: Subject, kind: str, seed: int, package: Path | None = None) -> Truth:
    """Return a case with its recordings, all drawn from a seed.

    Args:
        body: The body as described.
        kind: One of `KINDS`.
        seed: Of all that is drawn.
        package: What `morph print` wrote; what its links weigh replaces what would be drawn.
    """
    named = sum(map(ord, body.robot.name))
    rng = np.random.default_rng([seed, KINDS.index(kind), named])
    changed: Sequence[str] = ()
    if kind == "all":
        changed = body.links
    elif kind == "one":
        changed = (str(rng.choice(body.links)),)
    changes = {link: _change(rng) for link in changed}
    if package is not None:
        real = packaged(body.robot, package)
        changes = {link: real[link] for link in changes if link in real}
    effects: tuple[Effect, ...] = tuple(
        TorqueScale(actuator=a.name, gain=float(rng.uniform(0.97, 1.03)))
        for a in body.robot.actuators
    )
    if kind == "friction":
        driven = str(rng.choice(list(body.effort)))
        c = 0.08 * body.effort[driven][1] * _stiffness(body.robot, driven)
        effects = (*effects, CoulombFriction(joint=driven, c=c))
    robot = printed(body.robot, changes)
    case = Truth(subject=body, kind=kind, robot=robot, changes=changes, effects=effects)
    return replace(case, recordings=tuple(recorded(case, rng, i) for i in range(RUNS)))


def _change(rng: np.random.Generator) -> Change:
    """Return what infill of 15 % makes of a link that is plastic and bought parts.

    Measured on the parts of an SO-101: sliced plastic weighs about half of the solid, the centre
    moves by up to 6 mm, and the inertia scaled by mass is off by up to 40 %.
    """
    mass, direction = rng.uniform(0.45, 0.75), rng.normal(size=3)
    return Change(
        mass=float(mass),
        inertia=float(mass * rng.uniform(0.6, 1.4)),
        offset=np.asarray(rng.uniform(0.002, 0.006) * direction / np.linalg.norm(direction)),
    )


def packaged(robot: Robot, package: Path) -> dict[str, Change]:
    """Return how each link of a package's robot differs from its description.

    Of the inertia one factor is told: that of the sum of its principal moments.
    """
    was, now = designed(robot), designed(load(str(package / "robot" / "robot.xml")))
    return {
        link: Change(
            mass=now[link].mass / before.mass,
            inertia=float(np.trace(now[link].inertia) / np.trace(before.inertia)),
            offset=now[link].com - before.com,
        )
        for link, before in was.items()
        if link in now and now[link].mass != before.mass
    }


def _stiffness(robot: Robot, actuator: str) -> float:
    """Return N m for each unit of command: of a servo its gain, of a motor one."""
    gain = float(spec_of(robot).actuator(actuator).gainprm[0])
    return 0.1 * gain if gain != 1.0 else 1.0


def printed(robot: Robot, changes: Mapping[str, Change]) -> Robot:
    """Return the robot with its links changed, by the code that puts scales' readings back."""
    before = designed(robot)
    masses = [
        LinkMass(
            link=link,
            designed=before[link],
            predicted=Weight(
                mass=before[link].mass * change.mass,
                com=before[link].com + change.offset,
                inertia=before[link].inertia * change.inertia,
            ),
            measured=None,
            source="gcode",
        )
        for link, change in changes.items()
    ]
    return printed_robot(robot, masses) if masses else robot


def recorded(case: Truth, rng: np.random.Generator, index: int) -> Recording:
    """Return one noisy recording at 100 Hz of a run simulated at 2 kHz."""
    body = case.subject
    start = {name: float(rng.uniform(-half, half)) for name, half in body.start.items()}
    fine = Simulator(case.robot, effects=case.effects, step=STEP).run(
        seconds=SECONDS, start=start, command=commands(body, rng)
    )
    slides = {f"{j.name}.position" for j in case.robot.joints if j.kind == "slide"}
    channels = {}
    for name, channel in fine.channels.items():
        if channel.hold:
            channels[name] = channel
        elif name.endswith(".position"):
            count, value = TENTH_MM if name in slides else COUNT, channel.value[::EVERY]
            read = np.round((value + rng.normal(0.0, 0.3 * count, len(value))) / count) * count
            channels[name] = Channel(time=channel.time[::EVERY], value=read)
    return replace(fine, channels=channels, name=f"run_{index}")
