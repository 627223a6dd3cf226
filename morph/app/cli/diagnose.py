"""`morph diagnose`: read, diagnose, write, and say it in words."""

from __future__ import annotations

import math
import shlex
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from morph.app.cli.arguments import BUDGET, Diagnose
from morph.app.cli.options import description_options
from morph.app.report import words
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.errors import DiagnosisError, MorphError
from morph.experiment_design.excitation import command_ranges
from morph.model.diagnosis import Diagnosis
from morph.physics import EFFECTS
from morph.record.load import load_recordings
from morph.record.recording import Recording
from morph.sim.simulator import Simulator

MOST_NOTES = 5
"""Notes on recordings that are printed."""


def run_diagnose(options: Diagnose) -> int:
    """Diagnose as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used or the result cannot be written.
    """
    from morph.app.report.files import check_out, diagnosis_text, write_diagnosis
    from morph.run_folder import lock_run_folder

    # Whatever the command line got wrong is told before any work is done.
    check_out(options.out)
    horizon, vary = horizon_of(options.horizon), fractions(options.vary)
    with lock_run_folder(options.out, beside=True):
        result = _diagnosed(options, horizon, vary)
        write_diagnosis(result, options.out)
    if options.json:
        sys.stdout.write(diagnosis_text(result))
    else:
        sys.stdout.write(in_words(result, options.out) + "\n")
    return 3 if result.stopped_short else 0


def _diagnosed(options: Diagnose, horizon: float | None, vary: dict[str, float]) -> Diagnosis:
    from morph.physics.worlds import on_floor

    robot = load_robot(options.robot, base=options.base, folder=options.folder)
    if options.world is not None:
        robot = on_floor(robot, options.world)
    fitted, aside = _recordings(options, robot)
    from morph.inference.diagnose import diagnose

    with _interruptible() as interrupt:
        result = diagnose(
            robot,
            fitted,
            held_out=aside,
            horizon=horizon,
            vary=vary,
            budget=options.budget,
            interrupt=interrupt,
            seed=options.seed,
            progress=None if options.quiet else _Progress(),
        )
    about = {"command": _command(options), **_planned(options, robot, result)}
    return replace(result, provenance={**result.provenance, **about})


def in_words(result: Diagnosis, out: Path) -> str:
    """Return the finding in words, the errors on held-out runs, and the report's path."""
    lines = [f"{result.robot}: {result.verdict}", *(f"  {s}" for s in result.summary())]
    for finding in result.findings:
        fitted = ", ".join(
            f"{name} = {e.value:.3g} [{e.low90:.3g}, {e.high90:.3g}]"
            f"{'' if e.unit == '-' else ' ' + e.unit}{words.limited(e)}"
            for name, e in finding.parameters.items()
        )
        lines.append(f"  {finding.effect.label}: {fitted} (probability {finding.probability:.2f})")
        if finding.rivals:
            first = finding.rivals[0]
            lines.append(
                f"    rival {first.effect}@{first.where} ({first.probability:.2f}); "
                f"to tell them apart: {finding.separate_by}"
            )
        elif finding.effect.twins:
            alike = ", ".join(finding.effect.twins)
            lines.append(f"    no rival fits as well here; laws that often look alike: {alike}")
    if result.findings:
        from morph.inference.findings import SURE

        lines.append(f"  (No probability is above {SURE:g}, by what was right in simulated cases.)")
    lines += [f"  remains: {sentence}" for sentence in words.remains(result)]
    span = "whole episodes" if result.horizon is None else f"{result.horizon:g} s rollouts"
    lines.append(f"  error on held-out runs ({', '.join(result.held_out)}; {span}):")
    units = words.units(result)
    for channel, nominal in result.held_out_rmse["nominal"].items():
        unit = f", {units[channel]}" if channel in units else ""
        refitted = result.held_out_rmse["refitted"][channel]
        corrected = result.held_out_rmse["corrected"][channel]
        lines.append(
            f"    {channel}{unit}: {nominal:.3g} as described, {refitted:.3g} refitted, "
            f"{corrected:.3g} corrected"
        )
    lines += [f"  note: {note}" for note in result.notes[:MOST_NOTES]]
    if len(result.notes) > MOST_NOTES:
        lines.append(f"  note: {len(result.notes) - MOST_NOTES} more in the report")
    if result.stopped_short:
        lines.append(
            "  The search was ended before it had tried all: this is the best answer so far "
            "(--budget SECONDS)."
        )
    lines.append(f"  report: {out / 'report.html'} ({result.seconds:.0f} s)")
    if result.corrected:
        lines.append(f"  corrected model: {out / 'corrected.xml'}")
    if beside := [effect.label for effect in result.corrected_effects]:
        lines.append(
            f"    MuJoCo alone cannot hold {', '.join(beside)}: simulate and compare it with "
            f"--effects {out / 'corrected.toml'}"
        )
    if plan := result.provenance.get("plan"):
        lines.append(f"  to plan how to tell them apart: {plan}")
    return "\n".join(lines)


