"""Readings that a model predicts of the held-out run of a case."""

from __future__ import annotations

import gzip
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect
from morph.record.recording import Channel
from morph.sim.drive import held, received, sensed, stamped
from morph.sim.rollout import rollout

STEP = 0.0005
"""Seconds a step of the coarser of two simulations, whose errors are extrapolated to none."""
HORIZON = 1.0
"""Seconds of a window."""
DIVERGED = 100.0
"""Readings, rad or m, that no mechanism here reaches."""
Predicted = dict[str, list[float | None]]
"""Readings of each position channel at each time of the held-out run, None outside of windows."""


@dataclass(frozen=True, kw_only=True)
class HeldOut:
    """What a case tells of its held-out run."""

    time: Array
    """Times of its readings and commands, s, shape (ticks,)."""
    command: dict[str, Array]
    """Each actuator's command at each step, shape (steps,)."""
    begin: Array
    """Where the windows start, s, shape (windows,)."""
    reading: dict[str, Array]
    """What each joint's channel reads there, shape (windows,)."""
    rate: dict[str, Array]
    """How fast that changes, per s, same shape."""
    step: float
    """Seconds a step."""

    @classmethod
    def read(cls, folder: Path, robot: Robot, step: float = STEP) -> HeldOut:
        """Return the held-out run in a case's folder."""
        sent = _table(gzip.decompress((folder / "held_out" / "commands.csv.gz").read_bytes()))
        starts = _table((folder / "held_out" / "starts.csv").read_bytes())
        time, begin = sent["time"], starts["time"]
        total = round((float(begin[-1]) + HORIZON) / step)
        names = [actuator.name for actuator in robot.actuators]
        channels = {n: Channel(time=time, value=sent[f"{n}.command"]) for n in names}
        joints = [joint.name for joint in robot.joints]
        return cls(
            time=time,
            # A step carries velocities from half of it before to half of it after.
            command={n: held(c, -0.5 * step, step, total) for n, c in channels.items()},
            begin=begin,
            reading={joint: starts[f"{joint}.position"] for joint in joints},
            rate={joint: starts[f"{joint}.velocity"] for joint in joints},
            step=step,
        )

    def windows(self, commands: Sequence[Array]) -> Array:
        """Return commands of each window, shape (windows, steps, actuators)."""
        first = np.rint(self.begin / self.step).astype(int)
        rows = first[:, None] + np.arange(round(HORIZON / self.step))
        return np.stack(commands, axis=-1)[rows] if commands else np.zeros((*rows.shape, 0))

    def shown(self, joint: str, path: Array, effects: Sequence[Effect] = ()) -> list[float | None]:
        """Return readings of a joint that moves along paths, shape (windows, steps + 1).

        Before a window it is taken to have moved at the path's first rate. Readings of a path that
        diverged are those where the window starts.
        """
        channel = f"{joint}.position"
        values: list[float | None] = [None] * len(self.time)
        for window, start in enumerate(self.begin):
            inside = np.flatnonzero((self.time >= start) & (self.time < start + HORIZON))
            told = self.time[inside]
            # To first order, a clock that stamps s(t) at t read at 2 t - s(t) what it stamps t.
            spot = (2.0 * told - stamped(effects, channel, told) - start) / self.step
            true = np.interp(spot, np.arange(path.shape[1]), path[window])
            true += np.minimum(spot, 0.0) * (path[window, 1] - path[window, 0])
            reading = sensed(effects, channel, true)
            reading = np.where(np.abs(reading) < DIVERGED, reading, self.reading[joint][window])
            for index, value in zip(inside.tolist(), reading.tolist(), strict=True):
                values[index] = value
        return values


def predicted(folder: Path, robot: Robot, effects: Sequence[Effect] = ()) -> Predicted:
    """Return each position channel's predicted readings.

    Every window starts from the readings and rates that the case gives, which hold the sensors'
    own faults. MuJoCo's damping is of first order in the step, and sensors may be quieter.

    Source: Richardson 1911, Phil. Trans. R. Soc. A 210, 307-357 (extrapolation to no step).

    Args:
        folder: The case's.
        robot: The model's description.
        effects: What acts beside it.
    """
    coarse, fine = (_simulated(folder, robot, effects, step) for step in (STEP, 0.5 * STEP))
    return {
        channel: [
            None if one is None or other is None else 2.0 * other - one
            for one, other in zip(coarse[channel], fine[channel], strict=True)
        ]
        for channel in coarse
    }


def _simulated(folder: Path, robot: Robot, effects: Sequence[Effect], step: float) -> Predicted:
    run = HeldOut.read(folder, robot, step)
    hypothesis = Hypothesis(robot=robot, step=step, knobs=(), effects=tuple(effects))
    variant = hypothesis.at(hypothesis.start)
    model, count = variant.model, len(run.begin)
    commands = [received(variant.effects, n, told, step) for n, told in run.command.items()]
    position, velocity = np.zeros((count, model.nq)), np.zeros((count, model.nv))
    places = {joint.name: model.joint(joint.name) for joint in robot.joints}
    for joint, place in places.items():
        channel = f"{joint}.position"
        bias = sensed(variant.effects, channel, np.zeros(1))
        scale = sensed(variant.effects, channel, np.ones(1)) - bias
        speed = run.rate[joint] / scale
        late = stamped(variant.effects, channel, run.begin) - run.begin
        position[:, place.qposadr[0]] = (run.reading[joint] - bias) / scale + late * speed
        velocity[:, place.dofadr[0]] = speed
    still, sent = np.zeros(count, dtype=int), run.windows(commands)
    # A semi-implicit step takes velocities to lie half a step before positions.
    _, after = rollout([variant], still, position, velocity, sent[:, :1])
    velocity -= 0.5 * (after[:, 1] - velocity)
    moved, _ = rollout([variant], still, position, velocity, sent)
    return {
        f"{joint}.position": run.shown(joint, moved[:, :, place.qposadr[0]], variant.effects)
        for joint, place in places.items()
    }


def _table(content: bytes) -> dict[str, Array]:
    """Return the columns of a CSV file by name."""
    lines = io.StringIO(content.decode())
    names = lines.readline().strip().split(",")
    return dict(zip(names, np.loadtxt(lines, delimiter=",", ndmin=2).T, strict=True))
