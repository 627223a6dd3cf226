"""Convert linear laws about rest to stored policies, and back."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.angles import turning
from morph.policy.linear import Linear
from morph.policy.observing import Observer, observations_of
from morph.policy.policy import Policy, actions_of
from morph.policy.tangent import tangent
from morph.policy_transfer.body import Body, Law
from morph.search.evaluate import check_period

STEP = 1e-4
"""Distance of a finite difference, in the state's units."""


def stored(body: Body, gain: Array, shift: Array) -> Linear:
    """Return the policy u = gain x + shift + what holds the body at rest, x = state - rest.

    A hinge without limits is seen by its sine and cosine, as a policy that must not mind full
    turns sees it. A body that floats is seen with the quaternion that it has at rest: to first
    order, and with that sign.

    Args:
        body: Whose policy it is.
        gain: Shape (nu, n), n what laws of the body see.
        shift: Shape (nu,).
    """
    robot, model, still = body.task.robot, body.plant.model, body.still
    seen = observations_of(robot)
    rest = np.concatenate([still.position, still.velocity])
    # A law may see less than the whole state, and tell actuators by groups; a policy that is
    # stored sees all of it, and tells each.
    whole = gain if body.sight is None else gain @ body.sight
    if body.together is not None:
        whole, shift = body.together @ whole, body.together @ shift
    weight = whole @ tangent(robot, model, still.position, seen)
    angles = turning(robot, seen)
    plain, turns = angles == 0.0, angles == 1.0
    sine = np.cos(rest[turns]) * weight[:, turns]
    cosine = -np.sin(rest[turns]) * weight[:, turns]
    both = np.stack([sine, cosine], axis=-1).reshape(len(weight), -1)
    return Linear(
        weight=np.concatenate([weight[:, plain], both], axis=1),
        bias=still.command + shift - weight[:, plain] @ rest[plain],
        angles=angles,
        action=actions_of(robot),
        period=body.task.period,
        observation=seen,
    )


def law_of(body: Body, policy: Policy) -> Law:
    """Return what a policy does, as a law about rest.

    Raises:
        TransferError: It looks back in time, or not at all.
        PolicyError: It sees what the body does not have.
        SearchError: Its control period is another than the task's.
    """
    _check(body, policy)

    back = None if body.sight is None else np.linalg.pinv(body.sight).T
    split = None if body.together is None else np.linalg.pinv(body.together).T

    def law(state: Array, time: Array) -> Array:
        q, v = body.place(state if back is None else state @ back)
        seen = Observer(policy, body.task.robot, body.plant.model, len(state)).see(q, v)
        command = policy.act(seen, time) - body.still.command
        return command if split is None else command @ split

    return law


def gain_of(body: Body, policy: Policy) -> tuple[Array, Array]:
    """Return gain (nu, n) and shift (nu,) of a policy about rest, to first order.

    The clock stands at the end of the task: a policy that follows a plan holds there.

    Raises:
        TransferError: It looks back in time, or not at all.
        PolicyError: It sees what the body does not have.
        SearchError: Its control period is another than the task's.
    """
    law = law_of(body, policy)
    clock = np.full(body.size, body.task.horizon)
    move = STEP * np.eye(body.size)
    gain = (law(move, clock) - law(-move, clock)).T / (2.0 * STEP)
    shift = law(np.zeros((1, body.size)), clock[:1])[0]
    return np.asarray(gain), np.asarray(shift)


def _check(body: Body, policy: Policy) -> None:
    check_period(policy, body.task)
    looks_back = any(each.history > 1 or each.delay_s > 0.0 for each in policy.observation)
    if looks_back or not policy.observation:
        what = "looks back in time" if looks_back else "does not look at the body"
        raise TransferError(
            f"it {what}, and what is carried is feedback of the present state",
            where=f"a policy of kind {policy.kind} of {body.task.robot.name}",
            fix="give a policy that sees each channel once and now, such as `morph learn "
            f"{body.task.name}` finds",
        )
