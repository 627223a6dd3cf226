"""What `morph view` takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from morph.app.cli.options import Base, File, Folder, Many, Name, Seconds, unset


@dataclass(frozen=True, kw_only=True)
class ViewCommand:
    """Show bodies side by side in the browser: compare, design, align, or see a mismatch.

    Example: morph view cartpole rider_rigid_driven --task balance --policy learned
    """

    robots: Annotated[tyro.conf.Positional[tuple[str, ...]], unset("ROBOT ...")] = ()
    """Up to eight: descriptions, robot folders, or names on the shelf."""
    task: Name = None
    """What all of them do: a name from `morph list tasks`; without one joints show their ranges."""
    policy: Annotated[Many, unset("DIR")] = ()
    """Policy of one of the bodies, matched by its body; or `learned`. May be repeated."""
    recording: Annotated[Many, unset("FILE")] = ()
    """Recording to hold the first body's simulation against; may be repeated."""
    root: Folder = None
    """Folder that a recording.toml's files are relative to, instead of its own `root`."""
    diagnosis: Annotated[str | None, unset("DIR")] = None
    """Folder that `morph diagnose` wrote about these recordings."""
    transfer: Annotated[str | None, unset("DIR")] = None
    """Folder that `morph transfer` or `morph align` wrote; its bodies are shown."""
    package: Annotated[str | None, unset("DIR")] = None
    """Folder that `morph print` wrote; its parts are shown."""
    world: Name = None
    """Where they move, if not where the task says: as `morph simulate --world`."""
    seconds: Seconds = None
    """How long they move; by default as long as the task, or five seconds."""
    state: File = None
    """View that was saved before, as JSON; other options come before what it says."""
    html: File = None
    """Write one page that opens without a network, and end."""
    first: Annotated[
        Literal["compare", "design", "align", "mismatch", "print"] | None,
        unset("{compare,design,align,mismatch,print}"),
    ] = None
    """The view to begin with, and the one that --html writes."""
    host: Annotated[str, tyro.conf.arg(metavar="ADDRESS")] = "127.0.0.1"
    """Address to serve at; by default only this machine can look. Any other takes a token."""
    port: int = 8080
    """Port to serve at; if it is taken, the next free one."""
    browser: bool = False
    """Open a browser on it."""
    base: Base = None
    """How bodies stand in the world, where a description does not say."""
    folder: Folder = None
    """Folder outside which nothing of a description is read; by default its own."""
    seed: Annotated[int | None, unset("INT")] = None
    """Random seed; 0 unless a saved view says otherwise."""
    json: bool = False
    """Print where it is served as one line of JSON, by the schema morph.viewing/1."""
    quiet: bool = False
    """Show no progress."""
