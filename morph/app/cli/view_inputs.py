"""Options of `morph view`, completed from a saved view."""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from morph.app.cli.console import harmless
from morph.app.cli.view_arguments import ViewCommand
from morph.errors import OutputError, ViewError

if TYPE_CHECKING:
    from morph.app.viewer.state import Saved, Sources
    from morph.app.viewer.view_request import ViewRequest

MOST_BODIES = 8
"""Bodies on one ground."""

MOST_SECONDS = 120.0
"""s; sixty pictures of each are kept."""

LAST_PORT = 65535


def check(options: ViewCommand) -> None:
    """Check what can be checked before anything is loaded.

    Raises:
        ViewError: An option is out of its range, or there are too many bodies.
        OutputError: The page cannot be written where it should be.
    """
    _check_seconds(
        options.seconds, where="--seconds", fix="leave it out, or give a time within that"
    )
    if not 0 <= options.port <= LAST_PORT:
        raise ViewError(
            f"there is no port {options.port}; they go from 0 to {LAST_PORT}",
            where="--port",
            fix="leave it out, or give 0 for any that is free",
        )
    if options.seed is not None and options.seed < 0:
        raise ViewError(
            f"it is {options.seed}, and a seed is 0 or more",
            where="--seed",
            fix="give a whole number",
        )
    if options.html is not None:
        check_page(Path(options.html), "--html")


def _check_seconds(seconds: float | None, *, where: str, fix: str) -> None:
    if seconds is not None and not 0.0 < seconds <= MOST_SECONDS:
        raise ViewError(
            f"it is {seconds:g} s; more than 0 and at most {MOST_SECONDS:g} can be shown",
            where=where,
            fix=fix,
        )


def check_page(path: Path, option: str) -> None:
    """Check that a file can be written.

    Raises:
        OutputError: It is a folder, or nothing can be written there.
    """
    if path.is_dir():
        raise OutputError("it is a folder", where=f"{option} {path}", fix="name a file in it")
    above = path.absolute().parent
    while not above.exists():
        above = above.parent
    try:
        tempfile.TemporaryFile(dir=above).close()
    except OSError as error:
        raise OutputError(
            f"nothing can be written there: {error.strerror or error}",
            where=f"{option} {path}",
            fix="name a file in a folder that can be written to",
        ) from error


def given(
    options: ViewCommand, saved: Saved | None, now: Callable[[str], None]
) -> tuple[ViewRequest, list[str]]:
    """Return what is to be shown, and what is to be known of it, a sentence each.

    Args:
        options: The options; they come before what was saved.
        saved: What is to be shown again.
        now: Is told what is being loaded.

    Raises:
        MorphError: A body cannot be loaded, there are too many, or it would take too long.
    """
    from morph.app.viewer.view_request import ViewRequest
    from morph.body.load import load

    of = _sources(options, saved)
    if len(of.bodies) > MOST_BODIES:
        raise ViewError(
            f"{len(of.bodies)} bodies are asked for, and the ground has room for {MOST_BODIES}",
            where="morph view",
            fix="leave some out, or open a second viewer at another --port",
        )
    # What somebody else saved is bounded as what is typed is: memory would end before the motion.
    _check_seconds(
        of.seconds, where=f"{options.state}, given.seconds", fix="give --seconds as well"
    )
    robots, notes = [], []
    for body in of.bodies:
        now(f"loading {body.asked}")
        robot = load(body.asked, base=of.base, folder=of.folder)
        if body.sha256 and robot.sha256 != body.sha256:
            notes.append(f"{robot.name} has changed since this view was saved.")
        robots.append(robot)
    return ViewRequest(
        robots=tuple(robots),
        asked=tuple(body.asked for body in of.bodies),
        task=of.task,
        policies=of.policies,
        recordings=tuple(map(Path, of.recordings)),
        root=None if of.root is None else Path(of.root),
        diagnosis=None if of.diagnosis is None else Path(of.diagnosis),
        transfer=None if of.transfer is None else Path(of.transfer),
        package=None if of.package is None else Path(of.package),
        world=of.world,
        seconds=of.seconds,
        seed=of.seed,
        base=of.base,
        folder=None if of.folder is None else Path(of.folder),
    ), notes


def read(options: ViewCommand) -> Saved | None:
    """Return the view that was saved, if one is named, having told which files it names.

    Raises:
        ViewError: It cannot be read, or is no saved view.
    """
    if options.state is None:
        return None
    from morph.app.viewer.reopen import read_state

    saved = read_state(Path(options.state))
    # It may come from somebody else: whoever opens it is to know what it has us read.
    for path in saved.given.files:
        sys.stderr.write(f"{harmless(options.state)} names {harmless(path)}\n")
    sys.stderr.flush()
    return saved


def _sources(options: ViewCommand, saved: Saved | None) -> Sources:
    """Return what is to be shown: the options, and what they leave open as it was saved."""
    from morph.app.viewer.state import BodyRequest, Sources

    known: dict[str, Any] = {
        "bodies": tuple(BodyRequest(asked=name, sha256="") for name in options.robots),
        "policies": options.policy,
        "recordings": options.recording,
        "task": options.task,
        "world": options.world,
        "seconds": options.seconds,
        "seed": options.seed,
        "base": options.base,
        "folder": None if options.folder is None else str(options.folder),
        "root": None if options.root is None else str(options.root),
        "diagnosis": options.diagnosis,
        "transfer": options.transfer,
        "package": options.package,
    }
    before = Sources() if saved is None else saved.given
    return replace(before, **{name: it for name, it in known.items() if it not in (None, ())})


def command(options: ViewCommand) -> str:
    """Return the command that shows this again, wherever it was written to."""
    parts = ["morph", "view", *options.robots]
    known: dict[str, object] = {
        "--task": options.task, "--root": options.root, "--diagnosis": options.diagnosis,
        "--transfer": options.transfer, "--package": options.package, "--world": options.world,
        "--seconds": options.seconds,
        "--state": options.state, "--first": options.first, "--base": options.base,
        "--folder": options.folder, "--seed": options.seed,
    }  # fmt: skip
    for option, given_many in (("--policy", options.policy), ("--recording", options.recording)):
        for each in given_many:
            parts += [option, each]
    for option, value in known.items():
        parts += [] if value is None else [option, str(value)]
    return shlex.join(parts)
