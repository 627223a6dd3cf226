"""What was given to be held against each other: recordings, models, and what a diagnosis says."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np

from morph.app.viewer.figure import Figure, figure
from morph.app.viewer.mismatch import loose, rollouts
from morph.app.viewer.mismatch.diagnosed import Diagnosed, DiagnosedFinding, Event
from morph.app.viewer.mismatch.missing import clearest, joint_of, missing
from morph.app.viewer.mismatch.poses import poses, span, untold
from morph.app.viewer.mismatch.window import CORRECTED, DESCRIBED, Ask, MismatchModel, Missing, Take
from morph.app.viewer.mismatch.windows import windows
from morph.app.viewer.mismatch.worst import STRETCH, worst_of, worst_stretches
from morph.body.robot import Robot
from morph.errors import DiagnosisError, MorphError
from morph.model.derived_channels import by_effort, told_zero
from morph.model.episodes import Episode, episode, step_for
from morph.model.pieces import gaps, part
from morph.model.split import split
from morph.physics.effect import Effect
from morph.record.recording import Recording

HORIZON = 1.0
"""Seconds after which a simulation is restarted, where no diagnosis says it."""
KEPT = 24
"""Takes that are kept for whoever asks next; the oldest go first."""
DESCRIBED_COLOUR, CORRECTED_COLOUR = (0, 114, 178), (0, 158, 115)


class MismatchCase:
    """Recordings of one robot and the models that they are held against.

    All that it gives is shared by everybody who looks, and computed once.

    Args:
        robot: The robot as described.
        recordings: What it did, at least one.
        diagnosed: What a diagnosis says of them.
        around: Effects of the world that it is in.
    """

    def __init__(
        self,
        robot: Robot,
        recordings: tuple[Recording, ...],
        diagnosed: Diagnosed | None = None,
        around: tuple[Effect, ...] = (),
    ) -> None:
        """Lay nothing out yet."""
        self.robot, self.recordings, self.diagnosed = robot, recordings, diagnosed
        self.figure: Figure = figure(robot, around)
        # What is bolted to the world is the recording's: drawn twice it would flicker.
        self.ghost: Figure = replace(
            self.figure,
            shapes=tuple(
                each for each in self.figure.shapes if self.figure.model.body_weldid[each.body]
            ),
        )
        self.models = _models(robot, diagnosed, around)
        self._takes: dict[Ask, Take] = {}
        self._laid: dict[int, tuple[Episode | None, str]] = {}
        self._lock = threading.RLock()

    @property
    def notes(self) -> tuple[str, ...]:
        """What does not fit between the diagnosis and what else was given, in words."""
        result = self.diagnosed
        if result is None:
            return ()
        notes = []
        if result.robot_sha256 != self.robot.sha256:
            notes.append(
                "The diagnosis was made of another version of this description: its joints and "
                "actuators are the same, its figures may not be."
            )
        other = [
            recording.name
            for recording in self.recordings
            if result.recordings_sha256.get(recording.name, recording.sha256) != recording.sha256
        ]
        if other:
            notes.append(f"The diagnosis was made of other files called {', '.join(other)}.")
        if result.corrected is None:
            notes.append("The diagnosis holds no corrected model.")
        return tuple(notes)

    @property
    def found(self) -> tuple[DiagnosedFinding, ...]:
        """What the diagnosis found."""
        return () if self.diagnosed is None else self.diagnosed.findings

    def events(self, take: Take) -> tuple[Event, ...]:
        """Return the changes and pushes of a take, their times s since its window began."""
        given = () if self.diagnosed is None else self.diagnosed.events
        mine = (replace(e, time=e.time - take.start) for e in given if e.episode == take.name)
        return tuple(event for event in mine if 0.0 <= event.time <= take.seconds)

    @property
    def findings(self) -> tuple[Effect, ...]:
        """The effects that it found."""
        return tuple(each.effect for each in self.found)

    def moment_of(self, result: DiagnosedFinding, take: Take) -> float | None:
        """Return when a finding shows most in a take, s; None if it cannot be told."""
        missed = take.missing.get(DESCRIBED)
        if missed is None:
            return None
        return clearest(
            missed, result.effect.label, joint_of(result.effect, self.robot), self.robot
        )

    @property
    def horizon(self) -> float:
        """Seconds after which a simulation is restarted, if it is."""
        given = None if self.diagnosed is None else self.diagnosed.horizon
        return HORIZON if given is None else given

    def windows(self, index: int) -> tuple[tuple[float, float], ...]:
        """Return the windows of a recording, s from its start."""
        begin, end = span(self.recordings[index], self.robot)
        return windows(end - begin)

    def never_seen(self, index: int) -> bool:
        """Return whether the diagnosis held a recording, or the last quarter of it, out."""
        result = self.diagnosed
        return result is not None and self.recordings[index].name in result.held_out

    def unseen_from(self, index: int) -> float:
        """Return from when on, s, no model was fitted to a recording that was held out."""
        if self.diagnosed is None or not self.diagnosed.by_time:
            return 0.0
        recording = self.recordings[index]
        fitted = split([recording]).train[0]
        return span(fitted, self.robot)[1] - span(recording, self.robot)[0]

    def take(self, ask: Ask) -> Take:
        """Return what is shown of a recording; the first time it is computed.

        Raises:
            MorphError: It cannot be simulated at all.
        """
        result = self._takes.get(ask)
        # Nobody waits for what another computes, unless it is the same.
        if result is not None:
            return result
        with self._lock:
            if ask not in self._takes:
                while len(self._takes) >= KEPT:
                    self._takes.pop(next(iter(self._takes)))
                self._takes[ask] = self._taken(ask)
            return self._takes[ask]

    def laid(self, index: int) -> tuple[Episode | None, str]:
        """Return a recording as a diagnosis would read it, or None and why it cannot."""
        if index not in self._laid:
            recording = self._driven(index)
            try:
                self._laid[index] = episode(recording, self.robot, self._step()), ""
            except MorphError as error:
                self._laid[index] = None, error.what
        return self._laid[index]

    def _driven(self, index: int) -> Recording:
        """Return a recording that tells every actuator something."""
        return told_zero(by_effort(self.recordings[index], self.robot), self.robot)

    def _step(self) -> float:
        """Return the seconds a step, as the diagnosis chose it where these are its recordings."""
        train = () if self.diagnosed is None else self.diagnosed.train
        lines = [each for each in self.recordings if not untold(each, self.robot)]
        fitted = [each for each in lines if each.name in train]
        return step_for(fitted or lines, self.robot)

    def _taken(self, ask: Ask) -> Take:
        recording = self._driven(ask.episode)
        begin, end = self.windows(ask.episode)[ask.window]
        zero = span(recording, self.robot)[0]
        horizon, statement = _horizon(ask.horizon, end - begin)
        measured = poses(recording, self.robot, self.figure.model, zero + begin, end - begin)
        take = Take(
            ask=ask,
            name=recording.name,
            start=begin,
            seconds=end - begin,
            horizon=horizon,
            measured=measured,
            simulated={},
            traces=(),
            notes=(*statement, *(f"{note.where}: {note.what}" for note in recording.notes)),
        )
        laid, why = (None, "") if untold(recording, self.robot) else self.laid(ask.episode)
        if laid is not None:
            try:
                # The last reading is one of the part.
                return self._scored(take, part(laid, begin, end + 0.25 * laid.step))
            except DiagnosisError as error:
                why = error.what
        return self._loosely(take, recording, zero + begin, why)

    def _scored(self, take: Take, laid: Episode) -> Take:
        segments, predicted = rollouts.simulated(self.models, laid, take.horizon)
        joints = [self.figure.model.joint(each.name) for each in self.robot.joints]
        at = np.concatenate([j.qposadr[0] + np.arange(len(j.qpos0)) for j in joints])
        simulated = {}
        for name, readings in predicted.items():
            simulated[name] = take.measured.copy()
            simulated[name][:, at] = rollouts.pictured(segments, readings, take.measured[:, at])
        stretch = min(STRETCH if take.horizon is None else take.horizon, 0.5 * take.seconds)
        return replace(
            take,
            simulated=simulated,
            traces=rollouts.traced(self.robot, segments, predicted),
            missing=self._missing(laid),
            worst=self._stretches(take) or worst_stretches(self.models[0], laid, stretch),
            notes=(*take.notes, *_gaps(laid)),
        )

    def _missing(self, laid: Episode) -> dict[str, Missing]:
        return {model.name: missing(model, laid, self.findings) for model in self.models}

    def _stretches(self, take: Take) -> tuple[tuple[float, float], ...]:
        """Return the diagnosis' worst stretches that lie in a window, if they are shorter."""
        if self.diagnosed is None or not self.never_seen(take.ask.episode):
            return ()
        results = [
            (each.begin + each.start - take.start, each.begin + each.end - take.start)
            for each in self.diagnosed.stretches
            if each.recording == take.name and 0.0 < each.end - each.start < 0.5 * take.seconds
        ]
        return tuple(each for each in results if each[0] >= 0.0 and each[1] <= take.seconds)

    def _loosely(self, take: Take, recording: Recording, begin: float, why: str) -> Take:
        notes = [f"What force is missing cannot be told: {why}."] if why else []
        still = untold(recording, self.robot)
        if still:
            notes.append(
                "What force is missing cannot be told, for the recording does not say where "
                f"{', '.join(still)} is; shown as described."
            )
        simulated = {}
        for model in self.models:
            simulated[model.name], stopped = loose.simulated(
                model, recording, take.measured, begin, take.horizon
            )
            if stopped:
                notes.append(f"The simulation {model.title} stopped {stopped}.")
        traces = loose.traced(self.robot, self.figure.model, recording, take.measured, simulated)
        return replace(
            take,
            simulated=simulated,
            traces=traces,
            worst=worst_of(traces, take.seconds),
            notes=(*take.notes, *notes),
        )


def _models(
    robot: Robot, diagnosed: Diagnosed | None, around: tuple[Effect, ...]
) -> tuple[MismatchModel, ...]:
    described = MismatchModel(
        name=DESCRIBED,
        title="as described",
        robot=robot,
        effects=around,
        colour=DESCRIBED_COLOUR,
    )
    if diagnosed is None or diagnosed.corrected is None:
        return (described,)
    corrected = MismatchModel(
        name=CORRECTED,
        title="corrected",
        robot=diagnosed.corrected,
        effects=(*around, *diagnosed.effects),
        colour=CORRECTED_COLOUR,
    )
    return described, corrected


def _horizon(requested: float | None, seconds: float) -> tuple[float | None, tuple[str, ...]]:
    if requested is None or requested <= seconds:
        return requested, ()
    return None, (
        f"The recording lasts {seconds:.3g} s, less than {requested:g} s: the simulation is not "
        "restarted.",
    )


def _gaps(laid: Episode) -> tuple[str, ...]:
    return tuple(
        f"There is no reading for {end - begin:.3g} s after {begin:.3g} s."
        for begin, end in gaps(laid.time)
    )
