"""The bodies that balance, each with a push fixed beforehand."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.samples import Transitions
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.errors import TransferError
from morph.files import sha256
from morph.policy_transfer.body import Body, body
from morph.task.balance import balance
from morph.task.push import Push


@dataclass(frozen=True, kw_only=True)
class Pushed:
    """How a body is pushed, and which of its actuators is taken away."""

    link: str
    """What is pushed, sideways at its origin."""
    impulse: float
    """Along the first axis of the world, N s."""
    without: tuple[str, ...] = ()
    """Actuators taken away, for a body that would stand by a stiff servo whatever it does."""


PUSHED = {
    "cartpole": Pushed(link="cart", impulse=0.3),
    "cart_two_links": Pushed(link="cart", impulse=0.3),
    "cart_three_links": Pushed(link="cart", impulse=0.3),
    "cart_five_links": Pushed(link="cart", impulse=0.3),
    "cart_two_links_servo": Pushed(link="cart", impulse=1.0, without=("hinge_1",)),
    "cart_three_links_servo": Pushed(link="cart", impulse=0.3, without=("hinge_1",)),
    "cart_five_links_servo": Pushed(link="cart", impulse=1.0, without=("hinge_1",)),
    "rider_rigid_driven": Pushed(link="board", impulse=0.3),
    "rider_two_links_driven": Pushed(link="upper_body", impulse=2.0),
    "rider_three_links_driven": Pushed(link="board", impulse=0.3),
    "rider_five_links_driven": Pushed(link="board", impulse=0.3),
    "rider_rigid_passive": Pushed(link="board", impulse=0.3),
    "rider_two_links_passive": Pushed(link="upper_body", impulse=2.0),
    "rider_three_links_passive": Pushed(link="board", impulse=0.3),
    "rider_five_links_passive": Pushed(link="board", impulse=0.3),
}
"""Pushes after which holding still scores at most 0.3 and the oracle at least 0.95."""

LOUD = 200.0
"""By how many deviations of the noise a usual command changes the fastest speed in one period."""

LOUDEST, SOFTEST = 1.0, 0.05
"""Most and least of that change, m/s or rad/s, by which linear models hold and are seen."""

PLANAR = tuple(name for name in PUSHED if name != "cartpole")
"""The planar bodies that the cart-pole's policy is carried to."""


def balancer(name: str) -> Body:
    """Return a body of the shelf with its task of balancing, pushed as was fixed beforehand.

    Raises:
        TransferError: No push is fixed for it.
    """
    if name not in PUSHED:
        raise TransferError(
            f"no push is fixed for {name}",
            where="a body that balances",
            fix=f"give one of {', '.join(sorted(PUSHED))}",
        )
    return pushed(load(name), PUSHED[name])


def pushed(robot: Robot, how: Pushed) -> Body:
    """Return a body with its task of balancing, pushed as is said.

    Raises:
        TaskError: It cannot balance.
        SearchError: It can rest nowhere.
        RobotError: It lacks what is named.
    """
    for actuator in how.without:
        robot = without(robot, actuator)
    task = balance(robot)
    push = Push(link=how.link, impulse=(how.impulse, 0.0, 0.0))
    return body(replace(task, start=replace(task.start, push=push)))


def explored(target: Body, count: int, rng: np.random.Generator) -> Transitions:
    """Return transitions of random commands near rest, the same kind for every method.

    Each command alone changes the fastest speed by about `LOUD` deviations of the noise a period,
    at most two fifths of its range; how loud that is was fixed beforehand from the body's true
    response, as somebody who turns a knob until the body just moves would. A run ends, and the
    next begins at rest as the task's do without their push, when a joint is far away or fast.
    """
    low, high = target.bounds
    kick = float(np.clip(LOUD * target.task.noise, SOFTEST, LOUDEST))
    far, fast = (0.2, 3.0) if kick > 0.5 else (max(0.5 * kick, 0.05), max(4.0 * kick, 0.4))
    loud = np.minimum(kick / np.abs(target.linear[1]).max(axis=0), 0.4 * (high - low))
    calm = replace(target.task.start, push=None)
    model, half = target.plant.model, target.plant.model.nv
    rows = []
    x = None
    for _ in range(count):
        if x is None:
            x = target.state(*calm.sample(target.task.robot, model, 1, rng))[0]
        u = np.clip(loud * rng.standard_normal(len(loud)), low, high)
        after = np.nan_to_num(target.step(x[None], u[None])[0])
        rows.append((x, u, after))
        lost = np.abs(after[:half]).max() > far or np.abs(after[half:]).max() > fast
        x = None if lost else after
    state, command, following = (np.array(each) for each in zip(*rows, strict=True))
    noise = target.task.noise * rng.standard_normal((2, *state.shape))
    # What follows one transition is where the next begins: one reading, with one noise.
    hangs = np.flatnonzero((state[1:] == following[:-1]).all(axis=1))
    noise[0, hangs + 1] = noise[1, hangs]
    return Transitions(
        state=target.seen(state + noise[0]),
        command=command,
        after=target.seen(following + noise[1]),
        turns=np.zeros(target.size, dtype=bool),
    )


def seen_with(body: Body, noise: float) -> Body:
    """Return a body whose every reading has noise of this standard deviation."""
    return replace(body, task=replace(body.task, noise=noise))


def without(robot: Robot, actuator: str) -> Robot:
    """Return a robot without one of its actuators: the joint that it drove swings freely.

    Raises:
        RobotError: There is no such actuator.
    """
    gone = robot.actuator(actuator)
    spec = bare_spec(robot)
    spec.delete(spec.actuator(gone.name))
    spec.compile()
    mjcf = spec.to_xml()
    left = tuple(each for each in robot.actuators if each.name != gone.name)
    return replace(robot, actuators=left, mjcf=mjcf, sha256=sha256(mjcf))
