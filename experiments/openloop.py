"""How far models stray from recordings, open loop: one score for ours and for others'."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.data import data_root
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import Episode, episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.score import rmse, rollouts
from morph.model.segments import scored_segments
from morph.physics.effect import Effect
from morph.record.load import load_recordings
from morph.record.recording import Recording

BINDINGS = Path(__file__).resolve().parent / "bindings"


@dataclass(frozen=True, kw_only=True)
class Model:
    """A robot and the effects that its description cannot hold."""

    robot: Robot
    """The body."""
    effects: tuple[Effect, ...] = ()
    """What acts on it beyond its description."""


def bound(
    binding: str, folder: str, robot: Robot, names: Sequence[str], *, root: Path | None = None
) -> list[Recording]:
    """Return the named episodes of one of our bindings, in the order asked for.

    Args:
        binding: Its file's name without ending.
        folder: The set's folder under the root.
        robot: Whose parts the channels must name.
        names: Episodes.
        root: Folder of all recordings; None for that of `experiments.data`.
    """
    found = load_recordings(
        BINDINGS / f"{binding}.toml", robot=robot, root=(root or data_root()) / folder
    )
    by_name = {recording.name: recording for recording in found}
    return [by_name[name] for name in names]


def from_mjcf(text: str) -> Robot:
    """Return the robot that a description as text states, read as any user's file is."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "corrected.xml"
        path.write_text(text, encoding="utf-8")
        return load_robot(path)


def corrected(diagnosis: Diagnosis) -> Model:
    """Return the corrected model, rebuilt from nothing but what a diagnosis writes."""
    return Model(robot=from_mjcf(diagnosis.corrected), effects=diagnosis.corrected_effects)


def laid(recordings: Sequence[Recording], robot: Robot) -> list[Episode]:
    """Return recordings on the grid of a simulation."""
    step = step_for(recordings, robot)
    return [episode(recording, robot, step) for recording in recordings]


def errors(model: Model, episodes: Sequence[Episode], horizon: float | None) -> dict[str, float]:
    """Return the root mean square error of each joint's position over open-loop rollouts.

    Args:
        model: What is simulated.
        episodes: What was measured; rollouts start along them as measured.
        horizon: Seconds of each rollout; None for whole episodes.
    """
    hypothesis = Hypothesis(
        robot=model.robot, step=episodes[0].step, knobs=(), effects=model.effects
    )
    segments = scored_segments(episodes, horizon)
    predicted = rollouts({"model": (hypothesis, hypothesis.start)}, segments)["model"]
    joints = (joint.name for joint in model.robot.joints)
    return dict(zip(joints, map(float, rmse(segments, predicted)), strict=True))


def in_row(title: str, by_joint: dict[str, float], after: str = "") -> str:
    """Return one line of a table of errors."""
    return f"  {title:34} " + "  ".join(f"{value:8.4f}" for value in by_joint.values()) + after


def span(horizon: float | None) -> str:
    """Return a horizon in words."""
    return "whole episodes" if horizon is None else f"{horizon:g} s rollouts"


def named(effects: Iterable[Effect]) -> str:
    """Return effects in one line, with their parameters."""
    return ", ".join(
        f"{effect.label} ("
        + ", ".join(f"{p.name} {getattr(effect, p.name):.3g} {p.unit}" for p in effect.parameters())
        + ")"
        for effect in effects
    )
