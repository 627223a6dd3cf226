"""The dictionary of effects at their places and shapes, and their columns about a refit."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from contextlib import suppress
from dataclasses import replace

import numpy as np

from morph.body.robot import Robot
from morph.errors import EffectError
from morph.inference.columns import Columns
from morph.inference.design_matrix import (
    DRIVE_LAWS,
    LEVELS,
    believed,
    effect_columns,
    screened,
    whitened_levels,
)
from morph.inference.inverse_dynamics import force_levels
from morph.inference.level import EffectColumn, WhitenedLevel
from morph.inference.observed import Observed
from morph.inference.quadratic import information, offset
from morph.inference.refit import Refit
from morph.inference.search import BeamSearch, Prior
from morph.inference.streaming import Streaming, streams
from morph.physics import EFFECTS
from morph.physics.body.tether import Tether
from morph.physics.effect import Effect
from morph.physics.fluid.thrust import Thrust
from morph.physics.fluid.wet import WetEffect
from morph.physics.motion import Motion
from morph.record.noise import MOVES

ODDS = 3.0
"""Prior log odds against one more effect, nats."""
RARE = 10.0
"""Prior log odds against a cable, and a fluid's force on a robot that nobody puts into water,
nats."""
VISCOUS = "viscous_friction"
"""The one that may stand beside each of the others."""
SLACK = 1e-9
"""By how much bounds are widened, so that equal ones leave an interval."""


def search_beside(
    base: Refit,
    known: Sequence[Effect],
    prior: Prior | None,
    blocks: int,
    *,
    by_forces: bool = False,
) -> BeamSearch:
    """Return a search for effects to add to a refitted hypothesis.

    Args:
        base: The refit.
        known: Effects whose fixed parameters are known.
        prior: That of an earlier search; None to make it.
        blocks: Into how many folds each run is divided.
        by_forces: Whether columns explain forces of inverse dynamics, in the place of readings.
    """
    hypothesis, point, runs = base.hypothesis, base.point, base.runs
    taken = {effect.label for effect in base.effects}
    grids = [
        grid for grid in dictionary(hypothesis.robot, runs, known) if grid[0].label not in taken
    ]
    joints, wet = set(hypothesis.robot.driven), _in_water(hypothesis.robot, known)
    own = Columns.of(hypothesis, point)
    whole = _prior(grids, joints, wet=wet)
    if prior is not None:
        # A push may stand out only once other effects are found.
        whole = replace(prior, alone={**whole.alone, **prior.alone})
    grids = screened(own, grids, runs, by_forces=by_forces)
    if wet:
        grids += streams(grids)
    if by_forces:
        levels = force_levels(own, grids, runs, blocks, LEVELS)
    else:
        levels = whitened_levels(own, grids, runs, blocks)
    columns = tuple(effect_columns(grids))
    trust, at = information(hypothesis), offset(hypothesis, point)
    return BeamSearch(
        columns=columns,
        prior=whole,
        found=base.effects,
        groups=tuple(_drive_laws(columns, joints)),
        needs=_drags_of_streams(columns),
        levels=tuple(
            WhitenedLevel(
                gram=believed(np.sum([fold.gram for fold in folds], axis=0), trust, at),
                logarithm=sum(fold.logarithm for fold in folds),
                low=hypothesis.low - point - SLACK,
                high=hypothesis.high - point + SLACK,
                folds=tuple(fold.gram for fold in folds),
            )
            for folds in levels
        ),
        # None where no joint ever slips.
        readings=max(1, sum(fold.readings for fold in levels[0])),
    )


def dictionary(
    robot: Robot, runs: Sequence[Observed], known: Sequence[Effect]
) -> Iterator[tuple[Effect, ...]]:
    """Yield each effect at each place, as a tuple over the shapes of its grid."""
    motions = [run.motion for run in runs]
    longest = max(motions, key=lambda motion: len(motion.time))
    # Rollouts are compared with positions: they would not show laws of sensors of velocity, which
    # not all runs may have.
    channels = runs[0].run.measurement.channels
    read = np.any([run.run.valid[:, : len(channels)].any(axis=0) for run in runs], axis=0)
    measured = {name for name, there in zip(channels, read, strict=True) if there}
    by_label = {effect.label: effect for effect in known}
    joints = [joint.name for joint in robot.joints if joint.kind in {"hinge", "slide"}]
    # A law at a joint that follows another is one at its leader.
    still = {joint.name for joint in robot.joints if joint.mimic is not None}
    still |= {name for name in joints if not any(_moves(name, run) for run in runs)}
    # Links that are welded to another move as one with it: it stands for them.
    jointed = {joint.link for joint in robot.joints}
    jointed |= {effect.where for effect in known}
    idle = {
        "body": {link.name for link in robot.links if link.name not in jointed},
        "joint": still,
        "actuator": {each.name for each in robot.actuators if each.joint in still},
    }
    for kind in EFFECTS:
        places = kind.places(robot) if kind.strengths else ()
        places = tuple(place for place in places if place not in idle.get(kind.kind, ()))
        for place in places[:1] if kind.everywhere else places:
            if kind.kind != "sensor" or place in measured:
                with suppress(EffectError):  # It needs what the description does not tell.
                    effect = kind.at(place)
                    effect = by_label.get(effect.label, effect)
                    effect.regressor(longest)
                    most = max(effect.extent(motion) for motion in motions)
                    full = [m for m in motions if effect.extent(m) == most]
                    seen = motions if kind.of_a_run else [max(full, key=lambda m: len(m.time))]
                    if shapes := [shape for each in seen for shape in _shapes(effect, each)]:
                        yield tuple(shapes)


def _moves(joint: str, seen: Observed) -> bool:
    """Return whether a joint was not read, or its readings change by more than their noise."""
    at = seen.motion.channels[f"{joint}.position"]
    if seen.run.guess[seen.motion.joints[joint]] > 0.0:
        return True
    readings = seen.run.reading[seen.run.valid[:, at], at]
    return len(readings) > 0 and float(np.ptp(readings)) > MOVES * float(seen.run.noise[at])


def _shapes(effect: Effect, motion: Motion) -> tuple[Effect, ...]:
    """Return the effect at a few values of the parameters in which it is not linear."""
    if type(effect).command is Effect.command:
        return effect.shapes(motion)
    # A filter of a command is linear in its time constant only while that is short.
    return tuple(
        replace(effect, **{known.name: value})  # type: ignore[type-var]
        for known in effect.parameters()
        for value in known.scan
    )


def _in_water(robot: Robot, known: Sequence[Effect]) -> bool:
    """Return whether a robot's card, or what else is known, puts it into water."""
    in_water = robot.card is not None and robot.card.water is not None
    return in_water or any(isinstance(effect, Thrust) for effect in known)


