"""`morph transfer`: a policy carried along a chain of bodies, over a map learned at each hop."""

from __future__ import annotations

import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from morph.alignment.errors import AlignError
from morph.app.cli.align_arguments import Transfer
from morph.errors import MorphError, OutputError, TransferError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from morph.app.cli.stages import Stages
    from morph.app.cli.transfer_bodies import SourcePolicy
    from morph.policy_transfer.body import Body
    from morph.policy_transfer.hop_checkpoint import HopsKept, Kept
    from morph.policy_transfer.relay_record import RelayRecord

DONE, STOPPED_SHORT, INTERRUPTED = 0, 3, 130


def run_transfer(options: Transfer) -> int:
    """Carry a policy along a chain as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, or a result cannot be written.
        AlignError: No map of the first hop can be learned.
    """
    from morph.app.cli.transfer_text import say_outcome
    from morph.app.report.transfer.words import done
    from morph.run_folder import lock_run_folder

    began = time.monotonic()
    options, bodies, start, out = _prepared(options)
    hops: list[Kept] = []
    with lock_run_folder(out):
        kept = _kept(options, bodies, start, out)
        try:
            record, stopped = _relayed(options, bodies, start, kept, hops, began)
        except KeyboardInterrupt:
            return _interrupted(out, len(hops))
    say_outcome(options, record)
    return DONE if done(record) and not stopped else STOPPED_SHORT


def transferred(options: Transfer) -> RelayRecord:
    """Carry a policy along a chain and return the record, which is written to `options.out` too.

    Raises:
        MorphError: An input cannot be used, or a result cannot be written.
        AlignError: No map of the first hop can be learned.
    """
    from morph.run_folder import lock_run_folder

    began = time.monotonic()
    options, bodies, start, out = _prepared(options)
    with lock_run_folder(out):
        kept = _kept(options, bodies, start, out)
        return _relayed(options, bodies, start, kept, [], began)[0]


def _prepared(options: Transfer) -> tuple[Transfer, list[Body], SourcePolicy, Path]:
    """Return the options with the way chosen, the bodies on it, the first's policy, the folder."""
    from morph.app.cli.outputs import TRANSFER, check_out
    from morph.app.cli.transfer_bodies import body_of, check_task, given
    from morph.app.cli.transfer_inputs import check_numbers, check_over, chosen_way
    from morph.policy_transfer.balancers import seen_with

    # Whatever the command line got wrong is told before any work is done.
    check_over(options)
    check_numbers(options)
    check_task(options.task)
    out = check_out(options.out, TRANSFER)
    _check_fresh(options, out)
    if options.over:
        options, bodies = chosen_way(options)
    else:
        bodies = [body_of(name, options.task) for name in options.chain]
    bodies = [seen_with(each, options.noise) for each in bodies]
    check_periods(bodies)
    return options, bodies, given(options.policy, bodies[0]), out


def _check_fresh(options: Transfer, out: Path) -> None:
    """Refuse to begin anew where that would remove the policy that is given."""
    inside = Path(options.policy).resolve().is_relative_to(out.resolve())
    if options.fresh and inside and options.policy != "learned":
        raise OutputError(
            "--fresh would remove what --from names, as it lies in this folder",
            where=str(out),
            fix="name another folder by --out, or copy it elsewhere first",
        )


def check_periods(bodies: Sequence[Body]) -> None:
    """Refuse a chain whose bodies are not commanded equally often.

    Raises:
        TransferError: Two that follow each other are not.
    """
    for here, there in pairwise(bodies):
        if abs(here.task.period - there.task.period) > 1e-9:
            raise TransferError(
                f"{here.task.robot.name} is commanded every {here.task.period:g} s and "
                f"{there.task.robot.name} every {there.task.period:g} s",
                where="--chain",
                fix="give bodies of one control period: a map of transitions knows but one",
            )


def _kept(options: Transfer, bodies: list[Body], start: SourcePolicy, out: Path) -> HopsKept:
    """Return the checkpoint in a folder that nobody else works in."""
    from morph.app.cli.outputs import TRANSFER, claim, clear
    from morph.policy_transfer.hop_checkpoint import HopsKept

    if options.fresh:
        clear(out, TRANSFER, progress=True)
    claim(out, TRANSFER, results=False)
    return HopsKept(out, key_of(options, bodies, start))


