"""Columns of errors, own parameters and effects along runs, and their Gram matrices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from morph.arrays import Array
from morph.inference.bounded import RANK_TOLERANCE
from morph.inference.columns import Columns, forces_by
from morph.inference.inverse_dynamics import weighed_forces
from morph.inference.level import EffectColumn, all_bounds
from morph.inference.observed import Observed
from morph.inference.quadratic import information, offset
from morph.inference.sticking import sensed
from morph.inference.whitened import Whitened, products, whitened_blocks
from morph.physics.effect import Effect
from morph.sim.threads import each

LEVELS = (1.0, 0.3, 0.1, 0.03)
"""Scales of the missing force, as shares of the likeliest one before effects are added. A set that
explains more leaves less of it: each is scored at the scale under which it is likeliest."""
SHAPES, SCREENED = 2, (1.0, 0.1)
"""How many shapes of an effect are searched, and the scales at which they are the likeliest."""
CHUNK = 256
"""Samples whose forces are multiplied by the mobility at once."""
DRIVE_LAWS = (
    "coulomb_friction", "viscous_friction", "stribeck_friction", "load_dependent_friction",
    "hysteresis", "series_elasticity",
)  # fmt: skip
"""Laws that are also looked for at all driven joints together."""


def effect_columns(grids: Sequence[tuple[Effect, ...]]) -> Iterator[EffectColumn]:
    """Yield the columns of each effect at each shape: one for each strength, after the errors."""
    first = 1
    for effect in (effect for grid in grids for effect in grid):
        end = first + len(effect.strengths)
        yield EffectColumn(effect=effect, place=slice(first, end))
        first = end


def screened(
    own: Columns,
    grids: Sequence[tuple[Effect, ...]],
    runs: Sequence[Observed],
    *,
    by_forces: bool = False,
) -> list[tuple[Effect, ...]]:
    """Return effects at those of their shapes that alone gain most, of laws with many.

    A law of friction keeps all: it is also looked for at one shape at every joint.
    """
    many = [at for at, g in enumerate(grids) if len(g) > SHAPES and g[0].name not in DRIVE_LAWS]
    if not many:
        return list(grids)
    columns = list(effect_columns([grids[at] for at in many]))
    count, trust = len(own.hypothesis.low), information(own.hypothesis)
    point = offset(own.hypothesis, own.point)
    low, high = all_bounds(columns)

    def one(seen: Observed) -> list[tuple[Array, Array]]:
        about = seen.about
        readings, moved = all_columns(own, [grids[at] for at in many], seen)
        levels = (about.leaving(share) for share in SCREENED)
        return [products(about.tangent, each, readings, moved, first=1 + count) for each in levels]

    if by_forces:
        rows, _ = weighed_forces(own, [grids[at] for at in many], runs)
        whole = np.concatenate([run.rows.reshape(-1, run.rows.shape[2]) for run in rows])
        across, square = whole[:, : 1 + count].T @ whole, np.einsum("ij,ij->j", whole, whole)
        sums = [(across / share**2, square / share**2) for share in SCREENED]
    else:
        by_run = each(one, runs)
        sums = [
            (np.sum([f[at][0] for f in by_run], axis=0), np.sum([f[at][1] for f in by_run], axis=0))
            for at in range(len(SCREENED))
        ]
    chosen: set[EffectColumn] = set()
    for across, square in sums:
        along, rest = _without(believed(across, trust, point), square, count)
        with np.errstate(divide="ignore", invalid="ignore"):
            best = np.where(rest > 0.0, np.clip(along / rest, low, high), 0.0)
        gains = best * along - 0.5 * best**2 * rest
        by_effect: dict[str, list[tuple[float, int]]] = {}
        for at, column in enumerate(columns):
            place = slice(column.place.start - 1, column.place.stop - 1)
            by_effect.setdefault(column.label, []).append((float(gains[place].sum()), at))
        for shapes in by_effect.values():
            chosen |= {columns[at] for _, at in sorted(shapes)[-SHAPES:]}
    kept = {id(column.effect) for column in chosen}
    return [
        tuple(shape for shape in grid if id(shape) in kept) if at in many else grid
        for at, grid in enumerate(grids)
    ]


def believed(gram: Array, trust: Array, point: Array) -> Array:
    """Return a Gram matrix with the Gaussian prior of own parameters as further readings.

    Args:
        gram: Of [errors, own parameters, effects]; rows of effects may be left out.
        trust: One over the prior variance of each own parameter, shape (own,).
        point: Their values less the likeliest ones beforehand, same shape.
    """
    whole, own = gram.copy(), slice(1, 1 + len(trust))
    whole[own, own] += np.diag(trust)
    whole[0, own] -= trust * point
    whole[own, 0] -= trust * point
    whole[0, 0] += float(point @ (trust * point))
    return whole


def _without(across: Array, square: Array, own: int) -> tuple[Array, Array]:
    """Return products of errors with columns, and squares of columns, without own parameters."""
    inner = across[1:, 1 : 1 + own]
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    inverse = np.linalg.pinv(inner / np.outer(scale, scale), rcond=RANK_TOLERANCE, hermitian=True)
    unit = across[1:] / scale[:, None]
    fitted = inverse @ unit
    rest = square - np.einsum("ij,ij->j", unit, fitted)
    rest[rest < RANK_TOLERANCE * square] = 0.0
    return (across[0] - unit[:, 0] @ fitted)[1 + own :], rest[1 + own :]


def all_columns(
    own: Columns, grids: Sequence[tuple[Effect, ...]], seen: Observed
) -> tuple[Array, Array]:
    """Return the changes of readings and accelerations by [errors, entries of a point, effects].

    Shapes (samples, channels, columns) and (samples, dofs, columns).
    """
    about = seen.about
    motion = sensed(list(seen.motion.joints), seen.motion, about)
    effects = own.hypothesis.effects_at(own.point)
    first, shown = own.along(seen)
    samples, dofs, count = first.shape
    mobility = about.tangent.mobility
    total = count + sum(len(effect.strengths) for grid in grids for effect in grid)
    moved = np.zeros((samples, dofs, total))
    readings = np.zeros((samples, shown.shape[1], total))
    moved[:, :, :count], readings[:, :, :count] = first, shown
    own_columns = count
    for shapes in grids:
        last = count + sum(len(effect.strengths) for effect in shapes)
        if shapes[0].kind == "sensor":
            changes = [effect.reading_regressor(motion) for effect in shapes]
            readings[:, :, count:last] = np.concatenate(changes, axis=2)
        else:
            moved[:, :, count:last] = forces_by(shapes, motion, effects)
        count = last
    for begin in range(0, samples, CHUNK):
        # Forces of all effects at once, in place: products of a few columns each cost ten times it.
        some = slice(begin, begin + CHUNK)
        moved[some, :, own_columns:] = mobility[some] @ moved[some, :, own_columns:]
    return readings, moved


def whitened_levels(
    own: Columns,
    grids: Sequence[tuple[Effect, ...]],
    runs: Sequence[Observed],
    blocks: int,
    *,
    shares: Sequence[float] = LEVELS,
) -> list[list[Whitened]]:
    """Return the Gram matrix of [errors, entries of the point, effects], by level and by fold."""

    def one(seen: Observed) -> list[list[Whitened]]:
        about = seen.about
        readings, moved = all_columns(own, grids, seen)
        return [
            whitened_blocks(about.tangent, about.leaving(share), readings, moved, blocks=blocks)
            for share in shares
        ]

    by_run = each(one, runs)
    return [[fold for result in by_run for fold in result[at]] for at in range(len(shares))]
