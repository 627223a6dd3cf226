"""When a robot changed: the run and the time from which on one law acts otherwise than before."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.inference.change_search import (
    ChangeSearch,
    ChangingLaw,
    Level,
    LikeliestChange,
    changing_laws,
)
from morph.inference.columns import Columns
from morph.inference.design_matrix import all_columns, effect_columns, screened
from morph.inference.dictionary import dictionary
from morph.inference.explained import CERTAIN
from morph.inference.refit import Refit
from morph.inference.search import Prior
from morph.inference.whitened import Whitened, whitened, whitened_blocks
from morph.physics.body.external_push import ExternalPush
from morph.physics.effect import Effect
from morph.sim.threads import each

COARSE, FINE, AROUND = 0.25, 0.025, 1.0
"""Seconds between times that are tried, at first and about the likeliest, and how far about it."""
LEAST = 2.0
"""Least seconds before a change, and after it: how a run began is not known."""
SHARES = (1.0, 0.1, 0.01)
"""Scales of the missing force, as shares of the likeliest: what is explained leaves less of it."""

Grids = Sequence[tuple[Effect, ...]]


def likeliest_change(base: Refit, known: Sequence[Effect], prior: Prior) -> LikeliestChange | None:
    """Return the likeliest change of one law that gains 20 nats at least, else None.

    Columns of each law of the dictionary act from one time on, or until then, beside own parameters
    and the laws that were found; these may be of other strengths after it. The change does not last
    where it is a push in one run, or has no evidence more than a second from it.

    Source: Willsky and Jones 1976, IEEE Transactions on Automatic Control 21(1), 108-112 (the
    generalized likelihood ratio).

    Args:
        base: The description with the laws that were found, refitted. Its runs are in the order in
            which they were recorded.
        known: Effects whose fixed parameters are known.
        prior: Prices of laws.
    """
    own, taken = Columns.of(base.hypothesis, base.point), {e.label for e in base.effects}
    every = dictionary(base.hypothesis.robot, base.runs, known)
    grids = [grid for grid in every if grid[0].label not in taken]
    grids = screened(own, grids, base.runs)
    stretches = _Stretches.of(base, own, grids)
    result = stretches.search(prior).likeliest()
    if result is None or result.gain < 0.0:
        return None
    # What shows only about that time is no lasting law, but a push that no shape fits.
    if isinstance(result.after, ExternalPush):
        names = [run.motion.run for run in base.runs]
        result = replace(result, run=names.index(result.after.run), lasts=False)
        return result if result.gain >= CERTAIN else None
    away = stretches.search(prior, result).likeliest()
    if away is None or away.gain < 0.0:
        return replace(result, lasts=False) if result.gain >= CERTAIN else None
    grids = [grid for grid in grids if grid[0].label == result.label]
    result = _exact(base, own, grids, prior, result).likeliest()
    return result if result is not None and result.gain >= CERTAIN else None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Stretches:
    """Inner products of columns over stretches of all runs, each given all readings before it.

    They are as if a law had always acted: one filter serves all times, and what a law has moved
    just after it begins is a little off.
    """

    base: Refit
    laws: Sequence[ChangingLaw]
    starts: Sequence[tuple[int, float]]
    """Run and time, s, at which each begins."""
    totals: Sequence[Array]
    """By level of the missing force: of [errors, entries], (stretches, entries + 1, the same)."""
    acts: Sequence[Sequence[Array]]
    """By level and law: of its columns with [errors, entries, these], (stretches, columns, ...)."""
    logarithms: Sequence[Array]
    """By level, of the determinant of the readings' covariance, shape (stretches,)."""

    @classmethod
    def of(cls, base: Refit, own: Columns, grids: Grids) -> _Stretches:
        """Return the products of all laws, over stretches of a quarter of a second."""
        lasts = [float(run.motion.time[-1]) for run in base.runs]
        counts = [max(1, round(last / COARSE)) for last in lasts]
        laws, size = list(changing_laws(base, list(effect_columns(grids)))), 1 + len(base.point)
        rows = [np.ix_(law.place, np.append(np.arange(size), law.place)) for law in laws]

        def one(at: int) -> list[tuple[Array, Array, list[Array]]]:
            about = base.runs[at].about
            columns = all_columns(own, grids, base.runs[at])
            results = []
            for share in SHARES:
                level = about.leaving(share)
                blocks = whitened_blocks(about.tangent, level, *columns, blocks=counts[at])
                total = np.array([block.gram[:size, :size] for block in blocks])
                acts = [np.array([block.gram[row] for block in blocks]) for row in rows]
                results.append((total, np.array([block.logarithm for block in blocks]), acts))
            return results

        by_level = list(zip(*each(one, range(len(lasts))), strict=True))
        return cls(
            base=base,
            laws=laws,
            starts=[
                (run, block * lasts[run] / count)
                for run, count in enumerate(counts)
                for block in range(count)
            ],
            totals=[np.concatenate([run[0] for run in runs]) for runs in by_level],
            acts=[
                [np.concatenate([run[2][at] for run in runs]) for at in range(len(laws))]
                for runs in by_level
            ],
            logarithms=[np.concatenate([run[1] for run in runs]) for runs in by_level],
        )

    def search(self, prior: Prior, apart: LikeliestChange | None = None) -> ChangeSearch:
        """Return a search over all laws and times.

        Args:
            prior: Prices of laws.
            apart: Of this change alone, by the readings that are more than a second from it.
        """
        runs, begins = (np.array(every) for every in zip(*self.starts, strict=True))
        kept, laws = np.ones(len(begins), dtype=bool), list(range(len(self.laws)))
        allowed = np.arange(len(begins)) >= math.ceil(LEAST / COARSE)
        allowed &= allowed[::-1]
        if apart is not None:
            kept = (runs != apart.run) | (np.abs(begins - apart.time) > AROUND)
            allowed = (runs == apart.run) & (begins == apart.time)
            laws = [at for at in laws if self.laws[at].label == apart.label]
        levels = []
        for total, acts, logarithm in zip(self.totals, self.acts, self.logarithms, strict=True):
            sides = []
            for at in laws:
                parts = np.where(kept[:, None, None], acts[at], 0.0)
                since = np.cumsum(parts[::-1], axis=0)[::-1]
                if self.laws[at].passing:
                    since = np.broadcast_to(since[:1], since.shape)
                # What acts until a time is what acts always less what acts from then on.
                sides.append([since, since[:1] - since][: len(self.laws[at].sides)])
            levels.append(
                Level(
                    total=total[kept].sum(axis=0),
                    logarithm=float(logarithm[kept].sum()),
                    acts=sides,
                )
            )
        return ChangeSearch(
            base=self.base, prior=prior, laws=[self.laws[at] for at in laws], levels=levels,
            starts=self.starts, allowed=allowed,
        )  # fmt: skip


