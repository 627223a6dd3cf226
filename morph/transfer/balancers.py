"""The bodies that balance, each with a push fixed beforehand."""

from __future__ import annotations

from dataclasses import dataclass, replace

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.errors import TransferError
from morph.files import sha256
from morph.task.balance import balance
from morph.task.push import Push
from morph.transfer.body import Body, body


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
