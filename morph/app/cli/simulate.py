"""`morph simulate`: a robot moves under effects, and is recorded, filmed or shown."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.output_file import check_output_file
from morph.app.cli.simulate_arguments import Simulate
from morph.errors import MorphError, SimulationFailed
from morph.extras import require

if TYPE_CHECKING:
    from morph.app.cli.summary import Done
    from morph.body.robot import Robot
    from morph.physics.worlds import World
    from morph.policy.policy import Policy
    from morph.sim.simulator import Command, Simulator, Trajectory

DONE, STOPPED_SHORT = 0, 3


def run_simulate(options: Simulate) -> int:
    """Simulate as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, the simulation cannot be made, or a result
            cannot be written.
    """
    # Whatever the command line got wrong is told before any work is done.
    out, video = _outputs(options)
    start, speed = _pairs("--start", options.start), _pairs("--speed", options.speed)
    from morph.app.cli.effects import asked_effects
    from morph.body.load import load
    from morph.body.postures import postured
    from morph.physics.worlds import start_in
    from morph.sim.simulator import Simulator

    robot = load(options.robot, base=options.base, folder=options.folder)
    robot = postured(robot, options.posture)
    start = {**start_in(robot, options.world), **start}
    file = None if options.effects is None else Path(options.effects)
    world = _world(options, robot)
    around = () if world is None else world.effects
    effects = asked_effects(robot, options.effect, file=file, world=around)
    constant, policy = _pairs("--command", options.command), _policy(options, robot)
    timed = _timed(options, robot)
    simulator = Simulator(robot, effects, step=options.step, integrator=options.integrator)
    began = time.perf_counter()
    with _progress(options, "simulating") as progress:
        moved, why = _moved(simulator, options.seconds, start, speed, constant, timed, policy)
        took = time.perf_counter() - began
        progress(1.0)
    done = _done(options, simulator, world, moved, why, took)
    # The film first: it takes longest, and an interrupt then leaves nothing at all.
    if video is not None:
        from morph.app.picture.video import film

        with _progress(options, "filming") as progress:
            film(robot, effects, moved.time, moved.position, video, progress=progress)
    if out is not None:
        from morph.record.write import write

        write(done.recording, out)
    _say(options, done)
    if options.view:
        from morph.app.picture.page import view

        view(robot, effects, moved.time, moved.position)
    return DONE if why is None else STOPPED_SHORT


def _say(options: Simulate, done: Done) -> None:
    from morph.app.cli.console import say, width
    from morph.app.cli.summary import as_json, in_words

    if options.json:
        sys.stdout.write(json.dumps(as_json(done), indent=2, allow_nan=False) + "\n")
    else:
        say(in_words(done, width()))
    sys.stdout.flush()


def _done(
    options: Simulate,
    simulator: Simulator,
    world: World | None,
    moved: Trajectory,
    why: MorphError | None,
    took: float,
) -> Done:
    from morph.app.cli.summary import Done
    from morph.record.noise import noisy
    from morph.sim.initial_penetration import buried

    name = Path(options.out).name.partition(".")[0] if options.out else simulator.robot.name
    recording = noisy(simulator.recorded(moved, name or "simulated"), options.noise)
    if not recording.channels:
        raise SimulationFailed(
            "it has neither a joint that turns or slides nor a body that floats",
            where=f"robot {simulator.robot.name}",
            fix="give it a joint, or for a URDF --base floating",
        )
    doubtful = buried(simulator.model, moved.position[0])
    return Done(
        robot=simulator.robot,
        effects=simulator.effects,
        world=world,
        notes=(*(world.notes if world else ()), *filter(None, [doubtful])),
        recording=recording,
        step=simulator.step,
        integrator=simulator.integrator,
        asked=options.seconds,
        seconds=float(moved.time[-1]),
        took=took,
        policy=options.policy,
        files={
            kind: path
            for kind, path in (("recording", options.out), ("video", options.video))
            if path is not None
        },
        why=None if why is None else why.what,
    )


def _world(options: Simulate, robot: Robot) -> World | None:
    """Return the world that is asked for; the first time in water its tensors take seconds."""
    if options.world is None:
        return None
    from morph.physics.worlds import world

    with _progress(options, f"preparing {options.world}"):
        return world(options.world, robot)


def _moved(
    simulator: Simulator,
    seconds: float,
    start: Mapping[str, float],
    speed: Mapping[str, float],
    constant: Mapping[str, float],
    timed: Mapping[str, Command],
    policy: Policy | None,
) -> tuple[Trajectory, SimulationFailed | None]:
    """Return a run; what `--command` and `--commands` tell comes before the policy."""
    if policy is not None and policy.observation:
        from morph.app.cli.policy_rollout import driven

        return driven(
            simulator, policy, seconds=seconds, start=start, speed=speed, command=constant
        )
    from morph.sim.stable import as_far_as_stable

    # What is told nothing is told zero, and a recording of it must say so.
    robot = simulator.robot
    command: dict[str, Command] = dict.fromkeys((each.name for each in robot.actuators), 0.0)
    command |= {**({} if policy is None else policy.commands()), **timed, **constant}
    return as_far_as_stable(simulator, seconds=seconds, start=start, speed=speed, command=command)


def _timed(options: Simulate, robot: Robot) -> dict[str, Command]:
    """Return the commands of a recording, by actuator, on a clock that starts with it."""
    if options.commands is None:
        if options.only is not None:
            raise SimulationFailed(
                "it names an episode of no recording", where="--only", fix="give --commands too"
            )
        return {}
    if options.policy is not None:
        raise SimulationFailed(
            "a policy and the commands of a recording both say what actuators are told",
            where="--commands",
            fix="leave out --policy or --commands",
        )
    from dataclasses import replace

    from morph.record.load import load_recordings

    given = load_recordings(options.commands, robot=robot)
    names = [each.name for each in given]
    named = [each for each in given if options.only in {None, each.name}]
    if len(named) != 1:
        one = f" called {options.only!r}" if options.only else ""
        raise SimulationFailed(
            f"it holds {len(named)} recordings{one}: {', '.join(names)}",
            where=f"--commands {options.commands}",
            fix="name one of these by --only",
        )
    (recording,) = named
    results: dict[str, Command] = {
        name.removesuffix(".command"): replace(each, time=each.time - recording.start)
        for name, each in recording.channels.items()
        if name.endswith(".command")
    }
    if not results:
        raise SimulationFailed(
            "it holds no command",
            where=f"--commands {options.commands}",
            fix="give a recording with a column ACTUATOR.command",
        )
    return results


def _policy(options: Simulate, robot: Robot) -> Policy | None:
    if options.policy is None:
        return None
    from morph.policy.store import load_policy

    return load_policy(Path(options.policy), robot)


def _pairs(option: str, texts: Sequence[str]) -> dict[str, float]:
    """Return the numbers of an option `NAME=VALUE` by their names."""
    results: dict[str, float] = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not name or not math.isfinite(number):
            raise SimulationFailed(
                f"{text!r} is no NAME=VALUE with a finite number",
                where=option,
                fix=f"write for example {option} hinge=0.5",
            )
        if name in results:
            raise SimulationFailed(
                f"{name} is given twice", where=option, fix=f"give {name} one value"
            )
        results[name] = number
    return results


def _outputs(options: Simulate) -> tuple[Path | None, Path | None]:
    """Return where the recording and the film go.

    Raises:
        OutputError: An ending is unknown, or nothing can be written there.
    """
    from morph.app.picture.endings import FILMS
    from morph.record.write import ENDINGS

    checked: list[Path | None] = []
    for option, name, endings in (
        ("--out", options.out, ENDINGS),
        ("--video", options.video, tuple(FILMS)),
    ):
        if name is not None:
            check_output_file(option, name, endings)
        checked.append(None if name is None else Path(name))
    for option, asked in (("--video", options.video), ("--view", options.view)):
        if asked:
            require("view", f"morph simulate {option}")
    return checked[0], checked[1]


@contextmanager
def _progress(options: Simulate, what: str) -> Iterator[Callable[[float], None]]:
    """Lend what is told the share done; a terminal shows it, on the error stream."""
    if options.quiet or not sys.stderr.isatty():
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        # Without a total the bar only says that something is being done.
        task = shown.add_task(what, total=None)
        yield lambda share: shown.update(task, total=1.0, completed=share)
