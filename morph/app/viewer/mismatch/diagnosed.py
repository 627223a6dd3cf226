"""A diagnosis as its folder holds it, checked against the robot before it is believed."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from morph.app.viewer.mismatch.checked_json import Said
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MorphError, ViewError
from morph.model.diagnosis import SCHEMA, Stretch
from morph.physics.effect import Effect
from morph.physics.store import effect_of, load_effects
from morph.regular_file import read_regular

MOST_BYTES = 2**24
"""Largest diagnosis.json that is read."""
MOST_FINDINGS = 50
"""Findings that are read."""


@dataclass(frozen=True, kw_only=True)
class DiagnosedFinding:
    """One finding of a diagnosis."""

    effect: Effect
    """What was left out, as fitted."""
    statement: str
    """In one sentence; from a file, so never to be trusted as HTML."""
    figures: str
    """Its parameters with their intervals and how sure it is, in words."""


@dataclass(frozen=True, kw_only=True)
class Event:
    """A change of the robot, or the start of what acts in one episode alone."""

    episode: str
    """The episode."""
    time: float
    """When, s from its start."""
    title: str
    """What, as the timeline calls it."""


@dataclass(frozen=True, kw_only=True)
class Diagnosed:
    """What a folder says of a diagnosis."""

    folder: Path
    """Where it was read."""
    verdict: str
    """consistent, mismatch or unknown."""
    findings: tuple[DiagnosedFinding, ...]
    """What was left out."""
    stretches: tuple[Stretch, ...]
    """The worst stretches of held-out episodes."""
    horizon: float | None
    """Seconds of the rollouts that it scored; None for whole episodes."""
    train: tuple[str, ...]
    """Episodes that were fitted."""
    held_out: tuple[str, ...]
    """Episodes that no model had seen."""
    by_time: bool
    """Whether it held out the last quarter of one episode."""
    robot_sha256: str
    """Hash of the description that it was made of."""
    recordings_sha256: dict[str, str]
    """Hash of each episode by name."""
    command: str
    """The command that made it, empty if it was made from Python."""
    corrected: Robot | None
    """The corrected description; None if there is none."""
    effects: tuple[Effect, ...]
    """What MuJoCo cannot hold of the correction."""
    events: tuple[Event, ...] = ()
    """When the robot changed or was pushed."""


def load_diagnosed(folder: Path, robot: Robot) -> Diagnosed:
    """Return a diagnosis of a robot.

    Raises:
        ViewError: The folder holds no diagnosis, or one of another robot.
        MorphError: The corrected model in it cannot be used.
    """
    path = folder / "diagnosis.json"
    content = Said(_json(path), where=str(path))
    if content.text("schema") != SCHEMA:
        raise ViewError(
            f"its schema is not {SCHEMA!r}",
            where=str(path),
            fix="name a folder that this version of `morph diagnose` wrote",
        )
    fit, provenance = content.table("fit"), content.table("provenance")
    horizon = None if fit.content.get("horizon_s") == "full" else fit.number("horizon_s")
    if horizon is not None and horizon < 0.1:
        raise ViewError(
            f"a horizon of {horizon:g} s", where=str(path), fix="a horizon is 0.1 s or more"
        )
    corrected = _corrected(folder, robot)
    return Diagnosed(
        folder=folder,
        verdict=content.text("verdict"),
        findings=tuple(_found(each, robot) for each in content.tables("findings")[:MOST_FINDINGS]),
        stretches=tuple(_stretch(each) for each in content.table("located").tables("times")),
        horizon=horizon,
        train=fit.texts("train"),
        held_out=fit.texts("held_out"),
        by_time=fit.text("split") == "by time",
        robot_sha256=provenance.text("robot_sha256"),
        recordings_sha256=provenance.table("recordings_sha256").of_texts(),
        command=provenance.text("command", default=""),
        corrected=corrected,
        effects=() if corrected is None else _effects(folder, corrected),
        events=tuple(_events(content))[:MOST_FINDINGS],
    )


def command_of(folder: Path) -> str:
    """Return the command that made a diagnosis, empty if the folder does not say.

    Raises:
        ViewError: The folder holds no diagnosis.
    """
    path = folder / "diagnosis.json"
    return Said(_json(path), where=str(path)).table("provenance").text("command", default="")


def _json(path: Path) -> Any:
    try:
        return json.loads(read_regular(path, MOST_BYTES))
    # Brackets in their thousands exceed Python's own depth.
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or str(error)[:200]
        raise ViewError(
            f"the diagnosis cannot be read: {why}",
            where=str(path),
            fix="name a folder that `morph diagnose --out` wrote",
        ) from error


def _events(content: Said) -> Iterator[Event]:
    """Yield changes of the robot, and findings that act in one episode alone."""
    for each in content.tables("changes") if "changes" in content.content else ():
        title = f"change: {each.text('effect')}@{each.table('where').text('name')}"
        yield Event(episode=each.text("episode"), time=each.number("time_s"), title=title)
    for each in content.tables("findings"):
        if each.content.get("interval_s") is not None and (names := each.texts("episodes")):
            title = f"{each.text('effect')}@{each.table('where').text('name')}"
            yield Event(episode=names[0], time=each.number("onset_s"), title=title)


def _found(statement: Said, robot: Robot) -> DiagnosedFinding:
    place = statement.table("where").text("name")
    parameters = {
        name: statement.table("parameters").table(name)
        for name in statement.table("parameters").content
    }
    values = {name: each.number("value") for name, each in parameters.items()}
    effect = effect_of(
        {"name": statement.text("effect"), "where": place, **values}, where=statement.where
    )
    if place not in effect.places(robot):
        raise ViewError(
            f"{effect.label} concerns a part that {robot.name} does not have",
            where=statement.where,
            fix="name the robot that was diagnosed",
        )
    probability = statement.number("probability")
    if not 0.0 <= probability <= 1.0:
        raise ViewError(
            f"a probability of {probability:g}",
            where=statement.where,
            fix="give the file as `morph diagnose` wrote it",
        )
    lines = (
        f"{name} = {each.number('value'):.3g} "
        f"[{each.number('low90'):.3g}, {each.number('high90'):.3g}] {each.text('unit')}"
        for name, each in parameters.items()
    )
    return DiagnosedFinding(
        effect=effect,
        statement=statement.text("statement"),
        figures=", ".join((*lines, f"{100.0 * probability:.0f} % sure")),
    )


def _stretch(statement: Said) -> Stretch:
    episode = statement.text("episode")
    return Stretch(
        episode=episode,
        recording=statement.text("recording", default=episode),
        begin=statement.number("begin_s", default=0.0),
        start=statement.number("start_s"),
        end=statement.number("end_s"),
        share=statement.number("share"),
    )


def _corrected(folder: Path, robot: Robot) -> Robot | None:
    path = folder / "corrected.xml"
    if not path.is_file():
        return None
    try:
        result = load(path)
    except MorphError as error:
        raise ViewError(
            f"the corrected description cannot be used: {error.what}",
            where=error.where if str(path) in error.where else f"{path}, {error.where}",
            fix="run the diagnosis again, or leave --diagnosis out",
        ) from error
    parts = [
        ("joints", _joints(robot), _joints(result)),
        ("actuators", _actuators(robot), _actuators(result)),
    ]
    for kind, ours, theirs in parts:
        if ours != theirs:
            raise ViewError(
                f"it corrects another robot: its {kind} are {', '.join(theirs) or 'none'}; "
                f"those of {robot.name} are {', '.join(ours) or 'none'}",
                where=str(path),
                fix="name the robot that was diagnosed",
            )
    return result


def _joints(robot: Robot) -> list[str]:
    return [f"{joint.name} ({joint.kind})" for joint in robot.joints]


def _actuators(robot: Robot) -> list[str]:
    return [f"{actuator.name} ({actuator.joint or actuator.part})" for actuator in robot.actuators]


def _effects(folder: Path, corrected: Robot) -> tuple[Effect, ...]:
    path = folder / "corrected.toml"
    if not path.is_file():
        return ()
    effects = load_effects(path)
    for effect in effects:
        if effect.where not in effect.places(corrected):
            raise ViewError(
                f"{effect.label} concerns a part that {corrected.name} does not have",
                where=str(path),
                fix="name the robot that was diagnosed",
            )
    return effects
