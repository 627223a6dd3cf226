"""What `morph simulate` tells of a run, in words and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

import morph
from morph.app.cli.console import harmless, paragraph, table
from morph.app.cli.effects import shown
from morph.arrays import JSON
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.worlds import World
from morph.record.recording import Channel, Recording

SCHEMA = "morph.simulation/1"
"""Name and version of what `--json` prints."""

MOST_CHANNELS = 24
"""Channels that are shown before the rest is counted; JSON has all."""


MOST_EFFECTS = 8
"""Effects that are told one by one; JSON tells all."""


@dataclass(frozen=True, kw_only=True)
class Done:
    """One run, and what became of it."""

    robot: Robot
    """What moved."""
    effects: tuple[Effect, ...]
    """What acted on it."""
    world: World | None
    """The named world around it; None if none was asked for."""
    notes: tuple[str, ...]
    """What had to be decided of its shapes, and what is doubtful about its start."""
    recording: Recording
    """What it did."""
    step: float
    """Seconds a step."""
    integrator: str
    """How it stepped."""
    asked: float
    """How long it was to move, s."""
    seconds: float
    """How long it moved, s."""
    took: float
    """How long that took to simulate, s."""
    policy: str | None
    """The policy's folder, as it was named; None for none."""
    files: Mapping[str, str]
    """What was written: the path of the `recording` and of the `video`."""
    why: str | None
    """Why it stopped short; None if it did not."""


def as_json(done: Done) -> JSON:
    """Return a run by the schema morph.simulation/1."""
    return {
        "schema": SCHEMA,
        "robot": {"name": done.robot.name, "sha256": done.robot.sha256},
        "effects": [
            {
                "name": effect.name,
                "where": effect.where,
                "parameters": {
                    known.name: float(getattr(effect, known.name)) for known in effect.parameters()
                },
            }
            for effect in done.effects
        ],
        "world": None if done.world is None else done.world.name,
        "notes": list(done.notes),
        "policy": done.policy,
        "seconds": done.seconds,
        "step": done.step,
        "integrator": done.integrator,
        "wall_seconds": done.took,
        "stopped_short": done.why,
        "channels": {
            name: {"samples": len(channel.value), **_figures(channel)}
            for name, channel in done.recording.channels.items()
        },
        "files": dict(done.files),
        # Nothing in a simulation is drawn by chance, so it has no seed.
        "provenance": {"morph": morph.__version__, "mujoco": version("mujoco"), "seed": None},
    }


def in_words(done: Done, columns: int | None) -> list[tuple[str, str]]:
    """Return a run in lines, each with its style.

    Args:
        done: The run.
        columns: The terminal's width; None: as wide as need be.
    """
    rate = f", {done.seconds / done.took:.3g} times as fast as it moves" if done.took > 0 else ""
    steps = f"steps of {1e3 * done.step:g} ms by {done.integrator}"
    head = f"{done.robot.name}: {done.seconds:g} s in {steps}{rate}"
    around = () if done.world is None else done.world.effects
    plain = [] if done.world is None else [f"  in {done.world.name}: {_counted(around)}"]
    others = [effect for effect in done.effects if effect not in around]
    if len(others) > MOST_EFFECTS:
        plain.append(f"  under {_counted(others)}")
    else:
        plain += [f"  under {shown(effect)}" for effect in others]
    if done.policy is not None:
        plain.append(f"  commanded by {done.policy}")
    lines = [(line, "bold") for line in paragraph(harmless(head), 4, columns)]
    lines += [(line, "") for text in plain for line in paragraph(harmless(text), 4, columns)]
    for note in done.notes:
        lines += [(line, "yellow") for line in paragraph(harmless(f"  {note}"), 4, columns)]
    lines += [("", ""), *_table(done.recording, columns), ("", "")]
    if done.why is not None:
        words = f"stopped short after {done.seconds:g} s of {done.asked:g} s: {done.why}"
        lines += [(line, "yellow") for line in paragraph(harmless(words), 4, columns)]
    for kind, path in done.files.items():
        lines += [(line, "") for line in paragraph(harmless(f"wrote {path} ({kind})"), 4, columns)]
    return lines


def _counted(effects: Sequence[Effect]) -> str:
    """Return a world's effects in a line; of many alike only how many there are."""
    names = dict.fromkeys(effect.name for effect in effects)
    if len(effects) == len(names):
        return "; ".join(shown(effect) for effect in effects)
    places = len({effect.where for effect in effects})
    return f"{', '.join(names)} at {places} places; --json lists them"


def _table(recording: Recording, columns: int | None) -> list[tuple[str, str]]:
    places = {
        name: channel
        for name, channel in recording.channels.items()
        if ".position" in name or ".orientation" in name
    }
    rows = []
    for name, channel in list(places.items())[:MOST_CHANNELS]:
        figures = (f"{value:.4g}" for value in _figures(channel).values())
        rows.append([harmless(name), *figures])
    titles = ["channel", "first", "last", "least", "greatest"]
    head, *body = table(titles, rows, columns=columns, right=titles[1:])
    lines = [(head, "bold"), *((line, "") for line in body)]
    more = len(places) - MOST_CHANNELS
    if more > 0:
        lines.append((f"... and {more} more; --json lists all", ""))
    return lines


def _figures(channel: Channel) -> dict[str, float]:
    value = channel.value
    return {
        "first": float(value[0]),
        "last": float(value[-1]),
        "least": float(np.min(value)),
        "greatest": float(np.max(value)),
    }
