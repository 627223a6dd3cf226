"""Transfer a policy over one hop and score it against its controls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.errors import AlignError
from morph.alignment.quality import quality
from morph.alignment.samples import Step, Transitions
from morph.arrays import Array
from morph.errors import MorphError
from morph.policy_transfer.body import Body, linear_law, still_law
from morph.policy_transfer.controls import SPOILT, control_scores, flipped, shuffled, through
from morph.policy_transfer.from_scratch import scratch
from morph.policy_transfer.guarded import guarded
from morph.policy_transfer.hop import Hopped, through_map
from morph.policy_transfer.hop_checkpoint import Kept, map_name
from morph.policy_transfer.hop_result import Crossing, Curve
from morph.policy_transfer.mapped.belief import LinearPosterior, learned
from morph.policy_transfer.mapped.feedback import cautious, chosen, holding
from morph.policy_transfer.parts import Spreads, names_of, parts
from morph.policy_transfer.relay import carry, tried
from morph.policy_transfer.transfer_record import GuardRecord

COUNTS = (1 / 6, 1 / 3, 2 / 3, 1.0)
"""At which shares of the transitions a learning curve has its points."""

SEEDS = 1000
"""How far the seeds of two hops are apart: repeats take those between."""

JUDGED = 100
"""Transitions on which a map is judged; like the runs, they serve the report alone."""

FEWEST = 10
"""Transitions of the first point, at least."""


UNJUDGED = (
    "the guard cannot tell: it was held against bodies of which every joint is seen, and this one "
    "is seen and told in groups"
)
"""What is said of a body that the guard is not made for: it took good laws for unsafe there."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """How hops are made and judged."""

    samples: int
    """Transitions of the target."""
    trials: int = 20
    """Runs over which a policy is judged."""
    repeats: int = 5
    """How often each point of a learning curve is drawn anew; 0: no curves."""
    scratch: int = 0
    """Rounds of a search from scratch beside it; 0: none."""
    seed: int = 0
    """Random seed."""


def crossed(
    number: int,
    source: Body,
    gain: Array,
    shift: Array,
    target: Body,
    options: Asked,
    say: Callable[[str], None] = lambda words: None,
) -> Kept:
    """Return a hop: the source's law carried to the target, and all that it is held against.

    The scores of runs on the target serve the report alone; nothing is learned from them.

    Args:
        number: Which hop of the chain, counted from 1.
        source: The body whose law it is; the first of a chain, or one as it is believed.
        gain: Of the law u = gain x + shift about rest, shape (k_s, n_s).
        shift: Shape (k_s,).
        target: The body it is carried to.
        options: How.
        say: Is told what is being done.

    Raises:
        AlignError: No map can be learned.
        MorphError: The target cannot be held by any law.
    """
    say("learning the map")
    seed = options.seed + SEEDS * number
    result, believed = carried(source, gain, target, options.samples, seed)
    seen = shown(target, options.samples, seed)
    say("judging")
    measured = _measured(result, target, gain, shift, seen, options)
    measured |= _spoilt(source, target, seed, options)
    guard, notes = _guard(result, target, seen, np.random.default_rng([seed, 1]))
    curves = _curves(number, source, gain, shift, target, options, say)
    if options.scratch:
        say("learning from scratch")
        alone_long = scratch(target, rows=options.trials, seed=options.seed, rounds=options.scratch)
        curves = (*curves, alone_long)
        measured[alone_long.name] = float(alone_long.scores[0, -1])
    crossing = Crossing(
        source=source.task.robot.name,
        target=target.task.robot.name,
        map=map_name(number),
        kind=result.map.kind,
        parts=parts(
            result.map, names_of(source), names_of(target), _usual(source, options), _spreads(seen)
        ),
        quality=_quality(result, source, target, options),
        guard=guard,
        samples=result.samples,
        measured=measured,
        curves=curves,
        notes=notes,
    )
    return Kept(
        crossing=crossing,
        map=result.map,
        gain=result.gain,
        shift=result.shift,
        step=believed.step,
    )


def carried(
    source: Body, gain: Array, target: Body, count: int, seed: int
) -> tuple[Hopped, LinearPosterior]:
    """Return a hop of a relay, and what is believed of the target after it.

    The policy is the one that is made anew, or the source's own through the map where that is
    foreseen to do better.
    """
    result, believed = carry(source, target, count, seed=seed)
    through = through_map(result.map, gain, target)
    choices = {"anew": result.gain, "through": through}
    _, best = chosen(choices, believed, target, np.random.default_rng([seed, 6]))
    return replace(result, gain=best), believed


def shown(target: Body, count: int, seed: int) -> Transitions:
    """Return the very transitions that a hop of this seed learns from."""
    return tried(target, count, np.random.default_rng([seed, 5]))


def _measured(
    result: Hopped, target: Body, gain: Array, shift: Array, seen: Transitions, options: Asked
) -> dict[str, float]:
    """Return the task's score of each policy and control, over the same runs."""
    how = {"rows": options.trials, "seed": options.seed}
    measured = {
        "zero_shot": target.score(through(result.map, gain, shift), **how),
        "final": target.score(linear_law(result.gain, result.shift), **how),
        "hold_still": target.score(still_law(len(result.gain)), **how),
        "no_source": target.score(linear_law(alone(target, seen)), **how),
    }
    measured |= control_scores(
        target, result.map, gain, shift, rows=options.trials, seed=options.seed
    )
    own = target.score(linear_law(holding(target)), **how)
    # Who knows the true body could also take the best law that was found without knowing it.
    measured["oracle"] = max(own, measured["final"], measured["zero_shot"])
    return measured


