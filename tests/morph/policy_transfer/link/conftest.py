"""What tests of the link share: a body, and policies of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy_transfer.link.link import MessageLink
from morph.policy_transfer.link.outbox import Post

Making = Callable[..., Linear]


@pytest.fixture(scope="session")
def cartpole() -> Robot:
    return load("cartpole")


@pytest.fixture(scope="session")
def linear(cartpole: Robot) -> Making:
    """Make a linear policy whose bias tells it from the others."""

    def made(bias: float, **changed: object) -> Linear:
        policy = Linear(
            action=actions_of(cartpole),
            observation=observations_of(cartpole),
            period=0.05,
            weight=np.zeros((1, 4)),
            bias=np.array([bias]),
        )
        return replace(policy, **changed)  # type: ignore[arg-type]

    return made


class Clock:
    """A clock that goes on by one second whenever it is asked."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1.0
        return self.now


@pytest.fixture
def posted() -> Iterator[Callable[[MessageLink, Path, str], Post]]:
    """Make posts that send again every two ticks, and are closed in the end."""
    made = []

    def make(link: MessageLink, folder: Path, name: str) -> Post:
        made.append(Post(link, folder, name=name, again=2.0, clock=Clock()))
        return made[-1]

    yield make
    for post in made:
        post.close()
