"""Policies of every kind for one body, with bounds, angles, histories and delays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.policy.adjusted import Adjusted
from morph.policy.angles import turning
from morph.policy.linear import Linear
from morph.policy.network import Network
from morph.policy.observing import observations_of
from morph.policy.pattern import Swing, pattern
from morph.policy.policy import Action, Observation, Policy, actions_of
from morph.policy.radial import Radial
from morph.policy.track import Track


@dataclass(frozen=True, kw_only=True)
class Made:
    """What policies are made of."""

    action: tuple[Action, ...]
    observation: tuple[Observation, ...]
    angles: Array
    period: float = 0.05

    @property
    def all(self) -> dict[str, object]:
        """Return the arguments that every kind takes."""
        names = ("action", "observation", "angles", "period")
        return {name: getattr(self, name) for name in names}

    @property
    def features(self) -> int:
        """How many features a policy with feedback has."""
        return len(self.angles) + int(self.angles.sum())


@pytest.fixture(scope="session")
def pendulum() -> Robot:
    """Two hinges that turn freely, each with a motor of 10 N m at most."""
    return load("double_pendulum")


@pytest.fixture(scope="session")
def made(pendulum: Robot) -> Made:
    """Both hinges as angles, a speed with its past, and one that comes late."""
    inner, outer, speed, late = observations_of(pendulum)
    observation = (
        replace(inner, offset=0.3),
        outer,
        replace(speed, scale=4.0, history=3),
        replace(late, delay_s=0.1),
    )
    return Made(
        action=actions_of(pendulum),
        observation=observation,
        angles=turning(pendulum, observation),
    )


@pytest.fixture(scope="session")
def every(made: Made, pendulum: Robot) -> dict[str, Policy]:
    """Return policies by a name of their own, at least one of each kind."""
    rng = np.random.default_rng(0)
    inputs, size, actions, knots = made.features, len(made.angles), len(made.action), 30
    W, b = rng.normal(size=(actions, inputs)), rng.normal(size=actions)
    found: dict[str, Policy] = {
        f"linear, {how}": Linear(weight=3.0 * W, bias=b, bound=how, **made.all)
        for how in ("clip", "sine", "tanh")
    }
    plain = {**made.all, "angles": ()}
    found["linear, no angles"] = Linear(weight=W[:, :size], bias=b, **plain)
    found["radial"] = Radial(
        centre=rng.normal(size=(20, inputs)),
        width=rng.uniform(0.5, 2.0, inputs),
        weight=2.0 * rng.normal(size=(actions, 20)),
        bound="sine",
        **made.all,
    )
    sizes = (inputs, 9, 7, actions)
    found["network"] = Network(
        layers=tuple(
            (rng.normal(size=(out, into)), rng.normal(size=out)) for into, out in pairwise(sizes)
        ),
        bound="tanh",
        **made.all,
    )
    found["track"] = Track(
        nominal=4.0 * rng.normal(size=(knots, size)),
        command=5.0 * rng.normal(size=(knots, actions)),
        gain=5.0 * rng.normal(size=(knots, actions, size)),
        **made.all,
    )
    swings = {each.actuator: Swing(amplitude=12.0, frequency=0.7, rate=0.1) for each in made.action}
    found["pattern"] = pattern(pendulum, swings, period=made.period)
    # Of each of the four channels the newest, two of them angles; and the commands.
    d = 2 + 2 * 2 + actions
    for name in ("track", "pattern"):
        found[f"adjusted {name}"] = Adjusted(
            source=found[name],
            bias=rng.normal(size=actions),
            law=0.3 * rng.normal(size=(actions, d)),
            centre=rng.normal(size=(15, d)),
            width=rng.uniform(3.0, 9.0, size=(actions, d)),
            weight=rng.normal(size=(actions, 15)),
            reach=rng.uniform(0.2, 1.0, size=d),
            **made.all,
        )
    return found
