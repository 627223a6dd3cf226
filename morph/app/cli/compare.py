"""`morph compare`: where, when and how much a description and recordings part, in words."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.arguments import Compare
from morph.app.cli.diagnose import horizon_of
from morph.app.cli.options import description_options

if TYPE_CHECKING:
    from morph.app.viewer.state import Saved
    from morph.body.robot import Robot
    from morph.model.comparison import ChannelError, RolloutComparison
    from morph.record.recording import Recording


def run_compare(options: Compare) -> int:
    """Compare as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used or a file cannot be written.
    """
    from morph.app.cli.effects import asked_effects
    from morph.app.cli.stages import stages
    from morph.app.cli.view_inputs import check_page
    from morph.body.load import load as load_robot
    from morph.files import write_whole
    from morph.model.comparison import compare
    from morph.model.derived_channels import by_effort, told_zero
    from morph.physics.worlds import world
    from morph.record.distinct import distinct
    from morph.record.load import load_recordings

    # Whatever the command line got wrong is told before any work is done.
    horizon = horizon_of(options.horizon)
    for option, path in (("--html", options.html), ("--state", options.state)):
        if path is not None:
            check_page(path, option)
    with stages(options.quiet) as progress:
        progress.now("loading")
        robot = load_robot(options.robot, base=options.base, folder=options.folder)
        recordings = [
            each
            for path in options.recordings
            for each in load_recordings(path, robot=robot, root=options.root)
        ]
        recordings = list(distinct(recordings))
        around = () if options.world is None else world(options.world, robot).effects
        file = None if options.effects is None else Path(options.effects)
        around = asked_effects(robot, (), file=file, world=around)
        progress.now("simulating")
        result = compare(robot, recordings, effects=around, horizon=horizon)
        if options.state is not None or options.html is not None:
            saved = _saved(options, robot, recordings, result)
        if options.state is not None:
            write_whole(options.state, saved.text().encode())
        if options.html is not None:
            _write_page(options, saved, progress.now)
    if options.json:
        sys.stdout.write(json.dumps(result.as_json(), indent=2) + "\n")
    else:
        driven = [by_effort(each, robot) for each in recordings]
        whole = all(told_zero(each, robot) is each for each in driven)
        sys.stdout.write(
            in_words(result, options.effects) + "\n" + _further(options, whole=whole) + "\n"
        )
    return 0


def in_words(result: RolloutComparison, effects: str | None = None) -> str:
    """Return what was found, a line for each channel, the farthest off first.

    Args:
        result: What was found.
        effects: The file of what acts beside the description.
    """
    beside = "" if effects is None else f" with the effects of {effects}"
    span = "whole recordings" if result.horizon is None else f"rollouts of {result.horizon:g} s"
    parting = sum(each.parts for each in result.channels)
    several = len(result.recordings) != 1
    lines = [
        f"{result.robot} as described{beside}, beside {len(result.recordings)} "
        f"recording{'s' * several} of {result.seconds:.3g} s "
        f"({result.rollouts} {span} from recorded states):",
        f"  {parting} of {len(result.channels)} channels differ by more than noise and the "
        "rollouts' starts make",
    ]
    lines += [f"  {_line(each)}" for each in result.channels]
    return "\n".join([*lines, *(f"  note: {note}" for note in result.notes)])


def _line(each: ChannelError) -> str:
    force = "N m" if each.unit == "rad" else "N"
    size = f"{each.channel}: {each.error:.3g} {each.unit} off, RMS, "
    if each.motion > 0.0:
        share = 100.0 * each.error / each.motion
        share_text = f"{share:.0f}" if share >= 10.0 else f"{share:.2g}"
        size += f"{share_text} % of how far it moves in a rollout, "
    size += f"{each.error / each.noise:,.1f} times the noise of its readings"
    if each.by_starts > each.noise:
        size += f"; errors of the rollouts' starts alone make {each.by_starts:.3g} {each.unit}"
    if not each.parts:
        return f"{size}; as described"
    worst = each.worst
    return (
        f"{size}; most in {worst.recording} from {worst.start:.1f} to {worst.end:.1f} s "
        f"({worst.error:.3g} {each.unit}); {each.missing:.3g} {force} missing, RMS"
    )


def _further(options: Compare, *, whole: bool) -> str:
    """Return the commands that show and, if all were commanded, that name what parts."""
    given = [str(path) for path in options.recordings]
    root = [] if options.root is None else ["--root", str(options.root)]
    around = [] if options.world is None else ["--world", options.world]
    around += description_options(options.base, options.folder)
    shown = ["morph", "view", options.robot]
    for path in given:
        shown += ["--recording", path]
    if options.state is not None:
        shown = ["morph", "view", "--state", str(options.state)]
    else:
        shown += [*root, *around, "--first", "mismatch"]
    named = ["morph", "diagnose", options.robot, *given, *root, *around, "--out", "DIR"]
    further = shlex.join(named) if whole else "record every command, then morph diagnose"
    wrote = [f"wrote {path}" for path in (options.html, options.state) if path is not None]
    wrote += [f"to see it: {shlex.join(shown)}", f"to name what is missing: {further}"]
    return "\n".join(wrote)


def _saved(
    options: Compare, robot: Robot, recordings: Sequence[Recording], result: RolloutComparison
) -> Saved:
    """Return the view of the moment at which they part most."""
    from morph.app.viewer.mismatch.poses import span
    from morph.app.viewer.mismatch.windows import windows
    from morph.app.viewer.state import BodyRequest, Saved, Sources

    worst = result.channels[0].worst
    start, end = span(next(r for r in recordings if r.name == worst.recording), robot)
    parts = windows(end - start)
    window = max(at for at, (begin, _) in enumerate(parts) if begin <= worst.start)
    chosen = {"recording": worst.recording, "window": window, "horizon_s": result.horizon}
    return Saved(
        given=Sources(
            bodies=(BodyRequest(asked=options.robot, sha256=robot.sha256),),
            recordings=tuple(str(path) for path in options.recordings),
            root=None if options.root is None else str(options.root),
            world=options.world,
            base=options.base,
            folder=None if options.folder is None else str(options.folder.absolute()),
        ),
        view="mismatch",
        views={"mismatch": chosen},
        time=worst.start - parts[window][0],
        playing=False,
    )


def _write_page(options: Compare, saved: Saved, now: Callable[[str], None]) -> None:
    """Write the page of that view, which opens without a network."""
    from morph.app.cli import view_inputs
    from morph.app.cli.view import write_page
    from morph.app.cli.view_arguments import ViewCommand
    from morph.app.viewer.opening import Opening
    from morph.app.viewer.views.views import makers

    view = ViewCommand(
        robots=(options.robot,),
        recording=tuple(str(path) for path in options.recordings),
        root=options.root,
        world=options.world,
        base=options.base,
        folder=options.folder,
        first="mismatch",
    )
    given, notes = view_inputs.given(view, saved, now)
    result, first = makers(given, saved.view)
    command = view_inputs.command(view)
    opening = Opening(given=given, saved=saved, notes=tuple(notes), command=command)
    write_page(Path(options.html or ""), result[first](), opening, now)