def _prior(grids: Sequence[tuple[Effect, ...]], joints: Set[str], *, wet: bool) -> Prior:
    """Return the prior of effects: each as likely as the others, at all its places and shapes.

    Real drives have friction at every joint: one law at all of them is as likely as one effect.

    Args:
        grids: Effects, each at its shapes.
        joints: The driven ones.
        wet: Whether the robot is known to be in water. In air a fluid's forces are rarer.
    """
    alone = {
        grid[0].label: ODDS
        + math.log(len(grid) * len(grids))
        + (
            RARE
            if isinstance(grid[0], Tether) or (isinstance(grid[0], WetEffect) and not wet)
            else 0.0
        )
        for grid in grids
    }
    shapes = {grid[0].name: len(grid) for grid in grids}
    groups: dict[frozenset[str], float] = {}
    for name in DRIVE_LAWS:
        if name in shapes and joints:
            whole = ODDS + math.log(2 * len(DRIVE_LAWS) * shapes[name])
            members = {f"{name}@{joint}" for joint in joints} & alone.keys()
            viscous = {f"{VISCOUS}@{joint}" for joint in joints} & alone.keys()
            groups[frozenset(members | viscous)] = groups[frozenset(members)] = whole
    ordered = sorted(groups.items(), key=lambda each: -len(each[0]))
    return Prior(alone=alone, together=tuple(ordered))


def _drags_of_streams(columns: Sequence[EffectColumn]) -> dict[int, int]:
    """Return the entries of currents through one drag, and the entry of that drag."""
    effects = [column.effect for column in columns]
    return {
        at: effects.index(effect.drag)
        for at, effect in enumerate(effects)
        if isinstance(effect, Streaming)
    }


def _drive_laws(columns: Sequence[EffectColumn], joints: Set[str]) -> Iterator[tuple[int, ...]]:
    """Yield each law of drives at all driven joints, alone and beside viscous friction."""
    laws: dict[tuple[str, int], list[int]] = {}
    shapes = Counter[str]()
    for at, effect in enumerate(column.effect for column in columns):
        if effect.name in DRIVE_LAWS and effect.where in joints:
            laws.setdefault((effect.name, shapes[effect.label]), []).append(at)
            shapes[effect.label] += 1
    beside = laws.get((VISCOUS, 0), [])
    for (name, _), members in laws.items():
        yield tuple(members)
        if name != VISCOUS:
            yield tuple(sorted({*members, *beside}))
