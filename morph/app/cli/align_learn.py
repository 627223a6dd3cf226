"""Learning a map for `morph align`: which mapper, from what, and what is thought of the map."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.alignment.errors import AlignError
from morph.alignment.maps.body_map import BodyMap, MapData, Mapper
from morph.alignment.maps.features import Features
from morph.alignment.maps.maps import MAPPERS
from morph.alignment.quality import quality
from morph.alignment.samples import Pairs, Step, Worth
from morph.app.cli.align_arguments import Align
from morph.app.cli.align_inputs import Side, pairs
from morph.app.cli.stages import Stages
from morph.app.report.align.outcome import Aligned
from morph.arrays import Array
from morph.errors import TransferError
from morph.nearest import nearest
from morph.policy_transfer.body import Body
from morph.policy_transfer.controls import through
from morph.policy_transfer.evaluate_hop import stepping
from morph.policy_transfer.guarded import guarded
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.mapped.lift import lift
from morph.policy_transfer.parts import parts
from morph.policy_transfer.relay_record import hashes
from morph.policy_transfer.transfer_record import GuardRecord

UNKNOWN = GuardRecord(verdict="unsure", probability=None)
"""Of a map through which no policy can be seen."""


@dataclass(frozen=True, kw_only=True)
class TaskMapper(Mapper):
    """The map of a hop: joints by what the task looks at, commands by the transitions."""

    name: ClassVar[str] = "task"

    source: Body
    """The source."""
    target: Body
    """The target."""

    def estimate(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return the map with which `morph transfer` would carry a policy."""
        return lift(self.source, self.target, given.target)


def check_map(name: str | None) -> None:
    """Refuse a name of no map.

    Raises:
        TransferError: There is no such map.
    """
    names = (TaskMapper.name, *(each.name for each in MAPPERS))
    if name is not None and name not in names:
        raise TransferError(
            f"there is no map {name!r}; there are {', '.join(names)}",
            where="--map",
            fix=f"the nearest are {nearest(name, names)}; docs/maps.md says what each needs",
        )


def learned(
    options: Align, source: Side, target: Side, progress: Stages, *, began: float, command: str
) -> Aligned:
    """Return the map between two bodies, and what is thought of it.

    Raises:
        TransferError: The bodies cannot be held against each other.
        AlignError: No map can be learned from what they did.
    """
    check_shared(source, target)
    known = _given(source, target, None if options.pairs is None else pairs(options.pairs))
    mapper = _mapper(options.map, known, source, target)
    progress.now(f"learning the map {mapper.name}")
    rng = np.random.default_rng([options.seed, 2])
    result = mapper.fit(known, rng)
    progress.now("judging the map")
    guard, why = _guard(source, target, result, rng)
    inputs = hashes([(side.names.body, side.sha256) for side in (source, target)])
    return Aligned(
        source=source.names,
        target=target.names,
        mapper=mapper.name,
        map=result,
        parts=parts(result, source.names, target.names, source.spreads, target.spreads),
        quality=quality_of(result, source, target),
        guard=guard,
        why=why,
        samples=(len(source.seen.state), len(target.seen.state)),
        held_out=len(target.held.state),
        seed=options.seed,
        seconds=time.monotonic() - began,
        command=command,
        inputs=inputs,
        notes=_notes(source, target, known),
    )


def check_shared(source: Side, target: Side) -> None:
    """Refuse two bodies of which no number of the task is both's.

    Raises:
        TransferError: They share none.
    """
    if source.body is None or target.body is None:
        return
    periods = [each.task.period for each in (source.body, target.body)]
    if abs(periods[0] - periods[1]) > 1e-9:
        raise TransferError(
            f"{source.names.body} is commanded every {periods[0]:g} s and {target.names.body} "
            f"every {periods[1]:g} s",
            where="two bodies",
            fix="give bodies of one control period: a map of transitions knows but one",
        )


