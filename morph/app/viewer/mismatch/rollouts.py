"""A window of a fixed robot whose joints are all measured, simulated as a diagnosis scores it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from morph.app.viewer.mismatch.window import MismatchModel, MismatchTrace
from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.robot import FREEDOMS, Robot
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.score import rmse, rollouts, traces
from morph.model.segments import Segments, scored_segments


def hypothesis_of(model: MismatchModel, step: float) -> Hypothesis:
    """Return a model as the diagnosis simulates it, nothing of it free to be refitted."""
    return Hypothesis(robot=model.robot, step=step, knobs=(), effects=model.effects)


def simulated(
    models: Sequence[MismatchModel], episode: Episode, horizon: float | None
) -> tuple[Segments, dict[str, Array]]:
    """Return the rollouts along an episode, and each model's prediction of their readings.

    Args:
        models: What is simulated.
        episode: A recording, or a window of it.
        horizon: Seconds a rollout; None for one from start to end.

    Returns:
        The rollouts, and by model the readings (rollouts, readings, joints).
    """
    segments = scored_segments([episode], horizon)
    laid = [hypothesis_of(model, episode.step) for model in models]
    return segments, rollouts(
        {model.name: (each, each.start) for model, each in zip(models, laid, strict=True)},
        segments,
    )


def traced(
    robot: Robot, segments: Segments, predicted: Mapping[str, Array]
) -> tuple[MismatchTrace, ...]:
    """Return each channel along all rollouts."""
    joined = traces(segments, predicted)
    errors = {name: rmse(segments, values) for name, values in predicted.items()}
    links = [each.link for each in robot.joints for _ in range(FREEDOMS[each.kind])]
    return tuple(
        MismatchTrace(
            channel=each.channel,
            unit=each.unit,
            link=link,
            time=each.time,
            measured=each.measured,
            simulated=each.models,
            noise=float(segments.noise[at]),
            rmse={name: float(error[at]) for name, error in errors.items()},
        )
        for at, (link, each) in enumerate(zip(links, joined, strict=True))
    )


def pictured(segments: Segments, predicted: Array, measured: Array) -> Array:
    """Return positions in the pictures; where nothing is simulated, as measured.

    Args:
        segments: Rollouts.
        predicted: Their readings, (rollouts, readings, channels).
        measured: `qpos` as recorded in the pictures, (pictures, nq).
    """
    measurement = segments.measurement
    space = measurement.coordinates
    attitude = np.empty((len(measured), len(space.balls), 4))
    for ball, (at, _) in enumerate(space.balls):
        attitude[:, ball] = measured[:, at : at + 4]
    # A rotation is from the measured orientation, which is known in every picture.
    result = measurement.scalars(measured).copy()
    starts = measurement.scalars(segments.start[:, : space.positions])
    when = np.arange(len(measured)) / RATE
    for row in range(len(segments)):
        inside = segments.valid[row].any(axis=1)
        begin, _ = segments.seconds(row)
        offset = segments.before[row, inside] + segments.part[row, inside]
        times = np.concatenate([[begin], begin + segments.step * offset])
        here = (when >= begin - 1e-9) & (when <= times[-1] + 1e-9)
        for dof in range(space.dofs):
            values = np.concatenate([[starts[row, dof]], predicted[row, inside, dof]])
            result[here, dof] = np.interp(when[here], times, values)
    return measurement.placed(result, attitude)
