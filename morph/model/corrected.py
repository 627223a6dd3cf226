"""The corrected model, and what must be known to trust or repeat it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from morph.arrays import JSON
from morph.body.fulltext import fulltext
from morph.model.episodes import gaps
from morph.model.evidence import Evidence
from morph.physics.apply import apply
from morph.physics.effect import Effect


def corrected(e: Evidence, worse: bool) -> tuple[tuple[Effect, ...], str]:
    """Return the effects that MuJoCo cannot hold, and the description with all others."""
    found = e.best.fit
    if worse:
        spec = e.nominal.spec_at(e.nominal.start)
        spec.compile()
        return (), fulltext(spec)
    return split(found.hypothesis.spec_at(found.point), found.hypothesis.effects_at(found.point))


def split(spec: Any, effects: Sequence[Effect]) -> tuple[tuple[Effect, ...], str]:
    """Return the effects that MuJoCo cannot hold, and a description with all others.

    Args:
        spec: The description as a `mujoco.MjSpec`; it is edited.
        effects: What acts on it.
    """
    beside = tuple(effect for effect in effects if effect.outside)
    apply(spec, (effect for effect in effects if not effect.outside))
    spec.compile()
    return beside, fulltext(spec)


def data(e: Evidence) -> JSON:
    """Return what was read and what was dropped or repaired, counted."""
    recordings = [episode.recording for episode in (*e.train, *e.aside)]
    notes = [note for recording in recordings for note in recording.notes]
    return {
        "samples": sum(recording.samples for recording in recordings),
        "dropped": sum(note.dropped for note in notes),
        "repaired": sum(note.repaired for note in notes),
        # Two identical episodes are refused before any work, so none can be left here.
        "duplicates": [],
        "rollouts_fitted": len(e.search.segments),
        "rollouts_scored": len(e.scored),
    }


def notes(e: Evidence) -> tuple[str, ...]:
    """Return what was dropped, repaired or looks odd, in words."""
    said = [
        f"{note.where}: {note.what}"
        for episode in (*e.train, *e.aside)
        for note in episode.recording.notes
    ]
    said += [f"Joint {joint} does not move in any run that was fitted." for joint in e.still]
    said += [f"{episode.name}: {gap}" for episode in (*e.train, *e.aside) for gap in gaps(episode)]
    for index, episode in enumerate(e.train):
        inside = e.search.segments.episode == index
        weight = e.searched[1].fit.weight
        if inside.any():
            typical = float(np.median(weight))
            if float(np.median(weight[inside])) < 0.5 * typical:
                said.append(
                    f"{episode.name}: its error stays several times that of the others under "
                    "every model, so it was given less weight; look at its commands and clock."
                )
    return tuple(said)


def provenance(e: Evidence) -> dict[str, Any]:
    """Return versions and hashes."""
    return {
        "morph": version("morph"),
        "mujoco": version("mujoco"),
        "robot_sha256": e.robot.sha256,
        "recordings_sha256": {
            episode.name: episode.recording.sha256 for episode in (*e.train, *e.aside)
        },
    }
