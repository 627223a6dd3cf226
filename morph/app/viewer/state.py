"""What a page shows, as JSON that shows it again: the schema morph.view/1."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import morph
from morph.app.viewer.camera import Camera, camera_of
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON
from morph.body import shelf
from morph.body.robot import Robot

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

SCHEMA = "morph.view/1"

NAMES = ("compare", "design", "align", "mismatch", "print")
"""What views are called."""

LEARNED = "learned"
"""What stands where a policy's folder could."""


@dataclass(frozen=True, kw_only=True)
class BodyRequest:
    """A body as it was asked for."""

    asked: str
    """A name on the shelf or a path."""
    sha256: str
    """Hash of the description and its card then."""


@dataclass(frozen=True, kw_only=True)
class Sources:
    """What a page was given; all paths as text."""

    bodies: tuple[BodyRequest, ...] = ()
    base: str | None = None
    folder: str | None = None
    task: str | None = None
    policies: tuple[str, ...] = ()
    recordings: tuple[str, ...] = ()
    root: str | None = None
    diagnosis: str | None = None
    transfer: str | None = None
    package: str | None = None
    world: str | None = None
    seconds: float | None = None
    seed: int = 0

    @property
    def files(self) -> tuple[str, ...]:
        """Every path in it, in order."""
        bodies = [body.asked for body in self.bodies if not is_name(body.asked)]
        policies = [policy for policy in self.policies if policy != LEARNED]
        others = (self.folder, self.root, self.diagnosis, self.transfer, self.package)
        return (*bodies, *policies, *self.recordings, *filter(None, others))


@dataclass(frozen=True, kw_only=True)
class Saved:
    """What a person saw."""

    given: Sources
    """Of what."""
    view: str
    """By which view."""
    views: Mapping[str, JSON] = field(default_factory=dict)
    """What each view's `state` said, by its name."""
    time: float = 0.0
    """Where the clock was, s."""
    speed: float = 1.0
    """How fast it ran."""
    playing: bool = True
    """Whether it did."""
    repeat: bool = True
    """Whether it began again after the end."""
    camera: Camera | None = None
    """From where it was seen."""
    hidden: tuple[str, ...] = ()
    """Kinds of arrows that were not drawn."""
    follow: bool = True
    """Whether the camera went with what travels."""

    def text(self) -> str:
        """Return it as JSON."""
        given = {**vars(self.given), "bodies": [vars(body) for body in self.given.bodies]}
        whole = {
            "schema": SCHEMA,
            "morph": morph.__version__,
            "given": given,
            "view": self.view,
            "views": dict(self.views),
            "clock": {
                "time": self.time,
                "speed": self.speed,
                "playing": self.playing,
                "repeat": self.repeat,
            },
            "camera": None if self.camera is None else vars(self.camera),
            "hidden_arrows": self.hidden,
            "follow": self.follow,
        }
        return json.dumps(whole, indent=2, allow_nan=False) + "\n"


def saved(session: Session) -> Saved:
    """Return what a session shows now; called in its thread."""
    clock, stage = session.clock, session.stage
    given = session.opening.given
    return Saved(
        given=Sources() if given is None else sources(given),
        view=session.view.name,
        views={view.name: state for view in session.views if (state := view.state())},
        time=clock.time,
        speed=clock.speed,
        playing=clock.playing,
        repeat=clock.looping,
        camera=camera_of(session.client.camera),
        hidden=tuple(sorted(stage.hidden_arrows)),
        follow=stage.following,
    )


def sources(given: ViewRequest) -> Sources:
    """Return what was given as text; paths are whole, for nobody knows where it will be kept."""
    return Sources(
        bodies=tuple(map(_body, given.asked, given.robots)),
        base=given.base,
        folder=_whole(given.folder),
        task=given.task,
        policies=tuple(
            each if each == LEARNED else str(Path(each).absolute()) for each in given.policies
        ),
        recordings=tuple(str(each.absolute()) for each in given.recordings),
        root=_whole(given.root),
        diagnosis=_whole(given.diagnosis),
        transfer=_whole(given.transfer),
        package=_whole(given.package),
        world=given.world,
        seconds=given.seconds,
        seed=given.seed,
    )


def is_name(requested: str) -> bool:
    """Return whether a body is asked for by its name on the shelf, not by a path."""
    return len(Path(requested).parts) == 1 and requested in shelf.names()


def _body(requested: str, robot: Robot) -> BodyRequest:
    whole = requested if is_name(requested) else str(Path(requested).absolute())
    return BodyRequest(asked=whole, sha256=robot.sha256)


def _whole(path: Path | None) -> str | None:
    return None if path is None else str(path.absolute())
