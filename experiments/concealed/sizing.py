"""Sizes of effects, found so that each changes the readings by a wanted multiple of their error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.law import Law, Setting
from experiments.concealed.simulate import Motion
from experiments.concealed.truth import Effect, Truth, changes, effect_to_noise

WEAKEST = 2.0
"""Smallest effect-to-noise ratio of a case."""
FINEST = 2
"""Steps of the integrator in each multiple of `GRID`, for what is written."""


class NoSize(BenchmarkError):
    """A law cannot be seen at a place, whatever its size."""


def size_for(truth: Truth, law: Law, setting: Setting, run: int | None, target: float) -> Truth:
    """Return the truth with one more effect of about the wanted effect-to-noise ratio.

    Measured with the effects so far, over the first two training runs, or over the run of a push.

    Raises:
        NoSize: Even the largest size changes too little, or the motion diverges.
    """
    least = law.least(setting)
    size, best = float(np.clip(0.05, least, law.largest)), None
    if least > law.largest:
        raise NoSize(f"{law.name} is below what may be wrong", where="sizing", fix="redraw")
    for _ in range(6):
        effect = Effect(law=law, place=setting.place, figures=law.figures(size, setting), run=run)
        tried = replace(truth, effects=(*truth.effects, effect))
        try:
            found = _measure(tried, run)
        except NoSize:
            raise
        except BenchmarkError:
            size *= 0.3
            if size < least:
                break
            continue
        if best is None or abs(np.log(found / target)) < abs(np.log(best[0] / target)):
            best = found, tried
        if abs(np.log(found / target)) < 0.2:
            break
        size, before = (
            float(
                np.clip(
                    size * np.clip(target / max(found, 1e-9), 0.1, 10) ** 0.9, least, law.largest
                )
            ),
            size,
        )
        if size == before:
            break
    if best is None or best[0] < WEAKEST:
        raise NoSize(f"{law.name} cannot be seen", where="sizing", fix="redraw")
    return best[1]


def _measure(truth: Truth, run: int | None) -> float:
    wanted = (0, 1) if run is None else (run,)
    moved = {each: truth.move(each) for each in wanted}
    last = len(truth.effects) - 1
    squares = [_square(truth, each, motion, last) for each, motion in moved.items()]
    return max(float(np.sqrt(np.mean(squares))), 1e-9)


def _square(truth: Truth, run: int, motion: Motion, without: int) -> float:
    """Return the mean square change in one run, of a push over the windows that it changes."""
    squares = changes(truth, run, motion, without)
    if truth.effects[without].run is not None and squares.max() > 0:
        squares = squares[squares > 0.1 * squares.max()]
    return float(squares.mean())


def settle(truth: Truth, *, checked: bool) -> tuple[Truth, tuple[Motion, ...], tuple[float, ...]]:
    """Return the truth, its motions at the finest step, and the ratio of every effect.

    Raises:
        NoSize: An effect is too weak beside the others, or the motion diverges.
    """
    try:
        motions = tuple(truth.move(run, FINEST) for run in range(len(truth.runs)))
        ratios = tuple(
            effect_to_noise(truth, motions[:-1], number) for number in range(len(truth.effects))
        )
    except NoSize:
        raise
    except BenchmarkError as error:
        raise NoSize("the motion diverges", where="settle", fix="redraw") from error
    span = truth.mechanism.span
    far = max(
        float((np.abs(motion.q[:, : len(span)] - truth.mechanism.home) / span).max())
        for motion in motions
    )
    if far > 8.0:
        raise NoSize(f"a joint strays by {far:.0f} spans", where="settle", fix="redraw")
    if checked and any(ratio < WEAKEST for ratio in ratios):
        raise NoSize("an effect hides behind another", where="settle", fix="redraw")
    return truth, motions, ratios