def _exact(
    base: Refit, own: Columns, grids: Grids, prior: Prior, near: LikeliestChange
) -> ChangeSearch:
    """Return a search over one law and times about a likely one, with columns that begin there."""
    every = list(changing_laws(base, list(effect_columns(grids))))
    laws, size = [law for law in every if law.label == near.label], 1 + len(base.point)
    seen = base.runs[near.run]
    last = float(seen.motion.time[-1])
    times = np.arange(max(0.0, near.time - AROUND), min(last, near.time + AROUND), FINE)
    if near.after.kind == "sensor":
        # A reading jumps from one to the next: a step of a motion's forces is smooth, one of a
        # sensor's law a reading too early is off by all of the jump.
        read = seen.motion.time[seen.run.valid.any(axis=1)]
        times = read[np.abs(read - near.time) < 2.0 * COARSE]
    times = np.append(0.0, times)

    allowed = np.ones(len(times), dtype=bool)
    if near.run == 0:
        allowed &= times >= LEAST
    if near.run == len(base.runs) - 1:
        allowed &= times <= last - LEAST

    def one(at: int) -> list[list[Whitened]]:
        """Return, by law and level, products of [errors, entries, the law from each time on]."""
        about, seen = base.runs[at].about, base.runs[at]
        every, result = all_columns(own, grids, seen), []
        since = times if at == near.run else times[:1]
        acts = (seen.motion.time[:, None] >= since).astype(float)
        for law in laws:
            readings, moved = (
                np.concatenate(
                    [
                        whole[:, :, :size],
                        np.einsum("sdc,st->sdtc", whole[:, :, law.place], acts).reshape(
                            *whole.shape[:2], -1
                        ),
                    ],
                    axis=2,
                )
                for whole in every
            )
            result.append(
                [whitened(about.tangent, about.leaving(share), readings, moved) for share in SHARES]
            )
        return result

    by_run = each(one, range(len(base.runs)))
    levels = []
    for level in range(len(SHARES)):
        whole = [run[0][level] for run in by_run]
        levels.append(
            Level(
                total=np.sum([each.gram[:size, :size] for each in whole], axis=0),
                logarithm=sum(each.logarithm for each in whole),
                acts=[
                    _sides(law, [run[at][level].gram for run in by_run], size, near.run, len(times))
                    for at, law in enumerate(laws)
                ],
            )
        )
    return ChangeSearch(
        base=base, prior=prior, laws=laws, levels=levels,
        starts=[(near.run, time) for time in times.tolist()],
        allowed=allowed,
    )  # fmt: skip


def _sides(
    law: ChangingLaw, grams: Sequence[Array], size: int, run: int, times: int
) -> list[Array]:
    """Return products of a law's columns from each time of a run on and, if asked, until then."""
    wide = len(law.place)
    full = slice(size, size + wide)

    def always(gram: Array) -> Array:
        return np.concatenate([gram[full, :size], gram[full, full]], axis=1)

    results = []
    for until in law.sides:
        others = grams[:run] if until else grams[run + 1 :]
        rest = np.sum([always(gram) for gram in others], axis=0) if others else 0.0
        rows = []
        for time in range(times):
            since = slice(size + time * wide, size + (time + 1) * wide)
            gram = grams[run]
            along, inner = gram[since, :size], gram[since, since]
            if until:
                across = gram[full, since]
                along = gram[full, :size] - along
                inner = gram[full, full] - across - across.T + inner
            rows.append(np.concatenate([along, inner], axis=1) + rest)
        results.append(np.array(rows))
    return results
