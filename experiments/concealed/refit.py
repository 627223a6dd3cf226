"""How much of an effect is left once the description's own parameters are refitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from experiments.concealed.plant import Array, Plant
from experiments.concealed.readings import ideal_readings
from experiments.concealed.simulate import GRID, Motion, simulate
from experiments.concealed.truth import HORIZON, Truth, replayed, window_starts

WINDOWS = 8
"""Windows that are looked at, spread over the training runs."""
MOST_ROWS = 40
"""Readings of each window that are looked at."""


def ratios_after_refit(
    truth: Truth, motions: Sequence[Motion], vary: Mapping[str, float]
) -> tuple[float, ...]:
    """Return what an effect still changes when the own parameters have taken what they can.

    Linear least squares of the change on the derivatives by every mass, centre, inertia and gain,
    each with a normal prior of standard deviation vary / sqrt(3), that of the uniform error. The
    result is the RMS of what is left, in units of the readings' error.

    Args:
        truth: The truth.
        motions: Motions of the training runs, with the states at their windows' starts.
        vary: Fraction by which each kind of figure may be wrong.
    """
    if not truth.effects:
        return ()
    chosen = _windows(truth)
    columns = []
    for kind, fraction in vary.items():
        for place in range(len(truth.error)):
            if kind == "gain" and place not in truth.mechanism.driven:
                continue
            spread = fraction / np.sqrt(3)
            moved = [
                _shown(truth, run, motions[run], number, _nudged(truth.plant(run), kind, place))
                for run, number in chosen
            ]
            columns.append((kind, place, spread, np.concatenate(moved)))
    base = np.concatenate(
        [_shown(truth, run, motions[run], number, truth.plant(run)) for run, number in chosen]
    )
    J = np.column_stack([spread * (each - base) / STEP for _, _, spread, each in columns])
    gram = J.T @ J + np.eye(J.shape[1])
    out = []
    for without in range(len(truth.effects)):
        bare = [
            _shown(truth, run, motions[run], number, truth.plant(run, without))
            for run, number in chosen
        ]
        change = base - np.concatenate(bare)
        share = np.linalg.solve(gram, J.T @ change)
        out.append(float(np.sqrt(((change - J @ share) ** 2).mean())))
    return tuple(out)


STEP = 1e-3
"""Relative step of the derivatives."""


def _windows(truth: Truth) -> list[tuple[int, int]]:
    """Return (run, window) pairs; all windows that a push touches are among them."""
    every = [
        (run, number)
        for run in range(len(truth.runs) - 1)
        for number in range(len(window_starts(truth.runs[run])))
    ]
    chosen = {every[int(i)] for i in np.linspace(0, len(every) - 1, WINDOWS)}
    for effect in truth.effects:
        if effect.run is not None:
            at = int(effect.figures["start"] / HORIZON)
            chosen.add((effect.run, min(at, len(window_starts(truth.runs[effect.run])) - 1)))
    return sorted(chosen)


def _nudged(plant: Plant, kind: str, place: int) -> Plant:
    """Return a plant one of whose figures is larger by `STEP` of itself."""
    factor = 1 + STEP
    if kind == "mass":
        return plant.with_body(place, mass=plant.of_body("mass")[place] * factor)
    if kind == "com":
        return plant.with_com(place, plant.com[place] * factor)
    if kind == "inertia":
        return plant.with_inertia(place, plant.inertia[place] * factor)
    return plant.with_joint(place, gain=plant.of_joint("gain")[place] * factor)


def _shown(truth: Truth, run: int, motion: Motion, number: int, plant: Plant) -> Array:
    """Return the readings of a window over their error, from its true start, flat."""
    sent = replayed(truth.runs[run], motion)
    start, n = int(window_starts(sent)[number]), plant.count
    last = start + round(HORIZON / GRID)
    every = round(GRID / motion.step)
    # Only the window's own ticks and those that a delay may reach are needed.
    ticks = sent.ticks[(sent.ticks > start) & (sent.ticks <= last)]
    ticks = ticks[:: max(1, len(ticks) // MOST_ROWS)]
    short = replace(sent, grids=last)
    again = simulate(plant, short, state=motion.saved[number][:, :n], first=start, last=last)
    again.q[:start] = motion.q[: start * every : every, :n]
    shown = ideal_readings(plant, again.q, ticks, again.step, len(truth.error))
    return np.asarray(shown / truth.error).ravel()
