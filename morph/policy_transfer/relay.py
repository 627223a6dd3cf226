"""A relay: a policy carried along a chain of bodies, made anew on each, every sample counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.errors import TransferError
from morph.policy_transfer.balancers import explored, seen_with
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.hop import Hopped
from morph.policy_transfer.mapped.belief import LinearPosterior, carried, learned, read
from morph.policy_transfer.mapped.feedback import cautious, chosen, plain
from morph.policy_transfer.mapped.lift import lift, quality_of

SHARE = 0.1
"""Standard deviation of the servo targets that are tried, in half ranges."""

UNSEEN = 0.003
"""Share of how speeds change that is reckoned as noise where a body is not wholly seen.

What is hidden and what slides moves what is seen, however exact readings are.
"""

Apart = Callable[[Body, Body], float]
"""How far two bodies are apart for a task; a map between near ones loses less."""


@dataclass(frozen=True, kw_only=True)
class Relayed:
    """What a relay gave."""

    hops: tuple[Hopped, ...]
    """In order; the target of one is the source of the next."""
    beliefs: tuple[LinearPosterior, ...]
    """What is believed of each target after its transitions."""

    @property
    def samples(self) -> int:
        """Transitions of all targets together."""
        return sum(each.samples for each in self.hops)

    @property
    def last(self) -> LinearPosterior:
        """What is believed of the last body."""
        return self.beliefs[-1]

    @property
    def gain(self) -> Array:
        """Feedback of the last body about rest, shape (nu, n)."""
        return self.hops[-1].gain


def relay(
    chain: Sequence[Body],
    *,
    counts: Sequence[int],
    seed: int,
    rows: int = 0,
    done: Callable[[int, Hopped], None] | None = None,
) -> Relayed:
    """Return what comes of carrying a policy along a chain, from its first body to its last.

    Only the first body's simulator is ours. Of every other the policy's maker knows what its
    transitions told on the way; the next hop starts from that, not from its true model.

    Args:
        chain: Two bodies or more.
        counts: Transitions of each body after the first.
        seed: Of all chance.
        rows: Runs by which each hop is scored; none if 0.
        done: Told of each hop, by its number, when it is done.

    Raises:
        TransferError: The chain is too short, or counts are not one for each hop.
    """
    if len(chain) < 2 or len(counts) != len(chain) - 1 or min(counts) < 1:
        raise TransferError(
            f"it has {len(chain)} bodies and {len(counts)} counts of transitions",
            where="a relay",
            fix="give two bodies or more, and a count of 1 or more for each hop",
        )
    known, hops, beliefs = chain[0], list[Hopped](), list[LinearPosterior]()
    gain = plain(read(known), known)
    for at, (target, count) in enumerate(zip(chain[1:], counts, strict=True)):
        own = seed + 1000 * at
        hopped, belief = carry(known, target, count, seed=own, source_gain=gain, rows=rows)
        hops.append(hopped)
        beliefs.append(belief)
        if done is not None:
            done(at, hopped)
        known, gain = as_believed(target, belief.step), hopped.gain
    return Relayed(hops=tuple(hops), beliefs=tuple(beliefs))


def carry(
    source: Body,
    target: Body,
    count: int,
    *,
    seed: int,
    source_gain: Array | None = None,
    rows: int = 0,
    spoil: Callable[[AffineMap], AffineMap] | None = None,
) -> tuple[Hopped, LinearPosterior]:
    """Return one hop of a relay, and what is believed of the target after it.

    Bodies that are seen and told by the same groups of joints are mapped one to one; others by
    what their task looks at. What the source does at mapped states is believed of the target
    beforehand, its transitions correct that, and feedback is made anew.

    Args:
        source: Whose linear model is known, or believed.
        target: Whose transitions are looked at.
        count: How many.
        seed: Of all chance.
        source_gain: The source's feedback; made from its model if none.
        rows: Runs by which it is scored; none if 0.
        spoil: Makes the map a wrong one, for a control.
    """
    rng = np.random.default_rng([seed, 5])
    seen = tried(target, count, rng)
    seen_as = same(target) if alike(source, target) else lift(source, target, seen)
    seen_as = seen_as if spoil is None else spoil(seen_as)
    before = carried(source, seen_as, target)
    believed = learned(seen, before, reckoned(seen, target))
    first = plain(read(source), source) if source_gain is None else source_gain
    through_it = through_map(seen_as, first, target)
    choices = {
        "cautious": cautious(believed, target),
        "map_only": through_it,
        "plain": plain(believed.step, target),
    }
    _, gain = chosen(choices, believed, target, np.random.default_rng([seed, 3]))
    scores = {}
    if rows:
        through = linear_law(through_it)
        scores["zero_shot"] = target.score(linear_law(gain), rows=rows, seed=seed)
        scores["map_only"] = target.score(through, rows=rows, seed=seed)
    hopped = Hopped(
        source=source.task.robot.name,
        target=target.task.robot.name,
        map=seen_as,
        quality=quality_of(seen_as, source, seen),
        guard=None,
        samples=len(seen.state),
        gain=gain,
        shift=np.zeros(len(gain)),
        scores=scores,
    )
    return hopped, believed


def tried(target: Body, count: int, rng: np.random.Generator) -> Transitions:
    """Return transitions of random commands near rest, the same kind for every method."""
    if target.together is None:
        return explored(target, count, rng)
    return target.transitions(count, rng, share=SHARE)


def as_believed(body: Body, step: Array) -> Body:
    """Return a body whose linear model is what is believed of it, (A, B), not the truth."""
    n = body.size
    sight = np.eye(n) if body.sight is None else body.sight
    together = np.eye(step.shape[1] - n) if body.together is None else body.together
    result = replace(body, sight=sight, together=together)
    law = np.linalg.pinv(sight) @ step[:, :n] @ sight
    command = np.linalg.pinv(sight) @ step[:, n:] @ np.linalg.pinv(together)
    # Where a cached property keeps its value: the truth is then never asked for.
    result.__dict__["linear"] = (law, command)
    return result


def alike(source: Body, target: Body) -> bool:
    """Return whether two bodies stand by servos in the same groups of joints."""
    by_groups = _grouped(source) and _grouped(target)
    return by_groups and source.size == target.size and _commands(source) == _commands(target)


def same(target: Body) -> AffineMap:
    """Return the map by which each number is the same number of the other body."""
    n, k = target.size, _commands(target)
    return AffineMap(
        state_law=np.eye(n), state_shift=np.zeros(n), lift_law=np.eye(n), lift_shift=np.zeros(n),
        action_law=np.eye(k), action_state=np.zeros((k, n)), action_shift=np.zeros(k),
        read_law=np.eye(k), read_state=np.zeros((k, n)), read_shift=np.zeros(k),
    )  # fmt: skip


def through_map(seen_as: AffineMap, gain: Array, target: Body) -> Array:
    """Return a source's feedback seen through a map, shape (nu, n)."""
    return np.asarray(seen_as.action_law @ gain @ seen_as.state_law + seen_as.action_state)


