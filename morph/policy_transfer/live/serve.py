"""A simulated body as a live target: JSON lines on input and output, to practise and to test on.

Example: python -m morph.policy_transfer.live.serve --robot cartpole --task swing-up --clock target
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from morph.body.load import load
from morph.errors import MorphError
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.effect import Effect
from morph.physics.store import load_effects
from morph.policy_transfer.live.protocol import Clock
from morph.policy_transfer.live.simulated_target import Faults, Served
from morph.task.tasks import task


@dataclass(frozen=True, kw_only=True)
class Serve:
    """Be a live target: a body under effects, one trial after another, until the input ends.

    Example: python -m morph.policy_transfer.live.serve --robot cartpole --clock target --delay 0.1
    """

    robot: str = "cartpole"
    """A name from `morph list robots`, or a description."""
    task: str = "swing-up"
    """The task that gives the start, the length and the control period."""
    effects: Path | None = None
    """A file of what acts on it beyond its description, as for `morph simulate`."""
    clock: Clock = "none"
    """`target`: states come at a fixed rate, by this clock. `none`: one for each command."""
    seed: int = 0
    """Seed of starts and of the noise."""
    unit: tuple[str, ...] = ()
    """Fault: a channel said to be in another unit, `hinge.position=deg`."""
    rename: tuple[str, ...] = ()
    """Fault: a channel or an actuator by another name, `hinge.position=pole`."""
    frozen: tuple[str, ...] = ()
    """Fault: a channel that stays as it is from some time on, `hinge.position=1.0`."""
    lost: tuple[str, ...] = ()
    """Fault: a channel that is no number from some time on, `hinge.position=1.0`."""
    delay: float = 0.0
    """Fault: how late every command is, s."""
    dies: float | None = None
    """Fault: when the process ends, s into a trial."""
    hangs: float | None = None
    """Fault: when it stops answering, s into a trial."""
    skips: float | None = None
    """Fault: when one state is not sent, s into a trial."""
    rubbish: bool = False
    """Fault: lines that are no messages between the states."""
    deaf: bool = False
    """Fault: it does not say that it stopped."""


def served(requested: Serve) -> Served:
    """Return the body that is asked for, ready to be spoken with.

    Raises:
        MorphError: What is asked for is not there, or cannot be used.
    """
    robot = load(requested.robot)
    what = task(requested.task, robot)
    late: tuple[Effect, ...] = ()
    if requested.delay > 0.0:
        late = tuple(ActuatorDelay(actuator=x.name, T=requested.delay) for x in robot.actuators)
    acting = () if requested.effects is None else load_effects(requested.effects)
    faults = Faults(
        unit=dict(_pair(each) for each in requested.unit),
        rename=dict(_pair(each) for each in requested.rename),
        frozen={name: float(at) for name, at in map(_pair, requested.frozen)},
        lost={name: float(at) for name, at in map(_pair, requested.lost)},
        dies=requested.dies,
        hangs=requested.hangs,
        skips=requested.skips,
        rubbish=requested.rubbish,
        deaf=requested.deaf,
    )
    return Served(
        task=what,
        simulator=what.simulator((*acting, *late)),
        clock=requested.clock,
        seed=requested.seed,
        faults=faults,
    )


def _pair(text: str) -> tuple[str, str]:
    name, _, value = text.rpartition("=")
    return name, value


def main(argv: Sequence[str] | None = None) -> int:
    """Serve until the input ends, and return the exit status."""
    import tyro

    requested = tyro.cli(Serve, args=argv, description=Serve.__doc__)
    try:
        served(requested).serve(sys.stdin.buffer.fileno(), sys.stdout.buffer.fileno())
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
