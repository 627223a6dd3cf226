"""Reading what somebody saw from a file: bounded, and checked before anything is done by it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from morph.app.viewer.camera import Camera
from morph.app.viewer.clock import SPEEDS
from morph.app.viewer.state import LEARNED, NAMES, SCHEMA, BodyRequest, Saved, Sources, is_name
from morph.arrays import JSON
from morph.errors import ViewError
from morph.nearest import nearest
from morph.regular_file import read_regular

MOST_BYTES = 1_000_000
"""Of such a file; an honest one has a few thousand."""

MOST_ITEMS = 64
"""Bodies, policies or recordings in it."""

LONGEST = 4096
"""Characters of a path or a name."""

FARTHEST = 1e6
"""m: no camera is farther away."""

NEAREST = 1e-3
"""m: no camera is nearer to what it looks at; where both are one it has no direction."""


def read_state(path: Path) -> Saved:
    """Return what a file says that somebody saw; its paths are relative to the file's folder.

    Raises:
        ViewError: It cannot be read, or is not by the schema morph.view/1.
    """
    return _resolved(_Part(str(path), "", _loaded(path)).saved(), path.absolute().parent)


def _loaded(path: Path) -> Any:
    try:
        data = read_regular(path, MOST_BYTES)
    except OSError as error:
        raise ViewError(
            f"cannot be read: {error.strerror or error}",
            where=f"--state {path}",
            fix="name a view that was saved by the viewer's `save view`, and that can be read",
        ) from error
    try:
        return json.loads(data.decode("utf-8"), parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise ViewError(
            f"it is no JSON: {error}",
            where=str(path),
            fix="save the view again",
        ) from error


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number of JSON")


def _resolved(saved: Saved, folder: Path) -> Saved:
    """Return it with every path as seen from a folder."""
    given = saved.given

    def whole(path: str | None) -> str | None:
        return None if path is None else str(folder / path)

    return replace(
        saved,
        given=replace(
            given,
            bodies=tuple(
                body if is_name(body.asked) else replace(body, asked=str(folder / body.asked))
                for body in given.bodies
            ),
            policies=tuple(
                each if each == LEARNED else str(folder / each) for each in given.policies
            ),
            recordings=tuple(str(folder / each) for each in given.recordings),
            folder=whole(given.folder),
            root=whole(given.root),
            diagnosis=whole(given.diagnosis),
            transfer=whole(given.transfer),
            package=whole(given.package),
        ),
    )


class _Part:
    """An object within the file, whose members are taken one after another.

    Args:
        file: Of what it is part.
        place: Where it stands in it.
        value: What stands there.
    """

    def __init__(self, file: str, place: str, value: Any) -> None:
        self._file, self._place = file, place
        if not isinstance(value, dict):
            raise self.wrong("", value, "an object")
        self._members: JSON = dict(value)
        self._known: list[str] = []

    def saved(self) -> Saved:
        self.take("schema", lambda it: it == SCHEMA, repr(SCHEMA))
        self.take("morph", _text, "a version")
        given = _Part(self._file, "given", self.take("given", _object, "an object")).sources()
        clock = _Part(self._file, "clock", self.take("clock", _object, "an object"))
        camera = self.take("camera", _or_null(_object), "an object or null")
        result = Saved(
            given=given,
            view=self.take("view", lambda it: it in NAMES, f"one of {', '.join(NAMES)}"),
            views=self._views(),
            time=float(clock.take("time", lambda it: _number(it, 0.0, 1e6), "seconds from 0 on")),
            speed=float(clock.take("speed", lambda it: it in SPEEDS, f"one of {SPEEDS}")),
            playing=clock.take("playing", _switch, "true or false"),
            repeat=clock.take("repeat", _switch, "true or false"),
            camera=camera and _Part(self._file, "camera", camera).camera(),
            hidden=tuple(self.take("hidden_arrows", _texts, "a list of names")),
            follow=self.take("follow", _switch, "true or false"),
        )
        clock.done()
        self.done()
        return result

    def _views(self) -> JSON:
        views = self.take("views", _object, "an object")
        part = _Part(self._file, "views", views)
        for name in NAMES:
            if name in views:
                part.take(name, _object, "an object")
        part._known = list(NAMES)
        part.done()
        return dict(views)

    def sources(self) -> Sources:
        bodies = self.take("bodies", _some_objects, "a list of objects")
        text_or_null = _or_null(_text)
        # Views that were saved before there were packages say nothing of them.
        self._members.setdefault("package", None)
        result = Sources(
            bodies=tuple(
                _Part(self._file, f"{self._place}.bodies[{at}]", body).body()
                for at, body in enumerate(bodies)
            ),
            policies=tuple(self.take("policies", _texts, "a list of paths")),
            recordings=tuple(self.take("recordings", _texts, "a list of paths")),
            seconds=self.take(
                "seconds", _or_null(lambda it: _number(it, 0.0, 1e6)), "seconds or null"
            ),
            seed=self.take("seed", _whole_number, "a whole number from 0 on"),
            **{
                name: self.take(name, text_or_null, "a text or null")
                for name in (
                    "base",
                    "folder",
                    "task",
                    "root",
                    "diagnosis",
                    "transfer",
                    "package",
                    "world",
                )
            },
        )
        self.done()
        return result

    def body(self) -> BodyRequest:
        result = BodyRequest(
            asked=self.take("asked", _text, "a name or a path"),
            sha256=self.take("sha256", _text_or_none, "a hash"),
        )
        self.done()
        return result

    def camera(self) -> Camera:
        result = Camera(
            position=tuple(self.take("position", _point, "three numbers, m")),
            look_at=tuple(self.take("look_at", _point, "three numbers, m")),
        )
        self.done()
        if math.dist(result.position, result.look_at) < NEAREST:
            raise self.wrong(
                "look_at", result.look_at, "a point that is not the camera's own place"
            )
        return result

    def take(self, name: str, fits: Callable[[Any], bool], allowed: str) -> Any:
        """Return a member, which must be there and fit."""
        self._known.append(name)
        if name not in self._members:
            raise ViewError(
                f"it lacks {self._at(name)!r}",
                where=self._file,
                fix=f"give it: {allowed}; or save the view again",
            )
        value = self._members.pop(name)
        if not fits(value):
            raise self.wrong(name, value, allowed)
        return value

    def done(self) -> None:
        """Refuse whatever is left."""
        for name in self._members:
            raise ViewError(
                f"it has {self._at(str(name)[:80])!r}, which is not known",
                where=self._file,
                fix=f"leave it out, or name it as meant: {nearest(name[:80], self._known)}",
            )

    def wrong(self, name: str, value: Any, allowed: str) -> ViewError:
        """Return what to say of a value that does not fit."""
        shown = json.dumps(value)
        shown = shown if len(shown) <= 80 else f"{shown[:80]}..."
        where = self._at(name)
        return ViewError(
            f"{where} is {shown}" if where else f"it holds {shown}",
            where=self._file,
            fix=f"give {allowed}; or save the view again",
        )

    def _at(self, name: str) -> str:
        return ".".join(filter(None, (self._place, name)))


def _switch(value: Any) -> bool:
    return isinstance(value, bool)


def _text(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST and "\0" not in value


def _text_or_none(value: Any) -> bool:
    return value == "" or _text(value)


def _texts(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= MOST_ITEMS and all(map(_text, value))


def _object(value: Any) -> bool:
    return isinstance(value, dict)


def _some_objects(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= MOST_ITEMS and all(map(_object, value))


def _number(value: Any, low: float, high: float) -> bool:
    there = isinstance(value, int | float) and not isinstance(value, bool)
    return there and math.isfinite(value) and low <= value <= high


def _whole_number(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**63


def _point(value: Any) -> bool:
    fits = isinstance(value, list) and len(value) == 3
    return fits and all(_number(each, -FARTHEST, FARTHEST) for each in value)


def _or_null(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: value is None or fits(value)
