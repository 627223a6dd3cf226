"""What acts where a robot touches the floor, found by simulating the runs from their starts.

No column tells of it: forces of contact depend on depths that no recording holds.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.errors import EffectError
from morph.inference.finalist import Finalist
from morph.inference.search import Explanation
from morph.inference.validate import MATERIAL, Validation
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.restitution import Restitution
from morph.physics.effect import Effect

ANYWHERE = "any+floor"
"""Every link with the floor."""
GRID = {
    "mu": np.geomspace(0.05, 2.0, 12),
    "stiffness": np.geomspace(100.0, 1e5, 6),
    "damping": np.geomspace(1.0, 1e3, 6),
    "e": np.linspace(0.05, 0.95, 10),
}
"""Values of each parameter, the best of which begin a search: there are many local minima."""
GREATEST = {"mu": 5.0, "e": 0.95}
"""The greatest value that is tried."""
FACTOR, NARROWER, TURNS = 1.3, 0.7, 7
"""By which a parameter changes first, the power of that factor from one turn to the next, and the
turns of a search."""


@dataclass(frozen=True, kw_only=True)
class _Floor:
    """Laws of contact under trial beside a set of effects, and the error of rollouts with them."""

    laws: tuple[Effect, ...]
    loss: float
    """Mean over the stretches, nats."""


def likeliest_contact(
    base: Finalist, validation: Validation, now: float
) -> tuple[float, Explanation] | None:
    """Return laws of the floor beside a set with which rollouts err least, and their mean loss.

    Friction, softness and restitution are tried alone, then beside the best of them. Parameters
    are searched one by one, as what impacts do has edges where no derivative holds.

    Source: Hooke and Jeeves 1961, Journal of the ACM 8(2), 212-229 (pattern search).

    Args:
        base: A set of effects.
        validation: The stretches that are simulated.
        now: Mean loss of the set over them.

    Returns:
        None if none gains anything, or the robot is not in contact.
    """
    if not validation.touching:
        return None
    taken = {effect.label for effect in base.effects}
    kinds = (ContactFriction, ContactSoftness, Restitution)
    best = _Floor(laws=(), loss=now)
    for _ in range(2):
        tried = []
        for kind in kinds:
            law = kind.at(ANYWHERE)
            named = {law.name, *(each.name for each in best.laws)}
            # Restitution decides on damping: beside softness it says the same twice.
            if law.label in taken | {e.label for e in best.laws} or named >= {
                "contact_softness", "restitution"
            }:  # fmt: skip
                continue
            free = [name for name in GRID if hasattr(law, name)]
            begun = [
                (*best.laws, _with(law, dict(zip(free, values, strict=True))))
                for values in itertools.product(*(GRID[name] for name in free))
            ]
            tried.append(_searched(base, validation, begun))
        better = min(tried, key=lambda each: each.loss, default=best)
        if not better.loss < best.loss - MATERIAL:
            break
        best = better
    if not best.laws:
        return None
    own = np.zeros(len(base.refit.point))
    return best.loss, Explanation(effects=best.laws, gain=0.0, own=own, members=(), level=0)


def _searched(
    base: Finalist, validation: Validation, starts: Sequence[tuple[Effect, ...]]
) -> _Floor:
    """Return laws at the parameters with which rollouts err least, from the best of some starts."""
    loss = functools.partial(_loss, base, validation)
    begun = [_Floor(laws=laws, loss=loss(laws)) for laws in starts]
    best, factor = min(begun, key=lambda each: each.loss), FACTOR
    names = [(at, k) for at, law in enumerate(best.laws) for k in GRID if hasattr(law, k)]
    for _ in range(TURNS):
        for at, name in names:
            value = getattr(best.laws[at], name)
            for power in (-1.0, -0.5, 0.5, 1.0):
                there = min(value * factor**power, GREATEST.get(name, np.inf))
                law = _with(best.laws[at], {name: there})
                moved = (*best.laws[:at], law, *best.laws[at + 1 :])
                result = _Floor(laws=moved, loss=loss(moved))
                best = min(best, result, key=lambda each: each.loss)
        factor = factor**NARROWER
    return best


def _with(law: Effect, values: Mapping[str, float]) -> Effect:
    """Return a law with other parameters."""
    return replace(law, **values)  # type: ignore[type-var]


def _loss(base: Finalist, validation: Validation, laws: tuple[Effect, ...]) -> float:
    """Return the mean loss of rollouts with laws of contact beside a set; no end, if none can."""
    hypothesis = base.refit.hypothesis
    more = replace(hypothesis, effects=(*hypothesis.effects, *laws))
    point: Array = np.r_[base.refit.point, more.start[len(base.refit.point) :]]
    try:
        (losses,) = validation.losses(more, [[point] * validation.folds], base.refit.runs)
    except EffectError:
        # Too stiff for the step of the simulation.
        return float("inf")
    return float(losses.mean())