def _relayed(
    options: Transfer,
    bodies: list[Body],
    start: SourcePolicy,
    kept: HopsKept,
    hops: list[Kept],
    began: float,
) -> tuple[RelayRecord, str]:
    """Return what came of it, written, and why it stopped short.

    Nothing is left of what ends without a hop.
    """
    from morph.app.cli.heartbeat import beating
    from morph.app.cli.outputs import TRANSFER, claim, clear

    try:
        with beating(options.quiet) as progress:
            stopped = _hops(options, bodies, start, kept, hops, progress)
            progress.now("writing the report")
            claim(kept.out, TRANSFER, results=True)
            return _written(options, bodies, start, hops, stopped, kept.out, began), stopped
    except BaseException:
        if not hops:
            clear(kept.out, TRANSFER, progress=True)
        raise


def _hops(
    options: Transfer,
    bodies: list[Body],
    start: SourcePolicy,
    kept: HopsKept,
    hops: list[Kept],
    progress: Stages,
) -> str:
    """Make or read every hop; return why it stopped short, or nothing.

    Raises:
        MorphError: The first hop cannot be made.
        AlignError: No map of it can be learned.
    """
    from morph.app.report.transfer.words import hop_said
    from morph.policy_transfer.evaluate_hop import Asked, crossed
    from morph.policy_transfer.relay import as_believed

    gain, shift, source = start.gain, start.shift, bodies[0]
    counts = options.samples if len(options.samples) > 1 else options.samples * (len(bodies) - 1)
    for at, count in enumerate(counts):
        number = at + 1
        done = kept.read(number)
        if done is None or not _fits(done, bodies[number]):
            how = Asked(
                samples=count,
                trials=options.trials,
                repeats=options.repeats,
                scratch=options.scratch,
                seed=options.seed,
            )
            label = f"hop {number} of {len(counts)}, to {options.chain[number]}: "

            def said(words: str, label: str = label) -> None:
                progress.now(label + words)

            try:
                done = crossed(number, source, gain, shift, bodies[number], how, said)
            except (MorphError, AlignError) as error:
                if not hops:
                    raise
                return f"hop {number} could not be made: {error.where}: {error.what}; {error.fix}"
            kept.write(number, done)
        hops.append(done)
        gain, shift = done.gain, done.shift
        # Only the first body's simulator is ours: the others are what their transitions told.
        source = as_believed(bodies[number], done.step)
        progress.line(hop_said(number, done.crossing))
    return ""


def _fits(done: Kept, body: Body) -> bool:
    """Return whether a hop that was read is of this body."""
    shape = (len(body.bounds[0]), body.size)
    return done.gain.shape == shape and done.crossing.target == body.task.robot.name


def _written(
    options: Transfer,
    bodies: list[Body],
    start: SourcePolicy,
    hops: list[Kept],
    stopped: str,
    out: Path,
    began: float,
) -> RelayRecord:
    from morph.app.cli.transfer_bodies import hash_of, notes_of
    from morph.app.cli.transfer_text import command
    from morph.app.report.transfer.files import write_transfer
    from morph.policy_transfer.relay_record import RelayRecord, hashes

    inputs = [(each.task.robot.name, hash_of(each.task.robot)) for each in bodies]
    notes = (*notes_of(options.chain), *((stopped,) if stopped else ()))
    record = RelayRecord(
        task=bodies[0].task,
        hops=tuple(each.crossing for each in hops),
        policy=True,
        seed=options.seed,
        seconds=time.monotonic() - began,
        command=command(options),
        inputs=hashes([("policy", start.sha256), *inputs]),
        notes=notes,
    )
    return write_transfer(record, bodies[len(hops)], hops[-1], options.trials, out)


def key_of(options: Transfer, bodies: Sequence[Body], start: SourcePolicy) -> dict[str, str]:
    """Return what must be the same for a transfer to go on."""
    from morph.app.cli.transfer_bodies import hash_of

    return {
        "chain": " ".join(hash_of(each.task.robot) for each in bodies),
        "task": options.task,
        "policy": start.sha256,
        "noise": repr(options.noise),
        "samples": " ".join(map(str, options.samples)),
        "trials": str(options.trials),
        "repeats": str(options.repeats),
        "scratch": str(options.scratch),
        "seed": str(options.seed),
    }


def _interrupted(out: Path, hops: int) -> int:
    from morph.app.cli.console import harmless

    sys.stderr.write(
        f"interrupted after {hops} hop{'' if hops == 1 else 's'}; the same command goes on from "
        f"there, by what is in {harmless(str(out))}\n"
        if hops
        else "interrupted; nothing was written\n"
    )
    return INTERRUPTED
