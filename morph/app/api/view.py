"""Bodies in the browser, as `morph view` shows them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.extras import require

if TYPE_CHECKING:
    from morph.app.viewer.server import Viewer


def view(
    *robots: str | Path,
    task: str | None = None,
    policy: Sequence[str | Path] = (),
    recording: Sequence[str | Path] = (),
    diagnosis: str | Path | None = None,
    transfer: str | Path | None = None,
    package: str | Path | None = None,
    world: str | None = None,
    seconds: float | None = None,
    port: int = 8080,
) -> Viewer:
    """Serve bodies side by side and return the server; `address` says where, `close` ends it.

    Args:
        robots: Up to eight, as `morph.load` takes them.
        task: What all of them do; by default joints show their ranges.
        policy: Folders of policies, each matched by its body.
        recording: Recordings to hold the first body's simulation against.
        diagnosis: Folder of a diagnosis of these recordings.
        transfer: Folder that `morph.transfer` or `morph.align` wrote.
        package: Folder that `morph.print_package` wrote.
        world: Where they move.
        seconds: How long they move.
        port: Port to serve at; if it is taken, the next free one.

    Raises:
        MorphError: An input cannot be used, or the page cannot be served.
    """
    require("view", "morph.view")
    from morph.app.cli import view_inputs
    from morph.app.cli.view import opened, served
    from morph.app.cli.view_arguments import ViewCommand

    def name(path: str | Path | None) -> str | None:
        return None if path is None else str(path)

    options = ViewCommand(
        robots=tuple(str(robot) for robot in robots),
        task=task,
        policy=tuple(str(each) for each in policy),
        recording=tuple(str(each) for each in recording),
        diagnosis=name(diagnosis),
        transfer=name(transfer),
        package=name(package),
        world=world,
        seconds=seconds,
        port=port,
        quiet=True,
    )
    view_inputs.check(options)
    return served(options, *opened(options))
