"""What is true of a case: its plant, the effects left out, and how much each one changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.law import Law
from experiments.concealed.mechanism import Mechanism
from experiments.concealed.plant import Array, Plant
from experiments.concealed.readings import ideal_readings
from experiments.concealed.simulate import GRID, Motion, Run, moving_state, simulate

HORIZON = 1.0
"""Length of the windows over which effects are measured and predictions scored, s."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One law at one place with its figures."""

    law: Law
    """The law."""
    place: int
    """Index of the joint or body; 0 for the world."""
    figures: Mapping[str, float]
    """Its figures."""
    run: int | None = None
    """The only run in which it acts, or None for all."""
    since: tuple[int, int] | None = None
    """Run and multiple of `GRID` from which on it acts, also in later runs; None: in all."""

    def where(self, mechanism: Mechanism) -> str:
        """Return the name of the part that it acts on."""
        i = self.place
        names = {
            "joint": mechanism.joints[i],
            "actuator": mechanism.actuator(i),
            "sensor": f"{mechanism.joints[i]}.position",
            "body": mechanism.links[i],
            "world": "world",
        }
        return names[self.law.kind]


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The true robot in its true runs."""

    mechanism: Mechanism
    """What the description states."""
    base: Plant
    """The true masses, centres, inertias and gains, without any effect."""
    runs: tuple[Run, ...]
    """Runs as planned, the held-out one last."""
    error: Array
    """RMS error of each reading, shape (joints,)."""
    effects: tuple[Effect, ...] = ()
    """What was left out."""

    def plant(self, run: int, without: int | None = None) -> Plant:
        """Return the true plant at the end of a run, if wanted without the effect of an index."""
        plant = self.base
        for number, effect in enumerate(self.effects):
            begun = effect.since is None or effect.since[0] <= run
            if number != without and effect.run in (None, run) and begun:
                plant = effect.law.apply(plant, effect.place, effect.figures)
        return plant

    @property
    def drift(self) -> float:
        """How much too fast the logger's clock runs, as a share."""
        return sum(float(e.figures.get("drift", 0.0)) for e in self.effects)

    def move(self, run: int, finer: int = 1) -> Motion:
        """Return what happens in a run, with the states at the starts of its windows."""
        starts, plan = window_starts(self.runs[run]), self.runs[run]
        for number, effect in enumerate(self.effects):
            if effect.since is not None and effect.since[0] == run:
                return _changed(
                    self.plant(run, number), self.plant(run), plan, effect.since[1], starts, finer
                )
        return simulate(self.plant(run), plan, save=starts, finer=finer)


def _changed(
    before: Plant, after: Plant, run: Run, since: int, starts: Array, finer: int
) -> Motion:
    """Return what happens in a run at a multiple of `GRID` of which a plant becomes another."""
    marks = np.unique(np.append(starts[starts <= since], since))
    first = simulate(before, run, last=since, save=marks, finer=finer)
    # A delay may reach back to what was sent before.
    done = (run.ticks < since)[:, None]
    sent = replace(run, feed=np.where(done, first.command, run.feed))
    later = simulate(
        after, sent, state=first.saved[-1], first=since, save=starts[starts > since], finer=finer
    )
    early = (np.arange(len(first.q)) <= since * finer)[:, None]
    return replace(
        later,
        q=np.where(early, first.q, later.q),
        v=np.where(early, first.v, later.v),
        reading=np.where(done, first.reading, later.reading),
        command=np.where(done, first.command, later.command),
        saved=np.concatenate([first.saved[: int((starts <= since).sum())], later.saved]),
    )


def window_starts(run: Run) -> Array:
    """Return the starts of the windows of a run, multiples of `GRID`."""
    length = round(HORIZON / GRID)
    return np.arange(0, run.grids - length + 1, length)


def replayed(run: Run, motion: Motion) -> Run:
    """Return the run with the commands that were sent, and no controller."""
    return replace(run, feed=motion.command, reference=np.full_like(motion.command, np.nan))


def changes(truth: Truth, run: int, motion: Motion, without: int) -> Array:
    """Return how much an effect changes the readings of each window, in units of their error.

    The plant without it starts from the true state of every window and gets the commands that were
    sent. A clock that drifts stretches the window instead.

    Returns:
        Mean square over joints and readings of each window, shape (windows,).
    """
    joints = len(truth.error)
    length = round(HORIZON / GRID)
    sent = replayed(truth.runs[run], motion)
    effect = truth.effects[without]
    whole, bare = truth.plant(run), truth.plant(run, without)
    every = round(GRID / motion.step)
    out = []
    for start, state in zip(window_starts(truth.runs[run]), motion.saved, strict=True):
        ticks = sent.ticks[(sent.ticks > start) & (sent.ticks <= start + length)]
        true = ideal_readings(whole, motion.q, ticks, motion.step, joints)
        if "drift" in effect.figures:
            late = start + (ticks - start) / (1 + effect.figures["drift"])
            found = ideal_readings(whole, motion.q, late, motion.step, joints)
        else:
            n = bare.count
            # Half the fineness of the written motion: their difference is far below one reading.
            again = simulate(bare, sent, state=state[:, :n], first=start, last=start + length)
            again.q[:start] = motion.q[: start * every : every, :n]
            found = ideal_readings(bare, again.q, ticks, again.step, joints)
        out.append((((true - found) / truth.error) ** 2).mean())
    return np.array(out)


def effect_to_noise(truth: Truth, motions: Sequence[Motion], without: int) -> float:
    """Return the RMS change of the readings by an effect over their RMS error.

    Over every window of the training runs; of a push, over the windows that it changes.
    """
    effect = truth.effects[without]
    squares = np.concatenate(
        [
            changes(truth, run, motion, without)
            for run, motion in enumerate(motions)
            if effect.run in (None, run)
        ]
    )
    if effect.run is not None:
        squares = squares[squares > 0.1 * squares.max()] if squares.max() > 0 else squares
    return float(np.sqrt(squares.mean()))


def predict(plant: Plant, sent: Run, q: Array, v: Array, finer: int = 1) -> Array:
    """Return the readings that a plant predicts in the windows of a run, shape (ticks, joints).

    Every window starts from given readings and their rates, which hold the sensors' own faults.

    Args:
        plant: The plant.
        sent: The run with the commands that were sent.
        q: Readings at the starts of the windows, shape (windows, joints).
        v: Their rates, same shape.
        finer: Steps in each multiple of `GRID`.
    """
    joints, n = q.shape[1], plant.count
    length = round(HORIZON / GRID)
    out = np.full((len(sent.ticks), joints), np.nan)
    scale, bias = plant.of_joint("scale")[:joints], plant.of_joint("bias")[:joints]
    shift = plant.of_joint("shift")[:joints]
    for start, reading, rate in zip(window_starts(sent), q, v, strict=True):
        speed = rate / scale
        state = moving_state(
            plant,
            np.pad((reading - bias) / scale + shift * speed, (0, n - joints)),
            np.pad(speed, (0, n - joints)),
        )
        inside = (sent.ticks >= start) & (sent.ticks < start + length)
        try:
            again = simulate(
                plant, sent, state=state, first=start, last=start + length, finer=finer
            )
        except BenchmarkError:
            # A plant that diverges predicts no better than what stays where it is.
            out[inside] = reading
            continue
        # Before the window the joints are taken to have moved at the rate given.
        before = np.arange(-start * finer, 0)[:, None] * again.step
        again.q[: start * finer, :joints] = state[0, :joints] + before * speed
        out[inside] = ideal_readings(plant, again.q, sent.ticks[inside], again.step, joints)
    return out
