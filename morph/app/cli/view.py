"""`morph view`: bodies side by side in the browser."""

from __future__ import annotations

from pathlib import Path

from morph.app.cli.view_arguments import View
from morph.errors import ViewError

DONE = 0

MOST_BODIES = 8
"""Bodies on one ground."""


def run_view(asked: View) -> int:
    """Show what is asked for until interrupted, and return the exit status.

    Raises:
        MorphError: An input cannot be used, or the page cannot be served or written.
    """
    if len(asked.robots) > MOST_BODIES:
        raise ViewError(
            f"{len(asked.robots)} bodies are asked for, and the ground has room for {MOST_BODIES}",
            where="morph view",
            fix="leave some out, or open a second viewer at another --port",
        )
    from morph.app.viewer.given import Given
    from morph.app.viewer.server import Viewer
    from morph.app.viewer.views.views import makers
    from morph.body.load import load

    robots = tuple(load(name, base=asked.base, folder=asked.folder) for name in asked.robots)
    given = Given(
        robots=robots,
        asked=asked.robots,
        task=asked.task,
        policies=asked.policy,
        recordings=tuple(map(Path, asked.recording)),
        root=asked.root,
        diagnosis=None if asked.diagnosis is None else Path(asked.diagnosis),
        transfer=None if asked.transfer is None else Path(asked.transfer),
        world=asked.world,
        seconds=asked.seconds,
        seed=asked.seed,
    )
    found, first = makers(given, asked.first)
    viewer = Viewer(
        lambda: [make() for make in found], first=first, host=asked.host, port=asked.port
    )
    viewer.wait()
    return DONE