def nearest_path(bodies: Sequence[Body], apart: Apart, *, most: int) -> tuple[int, ...]:
    """Return the chain from the first body to the last whose longest hop is shortest.

    Among such the one whose hops together are shortest, of at most so many hops.

    Args:
        bodies: From which, over which and to which.
        apart: How far two are apart.
        most: Most hops, 1 or more.
    """
    count = len(bodies)
    far = np.array([[apart(a, b) if a is not b else 0.0 for b in bodies] for a in bodies])
    best: dict[int, tuple[float, float, tuple[int, ...]]] = {0: (0.0, 0.0, (0,))}
    for _ in range(most):
        longer = dict(best)
        for here, (worst, total, way) in best.items():
            for to in range(count):
                if to in way:
                    continue
                tried = (max(worst, far[here, to]), total + far[here, to], (*way, to))
                if to not in longer or tried[:2] < longer[to][:2]:
                    longer[to] = tried
        best = longer
    return best[count - 1][2]


def reckoned(seen: Transitions, target: Body) -> Body:
    """Return a body told to be as noisy as a linear model of what is seen of it has to bear.

    Args:
        seen: Its transitions.
        target: The body; it comes back as it is if all of its state is seen.
    """
    if target.sight is None:
        return target
    rise = (seen.after - seen.state)[:, target.size // 2 :]
    unseen = UNSEEN * float(np.sqrt(np.square(rise).mean()))
    return seen_with(target, float(np.hypot(target.task.noise, unseen)))


def _grouped(body: Body) -> bool:
    return body.together is not None and len(body.together) > body.together.shape[1]


def _commands(body: Body) -> int:
    return len(body.bounds[0])
