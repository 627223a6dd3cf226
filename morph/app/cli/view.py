"""`morph view`: bodies side by side in the browser, or on a page that needs no network."""

from __future__ import annotations

import json
import os
import sys
import webbrowser
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli import view_inputs
from morph.app.cli.stages import stages
from morph.app.cli.view_arguments import ViewCommand
from morph.errors import ViewError

if TYPE_CHECKING:
    from morph.app.viewer.opening import Opening
    from morph.app.viewer.server import Viewer
    from morph.app.viewer.state import Saved
    from morph.app.viewer.view import View as Shown

DONE = 0

SCHEMA = "morph.viewing/1"

Makers = Sequence[Callable[[], "Shown"]]
"""What makes each view for a person, in the order of the tabs."""


def run_view(options: ViewCommand) -> int:
    """Show what is asked for until interrupted, or write the page, and return the exit status.

    Raises:
        MorphError: An input cannot be used, or the page cannot be served or written.
    """
    view_inputs.check(options)
    result, first, opening = opened(options)
    if options.html is None:
        _serve(options, result, first, opening)
        return DONE
    with stages(options.quiet) as progress:
        shown, path = result[first](), Path(options.html)
        size = write_page(path, shown, opening, progress.now)
    if options.json:
        _say(view=shown.name, views=[shown.name], html=str(path), bytes=size)
    elif not options.quiet:
        sys.stderr.write(
            f"{path} is written: {size / 1e6:.1f} MB, the view {shown.name} as it opens; without "
            "--html the browser shows all runs and views\n"
        )
    return DONE


def opened(options: ViewCommand) -> tuple[Makers, int, Opening]:
    """Return what makes each view, the number of the first, and with what every page begins.

    Raises:
        MorphError: An input cannot be used.
    """
    from morph.app.viewer.opening import Opening
    from morph.app.viewer.views.views import makers

    saved = view_inputs.read(options)
    with stages(options.quiet) as progress:
        given, notes = view_inputs.given(options, saved, progress.now)
        progress.now("looking at what was given")
        result, first = makers(given, options.first or (saved.view if saved else None))
        notes += _unfit(options, saved, result)
        for note in notes:
            progress.line(note)
    command = view_inputs.command(options)
    return result, first, Opening(given=given, saved=saved, notes=tuple(notes), command=command)


def _unfit(options: ViewCommand, saved: Saved | None, result: Makers) -> list[str]:
    """Return what of a saved view does not fit because the options say otherwise.

    Raises:
        ViewError: It does not fit although they do not.
    """
    unfit = []
    for view in (make() for make in result) if saved is not None else ():
        try:
            if saved is not None and view.name in saved.views:
                view.restore(saved.views[view.name])
        except ViewError as error:
            if not (
                options.robots
                or options.task
                or options.recording
                or options.transfer
                or options.package
            ):
                raise
            unfit.append(f"The view {view.name} is not as it was saved: {error.what}.")
    return unfit


def write_page(path: Path, view: Shown, opening: Opening, now: Callable[[str], None]) -> int:
    """Write one page that opens without a network, and return how many bytes it has."""
    from dataclasses import replace

    from morph.app.viewer.export.page import exported_page
    from morph.files import write_whole

    saved = opening.saved
    if saved is not None and view.name in saved.views:
        view.restore(saved.views[view.name])
    now(f"computing what the view {view.name} shows")
    view.complete()
    content = view.content()
    now("making the page")
    page = exported_page(
        replace(content, notes=(*opening.notes, *content.notes)),
        title=view.title,
        command=opening.command,
        arrows=view.arrows,
        following=saved is None or saved.follow,
        camera=None if saved is None else saved.camera,
    ).encode()
    write_whole(path, page)
    return len(page)


def served(options: ViewCommand, result: Makers, first: int, opening: Opening) -> Viewer:
    """Serve the page, in threads, and return who does."""
    from morph.app.viewer.server import Viewer

    return Viewer(
        lambda: [make() for make in result],
        first=first,
        host=options.host,
        port=options.port,
        opening=opening,
    )


def _serve(options: ViewCommand, result: Makers, first: int, opening: Opening) -> None:
    """Serve the page until interrupted."""
    viewer = served(options, result, first, opening)
    if options.json:
        names = [make().name for make in result]
        _say(
            view=names[first],
            views=names,
            address=viewer.address,
            port=viewer.door.server.get_port(),
            pid=os.getpid(),
        )
    if options.browser and not open_browser(viewer.address):
        sys.stderr.write("no browser was found; open the address by hand\n")
    viewer.wait()


def _say(**what: object) -> None:
    sys.stdout.write(json.dumps({"schema": SCHEMA, **what}) + "\n")
    sys.stdout.flush()


def open_browser(address: str) -> bool:
    """Open a browser that has a window, and return whether there is one.

    One within the terminal shows no bodies.
    """
    try:
        browser = webbrowser.get()
        windowed = type(browser) is not webbrowser.GenericBrowser
        return bool(windowed and browser.open(address))
    except (webbrowser.Error, OSError):
        return False
