"""Every way to balance a body from few transitions, with and without a source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.body.load import load
from morph.body.vary import Heavier, Operation, Scale, vary
from morph.errors import MorphError, SearchError
from morph.policy_transfer.balancers import PUSHED, pushed
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.hop import hop
from morph.policy_transfer.mapped.belief import carried, learned, read
from morph.policy_transfer.mapped.feedback import cautious, chosen, plain
from morph.policy_transfer.mapped.lift import lift
from morph.policy_transfer.relay import same

LONGER, HEAVIER = 0.25, 0.5
"""Deviations of the logarithms of a kin's size and of each mass of its links."""

RIDGE = 1e-3
"""What a square of a weight costs against squares of readings, of the ridge."""

MAPPED = ("hop", "map_only", "shuffled", "flipped", "shuffled_map_only", "flipped_map_only")
"""What uses the source, rightly or wrongly."""

KIN = ("kin", "kin_carried", "kin_flipped")
"""What uses a body of the same joints, of other lengths and masses, as source."""

SOURCELESS = ("least_squares", "ridge", "structured", "structured_cautious")
"""What fits the target alone."""


def mapped(
    source: Body, target: Body, seen: Transitions, *, seed: int, controls: bool
) -> dict[str, Array]:
    """Return the feedback of every way that uses the source, rightly or wrongly, by its name.

    Wrong maps, as controls: one learned from commands in another order, and one with every
    command turned round.
    """
    right = lift(source, target, seen)
    rng = np.random.default_rng([seed, 11])
    mixed = replace(seen, command=seen.command[rng.permutation(len(seen.command))])
    shuffled = lift(source, target, mixed)
    told = {"": right}
    if controls:
        told |= {"shuffled": shuffled, "flipped": flipped(right)}
    found: dict[str, Array] = {}
    for name, each in told.items():
        found[name or "hop"] = hop(source, target, seen, seed=seed, seen_as=each).gain
        found[f"{name}_map_only".lstrip("_")] = through(source, target, each)
    return found


def from_kin(
    kin: Body, target: Body, seen: Transitions, *, seed: int, controls: bool
) -> dict[str, Array]:
    """Return the feedback of what starts from a body of the same joints, by its name.

    Each number of a state and each command is that of the other body. The policy as it came is
    kept unless one made anew on what is believed is foreseen to be clearly better, which fewer
    transitions than a row of the model has numbers cannot tell. The control turns every command
    of the map round.
    """
    gain = plain(read(kin), kin)
    found: dict[str, Array] = {"kin_carried": gain}
    few = len(seen.state) < seen.state.shape[1] + seen.command.shape[1]
    for name, sign in (("kin", 1.0), ("kin_flipped", -1.0))[: 2 if controls else 1]:
        if few:
            found[name] = sign * gain
            continue
        right = same(target)
        as_it_is = replace(right, read_law=sign * right.read_law)
        believed = learned(seen, carried(kin, as_it_is, target), target)
        choices = {
            "map_only": sign * gain,
            "cautious": cautious(believed, target),
            "plain": plain(believed.step, target),
        }
        _, found[name] = chosen(choices, believed, target, np.random.default_rng([seed, 3]))
    return found


def kin_of(body: str, rng: np.random.Generator) -> Body:
    """Return a body of the shelf with other lengths and masses, whose own policy balances it.

    Raises:
        SearchError: None of ten draws can be balanced.
    """
    for _ in range(10):
        robot = load(body)
        heavy = [link.name for link in robot.links if link.mass > 0.0]
        changes: list[Operation] = [Scale(link="*", factor=float(np.exp(rng.normal(0.0, LONGER))))]
        changes += [
            Heavier(link=link, factor=float(np.exp(rng.normal(0.0, HEAVIER)))) for link in heavy
        ]
        try:
            found = pushed(vary(robot, *changes), PUSHED[body])
            gain = plain(np.hstack(found.linear), found)
        except MorphError:
            continue
        if found.score(linear_law(gain), rows=2, seed=0) > 0.9:
            return found
    raise SearchError(
        "none of ten draws can be balanced",
        where=f"a body like {body}",
        fix="draw it nearer",
    )


def flipped(right: AffineMap) -> AffineMap:
    """Return a map with every command turned round."""
    return replace(
        right,
        action_law=-right.action_law,
        action_state=-right.action_state,
        read_law=-right.read_law,
        read_state=-right.read_state,
    )


def through(source: Body, target: Body, seen_as: AffineMap) -> Array:
    """Return the source's feedback seen through a map, shape (nu, n)."""
    gain = plain(read(source), source)
    return np.asarray(seen_as.action_law @ gain @ seen_as.state_law + seen_as.action_state)


def sourceless(target: Body, seen: Transitions) -> dict[str, Array]:
    """Return the feedback of every way without a source, by its name."""
    believed = learned(seen, None, target)
    return {
        "least_squares": plain(_squares(seen, 0.0), target),
        "ridge": plain(_squares(seen, RIDGE), target),
        "structured": plain(believed.step, target),
        "structured_cautious": cautious(believed, target),
    }


def _squares(seen: Transitions, ridge: float) -> Array:
    """Return (A, B) by least squares, pulled towards a body that stays where it is."""
    x = np.hstack([seen.state, seen.command])
    n = seen.state.shape[1]
    pull = np.sqrt(ridge) * np.eye(x.shape[1])
    rows = np.concatenate([x, pull])
    change = np.concatenate([seen.after - seen.state, np.zeros((x.shape[1], n))])
    found = np.linalg.lstsq(rows, change, rcond=None)[0].T
    found[:, :n] += np.eye(n)
    return np.asarray(found)