def _planned(options: Diagnose, robot: Robot, result: Diagnosis) -> dict[str, str]:
    """Return as `plan` the command that plans how to tell a finding from its likeliest rival.

    Where the robot's commands have no range, what to do first; nothing without such a rival.
    """
    passing = {kind.name for kind in EFFECTS if kind.of_a_run}
    for finding in result.findings:
        effect = finding.effect
        rivals = [each for each in finding.rivals if each.effect not in passing]
        if not rivals or effect.of_a_run or finding.probability < LIKELY:
            continue
        size = ",".join(
            f"{known.name}={getattr(effect, known.name):.4g}" for known in effect.free()
        )
        pair = [f"{effect.label}:{size}", f"{rivals[0].effect}@{rivals[0].where}"]
        try:
            command_ranges(Simulator(robot))
        except MorphError as error:
            return {"plan": f"{error.fix} first, as {error.what}"}
        words = ["morph", "excite", options.robot, "--separate", *pair, "--out", "DIR"]
        words += description_options(options.base, options.folder)
        return {"plan": shlex.join(words)}
    return {}


def _recordings(
    options: Diagnose, robot: Robot
) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
    given = [
        recording
        for path in options.recordings
        for recording in load_recordings(path, robot=robot, root=options.root)
    ]
    aside: list[Recording] = []
    for name in options.held_out:
        named = [recording for recording in given if recording.name == name]
        if named:
            aside += named
        elif Path(name).exists():
            aside += load_recordings(Path(name), robot=robot, root=options.root)
        else:
            raise _no_episode("--held-out", name, given)
    for name in options.only:
        if name not in {recording.name for recording in given}:
            raise _no_episode("--only", name, given)
    out = {id(recording) for recording in aside}
    fitted = tuple(
        recording
        for recording in given
        if id(recording) not in out and (not options.only or recording.name in options.only)
    )
    return fitted, tuple(aside)


def _no_episode(option: str, name: str, given: Sequence[Recording]) -> DiagnosisError:
    return DiagnosisError(
        f"{option} {name}: neither an episode nor a file; episodes are "
        f"{', '.join(recording.name for recording in given)}",
        where="morph diagnose",
        fix="name one of these episodes, or a recording's path",
    )


def horizon_of(text: str) -> float | None:
    """Return the seconds of rollouts, None of whole recordings.

    Raises:
        DiagnosisError: It is no such time.
    """
    if text == "full":
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.1):
        raise DiagnosisError(
            f"{text!r} is no horizon",
            where="--horizon",
            fix="give seconds, at least 0.1, or `full`",
        )
    return value


def fractions(pairs: Sequence[str]) -> dict[str, float]:
    """Return by how much figures may be wrong, of texts NAME=FRACTION.

    Raises:
        DiagnosisError: One is no such text.
    """
    results = {}
    for pair in pairs:
        name, equals, value = pair.rpartition("=")
        try:
            results[name] = float(value)
        except ValueError:
            equals = ""
        if not equals or not name:
            raise DiagnosisError(
                f"{pair!r} is no NAME=FRACTION", where="--vary", fix="write for example mass=0.3"
            )
    return results


def _command(options: Diagnose) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    parts = ["morph", "diagnose", options.robot, *map(str, options.recordings), "--out", "DIR"]
    for option, values in (
        ("--held-out", options.held_out),
        ("--only", options.only),
        ("--vary", options.vary),
    ):
        parts += [option, *values] if values else []
    parts += ["--world", options.world] if options.world is not None else []
    parts += description_options(options.base, options.folder)
    parts += ["--horizon", options.horizon] if options.horizon != "1.0" else []
    parts += ["--root", str(options.root)] if options.root is not None else []
    parts += ["--budget", f"{options.budget:g}"] if options.budget != BUDGET else []
    return shlex.join([*parts, "--seed", str(options.seed)])


LIKELY = 0.1
"""Probability of a finding from which an experiment is proposed for it."""


@contextmanager
def _interruptible() -> Iterator[threading.Event]:
    """Lend an event that Ctrl-C sets; a second Ctrl-C ends the program, as ever."""
    interrupt, before = threading.Event(), signal.getsignal(signal.SIGINT)
    # Jobs in the background ignore it, and threads cannot take it.
    if before is signal.SIG_IGN or threading.current_thread() is not threading.main_thread():
        yield interrupt
        return

    def end(_number: int, _frame: object) -> None:
        interrupt.set()
        signal.signal(signal.SIGINT, before)
        sys.stderr.write("\nThe best answer so far will be written; Ctrl-C again ends at once.\n")

    signal.signal(signal.SIGINT, end)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, before)


class _Progress:
    """Says on the error stream what is being done: a line a stage, with the time."""

    def __init__(self) -> None:
        self._began, self._last = time.monotonic(), ""

    def __call__(self, what: str, share: float) -> None:
        if what != self._last:
            seconds = time.monotonic() - self._began
            sys.stderr.write(f"[{seconds:5.1f} s, {100 * share:3.0f} %] {what}\n")
            sys.stderr.flush()
            self._last = what