def _spoilt(source: Body, target: Body, seed: int, options: Asked) -> dict[str, float]:
    """Return the task's score of policies made anew from the same transitions by wrong maps."""
    scores = {}
    for name, spoil in SPOILT:
        if name == "shuffled_anew" and target.size < 4:
            continue
        result, _ = carry(source, target, options.samples, seed=seed, spoil=spoil)
        law = linear_law(result.gain, result.shift)
        scores[name] = target.score(law, rows=options.trials, seed=options.seed)
    return scores


def _quality(result: Hopped, source: Body, target: Body, options: Asked) -> dict[str, float]:
    """Return how good the map is on transitions that nobody learned from."""
    rng = np.random.default_rng([options.seed, 5])
    here, there = tried(source, JUDGED, rng), tried(target, JUDGED, rng)
    return dict(quality(result.map, here, there, stepping(source)).numbers())


def stepping(body: Body) -> Step:
    """Return a body's simulator between what is seen of its states."""
    if body.sight is None:
        return body.step
    back = np.linalg.pinv(body.sight).T
    return lambda state, command: body.seen(body.step(state @ back, command))


def _guard(
    result: Hopped, target: Body, seen: Transitions, rng: np.random.Generator
) -> tuple[GuardRecord, tuple[str, ...]]:
    if result.guard is not None:
        verdict = result.guard
        return GuardRecord(verdict=verdict.verdict, probability=1.0 - verdict.probability), ()
    if target.sight is not None:
        return GuardRecord(verdict="unsure", probability=None), (UNJUDGED,)
    try:
        return guarded(target, seen, linear_law(result.gain, result.shift), rng), ()
    except AlignError as error:
        return GuardRecord(verdict="unsure", probability=None), (
            f"the guard cannot tell: {error.what}",
        )


def _curves(
    number: int,
    source: Body,
    gain: Array,
    shift: Array,
    target: Body,
    options: Asked,
    say: Callable[[str], None],
) -> tuple[Curve, ...]:
    """Return how good each way is by how many transitions it is given."""
    if not options.repeats:
        return ()
    counts = sorted({max(FEWEST, round(share * options.samples)) for share in COUNTS})
    rows: dict[str, list[list[float]]] = {}
    for repeat in range(options.repeats):
        points: dict[str, list[float]] = {}
        for count in counts:
            say(f"learning curve, {count} transitions, {repeat + 1} of {options.repeats}")
            seed = options.seed + SEEDS * number + 1 + repeat
            scores = _point(source, gain, shift, target, count, seed, options)
            for name, score in scores.items():
                points.setdefault(name, []).append(score)
        for name, line in points.items():
            rows.setdefault(name, []).append(line)
    return tuple(
        Curve(name=name, samples=tuple(counts), scores=np.array(lines))
        for name, lines in rows.items()
    )


def _point(
    source: Body,
    gain: Array,
    shift: Array,
    target: Body,
    count: int,
    seed: int,
    options: Asked,
) -> dict[str, float]:
    """Return the score of each way from the same transitions; that of a way that fails is still."""
    how = {"rows": max(1, options.trials // 2), "seed": seed}
    none = target.score(still_law(len(target.bounds[0])), **how)
    scores = dict.fromkeys(("transfer", "no_source", "shuffled", "flipped"), none)
    seen = shown(target, count, seed)
    scores["no_source"] = target.score(linear_law(alone(target, seen)), **how)
    try:
        result, _ = carried(source, gain, target, count, seed)
    except (AlignError, MorphError):
        return scores
    scores["transfer"] = target.score(linear_law(result.gain, result.shift), **how)
    scores["flipped"] = target.score(flipped(result.map, gain, shift), **how)
    mixed = shuffled(result.map, gain, shift, target.size, np.random.default_rng([seed, 3]))
    if mixed:
        scores["shuffled"] = target.score(mixed[0], **how)
    else:
        del scores["shuffled"]
    return scores


def alone(body: Body, seen: Transitions) -> Array:
    """Return the gain that a body's own transitions give without any source, shape (nu, n).

    As a hop makes it, but nothing is believed of the body beforehand.
    """
    return cautious(learned(seen, None, body), body)


def _usual(body: Body, options: Asked) -> Spreads:
    """Return how far the numbers of a body whose simulation is at hand usually are from rest."""
    return _spreads(tried(body, JUDGED, np.random.default_rng([options.seed, 4])))


def _spreads(seen: Transitions) -> Spreads:
    return Spreads(state=seen.state.std(axis=0), command=seen.command.std(axis=0))
