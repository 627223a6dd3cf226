"""Options of the target of a loop: concealed, sealed or live."""

from __future__ import annotations

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Loop
from morph.app.cli.concealed_target import Concealed, changes, drawn
from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.search.target import Simulated, Target
from morph.task.task import Task

if TYPE_CHECKING:
    from morph.policy_transfer.live.limits import Limits
    from morph.policy_transfer.live.live import Live


@dataclass(frozen=True, kw_only=True)
class TargetOptions:
    """A target, and what is known of it."""

    name: str
    """What it is called."""
    target: Target
    """What trials are made on."""
    concealed: Concealed | None = None
    """In what it differs, if it is simulated."""
    key: str = ""
    """What tells it from every other target."""
    limit: str = ""
    """The limits within which a live one is tried."""

    @property
    def simulated(self) -> Simulated | None:
        """The simulation that stands for it; None if it is live."""
        return self.target if isinstance(self.target, Simulated) else None


def check_choice(options: Loop) -> str:
    """Return which target is asked for: `known`, `sealed`, `live` or `recorded`.

    Raises:
        TransferError: None is, or more than one, or an option of another is given.
    """
    known = bool(options.change or options.effect or options.effects is not None)
    chosen = [
        name
        for name, given in (
            ("told", known),
            ("sealed", options.sealed is not None),
            ("live", options.live is not None),
            ("recorded", bool(options.recorded)),
        )
        if given
    ]
    if len(chosen) != 1:
        raise TransferError(
            "no target is named" if not chosen else f"{len(chosen)} targets are named",
            where="morph loop",
            fix="give one of: --change with --effect or --effects; --sealed; --live; --recorded",
        )
    if options.live is None and (options.limit or options.stop_file is not None):
        raise TransferError(
            "limits and a stop file are of live targets",
            where="--limit" if options.limit else "--stop-file",
            fix="leave it out, or name a live target by --live",
        )
    if options.sealed is not None and options.sealed < 0:
        raise TransferError(f"{options.sealed} is no seed", where="--sealed", fix="give 0 or more")
    return chosen[0]


def told_aim(options: Loop, task: Task) -> TargetOptions:
    """Return the target that differs as the command line says.

    Raises:
        MorphError: A figure, an effect or a value is not known.
    """
    from morph.app.cli.effects import asked_effects

    file = None if options.effects is None else Path(options.effects)
    effects = asked_effects(task.robot, options.effect, file=file)
    concealed = Concealed(factors=changes(options.change), effects=effects)
    lines = [f"{name} x {value:g}" for name, value in concealed.factors.items()]
    lines += [effect.label for effect in effects]
    return TargetOptions(
        name=f"{task.robot.name} with {', '.join(lines)}",
        target=concealed.target(task),
        concealed=concealed,
        key=repr(concealed),
    )


def sealed_aim(options: Loop, task: Task, policy: Policy) -> TargetOptions:
    """Return the target whose differences a seed conceals."""
    concealed = drawn(task, policy, options.sealed or 0)
    return TargetOptions(
        name=f"{task.robot.name}, sealed {options.sealed}",
        target=concealed.target(task),
        concealed=concealed,
    )


def live_aim(options: Loop, task: Task, keep: Path) -> TargetOptions:
    """Return the live target, which is started when the first trial begins.

    Raises:
        TransferError: The command is none, or a limit cannot be used.
    """
    from morph.policy_transfer.live.live import Live
    from morph.policy_transfer.live.process import Process
    from morph.policy_transfer.live.stop import Stop

    try:
        argv = shlex.split(options.live or "")
    except ValueError as error:
        raise TransferError(
            f"the command cannot be taken apart: {error}",
            where="--live",
            fix="close its quotes",
        ) from error
    if not argv:
        raise TransferError(
            "no command is given", where="--live", fix="name the program that speaks for the target"
        )
    stop = Stop(None if options.stop_file is None else Path(options.stop_file))
    process = Process(argv)
    live = Live(task, process, limits=limits(options.limit), stop=stop, keep=keep)
    return TargetOptions(
        name=f"{task.robot.name} by {process.name.removeprefix('target ')}",
        target=live,
        # One interpreter runs many programs, and a program has arguments.
        key=f"live {shlex.join(argv)}",
        limit=" ".join(sorted(options.limit)),
    )


def limits(texts: Sequence[str]) -> Limits:
    """Return limits of `command:NAME=LOW..HIGH`, `rate:NAME=MOST`, `position`, `speed`.

    Raises:
        TransferError: One is none of these.
    """
    from morph.policy_transfer.live.limits import Limits

    spans: dict[str, dict[str, tuple[float, float]]] = {"command": {}, "position": {}}
    most: dict[str, dict[str, float]] = {"rate": {}, "speed": {}}
    for text in texts:
        what, _, rest = text.partition(":")
        name, _, value = rest.rpartition("=")
        numbers = [_number(part) for part in value.split("..")]
        right = len(numbers) == (2 if what in spans else 1) and not any(map(math.isnan, numbers))
        if not name or what not in {*spans, *most} or not right:
            raise TransferError(
                f"{text!r} is no limit",
                where="--limit",
                fix="write command:NAME=-5..5, position:NAME=-1..1, rate:NAME=50 or speed:NAME=2",
            )
        if what in spans:
            spans[what][name] = (numbers[0], numbers[1])
        else:
            most[what][name] = numbers[0]
    return Limits(
        command=spans["command"],
        position=spans["position"],
        rate=most["rate"],
        speed=most["speed"],
    )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def live_of(aim: TargetOptions) -> Live | None:
    """Return the live target of an aim; None if it is simulated."""
    from morph.policy_transfer.live.live import Live

    return aim.target if isinstance(aim.target, Live) else None


def conduct_notes(live: Live | None, trial: int) -> tuple[str, ...]:
    """Return what was noticed of a live target in its last trial, in words."""
    conduct = None if live is None else live.conduct
    if conduct is None:
        return ()
    lines = list(conduct.notes)
    if conduct.clipped:
        lines.append(f"{conduct.clipped} commands were held back by limits")
    if conduct.overruns:
        lines.append(f"in {conduct.overruns} control periods the command before was held: too slow")
    return tuple(f"trial {trial}: {each}" for each in lines)