def _given(source: Side, target: Side, known: Pairs | None) -> MapData:
    return MapData(
        source=source.seen,
        target=target.seen,
        pairs=known,
        step=step_of(source),
        source_worth=_worth(source.body),
        target_worth=_worth(target.body),
    )


def step_of(source: Side) -> Step:
    """Return the source's simulator; of one that was only recorded, the law of its transitions.

    That law is affine, x' = x + W (x, u, 1) by least squares: near a state of rest it will do.
    """
    if source.body is not None:
        return stepping(source.body)
    seen = source.seen
    known = np.column_stack([seen.state, seen.command, np.ones(len(seen.state))])
    law, *_ = np.linalg.lstsq(known, seen.after - seen.state, rcond=1e-9)

    def step(state: Array, command: Array) -> Array:
        return np.asarray(state + np.column_stack([state, command, np.ones(len(state))]) @ law)

    return step


def _worth(body: Body | None) -> Worth | None:
    """Return what states cost by the task: the square of what the task looks at."""
    if body is None:
        return None
    outcome = body.outcome
    return lambda state: np.asarray(np.square(state @ outcome.T).sum(axis=1))


def _mapper(name: str | None, known: MapData, source: Side, target: Side) -> Mapper:
    """Return the map that is asked for, or the first that what is known allows."""
    if source.body is not None and target.body is not None and name in {None, TaskMapper.name}:
        return TaskMapper(source=source.body, target=target.body)
    for each in MAPPERS:
        allowed = all(getattr(known, need) is not None for need in each.needs)
        if each.name == name or (name is None and allowed):
            return _looking(each, source, target)
    raise TransferError(
        "none can be learned from what is given" if name is None else
        "it knows the joints by their task, and of a body that was only recorded there is none",
        where="--map" if name is None else f"--map {name}",
        fix="give pairs by --pairs, or name both as bodies that can be simulated" if name is None
        else "leave out --map, or name both as bodies that can be simulated",
    )  # fmt: skip


def _looking(mapper: Mapper, source: Side, target: Side) -> Mapper:
    """Return a map that is told what the task looks at, if it is one that asks for that."""
    if not isinstance(mapper, Features) or source.body is None or target.body is None:
        return mapper
    looks = [each.body.outcome for each in (source, target) if each.body is not None]
    rows = min(len(look) for look in looks) // 2
    # Places, then their rates: of both the first that both bodies have.
    here, there = (np.concatenate([look[:rows], look[len(look) // 2 :][:rows]]) for look in looks)
    return replace(mapper, source_look=here, target_look=there)


def _guard(
    source: Side, target: Side, result: BodyMap, rng: np.random.Generator
) -> tuple[GuardRecord, str]:
    """Return the verdict on the source's policy seen through the map, and why there is none."""
    if source.body is None or target.body is None:
        return UNKNOWN, "a body that was only recorded has no task to judge a policy by"
    body = source.body
    gain = holding(body)
    law = through(result, gain, np.zeros(len(gain)))
    try:
        return guarded(target.body, target.seen, law, rng), ""
    except AlignError as error:
        return UNKNOWN, f"it cannot tell: {error.what}"


def quality_of(result: BodyMap, source: Side, target: Side) -> Mapping[str, float]:
    """Return how good a map is on what it was not learned from, 0 where it errs by nothing."""
    judged = quality(result, source.held, target.held, step_of(source))
    return judged.numbers()


def _notes(source: Side, target: Side, known: MapData) -> tuple[str, ...]:
    lines = []
    for side, option in ((source, "source"), (target, "target")):
        if side.body is None:
            lines.append(f"what the {option} did was read; its last fifth was held out")
    if source.body is None:
        lines.append("the source has no simulator: the affine law of its transitions stands for it")
    if lines and known.pairs is None:
        # Of a linear law x' = A x + B u the negative of both x and u moves alike.
        lines.append("all signs together may be turned round: no pairs tell them")
    return tuple(lines)
