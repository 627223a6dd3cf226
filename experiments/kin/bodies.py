"""Bodies that balance, drawn by chance about those of the shelf, each with a push that is fair."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import bare_spec, spec_of
from morph.body.vary import Heavier, Operation, Scale, Stiffen, vary
from morph.body.vary.apply import edited
from morph.errors import SearchError
from morph.files import sha256
from morph.policy_transfer.body import Body, body, linear_law, still_law
from morph.search.regulator.lqr import lqr
from morph.sim.start import started
from morph.task.balance import balance
from morph.task.chain import posture
from morph.task.push import Push

FAMILIES = (
    "cartpole",
    "rider_rigid_driven",
    "rider_two_links_passive",
    "cart_two_links",
    "rider_rigid_passive",
    "rider_two_links_driven",
    "cart_three_links",
    "rider_three_links_driven",
)
"""Bodies of the shelf about which others are drawn."""

PUSHES = (0.6, 0.4, 0.25, 0.15, 0.1, 0.06, 0.03)
"""What a push may give the last link, m/s: from one of the first four by chance, weakened until
the oracle bears it."""

EFFORTS = (0.1, 1.0, 10.0)
"""What effort may cost a regulator, in shares of the commands' bounds."""

HELD = 0.95
"""What the oracle scores at least."""

SPRUNG = 0.35
"""Share of the bodies whose hinges have springs: most of these stand by themselves, so that
a policy can do harm that is worth the name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Kin:
    """A body, the policy made for it with its true model, and what both oracles score."""

    name: str
    """Its family, seed and number."""
    family: str
    """The body of the shelf that it was drawn about."""
    body: Body
    """The body with its task."""
    gain: Array
    """K of its own policy u = K x, shape (nu, n)."""
    own: float
    """What its own policy scores."""
    still: float
    """What holding still scores."""


def kin(seed: int, number: int) -> Kin:
    """Return a body drawn about one of the shelf.

    Raises:
        SearchError: No draw of twenty is a body that its own policy holds.
    """
    named = FAMILIES[(4 * seed + number) % len(FAMILIES)]
    rng = np.random.default_rng([seed, number, 71])
    for _ in range(20):
        found = _fair(f"{named} {seed}.{number}", named, drawn(load(named), rng), rng)
        if found is not None:
            return found
    raise SearchError(
        "its own policy holds none of twenty draws",
        where=f"bodies about {named}",
        fix="draw them nearer to the body of the shelf",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """A body whose policy is carried to others."""

    name: str
    """Its family, seed and number."""
    body: Body
    """The body with its task."""
    gain: Array
    """K of its policy u = K x, shape (nu, n)."""


def source(family: str, rng: np.random.Generator | None, name: str) -> Source:
    """Return a body and the regulator of its true model; the shelf's own body without chance."""
    robot = load(family) if rng is None else drawn(load(family), rng)
    found = body(balance(robot))
    A, B = found.linear
    gain = regulator(A, B, found.outcome, found.bounds, 1.0)
    return Source(name=name, body=found, gain=gain)


@lru_cache(maxsize=len(FAMILIES))
def described(family: str) -> Source:
    """Return the body of the shelf itself, as its description states it."""
    return source(family, None, family)


def drawn(robot: Robot, rng: np.random.Generator) -> Robot:
    """Return a body of other lengths, masses and motors, some axes mirrored, without stops."""
    links = [link.name for link in robot.links if link.mass > 0.0]
    made: list[Operation] = [Scale(link="*", factor=float(np.exp(rng.normal(0.0, 0.2))))]
    for name in links[1:]:
        made.append(Scale(link=name, factor=float(rng.uniform(0.7, 1.4))))
    for name in links:
        made.append(Heavier(link=name, factor=float(np.exp(rng.normal(0.0, 0.4)))))
    varied = _rewired(vary(robot, *made), rng)
    return _sprung(varied, rng) if rng.random() < SPRUNG else varied


def _sprung(robot: Robot, rng: np.random.Generator) -> Robot:
    """Return a body whose hinges have springs that nearly, or well, hold it upright."""
    top = posture(robot, "balance", upright=True)
    model = spec_of(robot).compile()
    q, _ = started(robot, model, top, {})
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    # One hinge stands at a stiffness of m g h; of a chain each needs more than that.
    least, most = (0.9, 1.8) if len(top) == 1 else (1.5, 3.0)
    factor, lag = float(rng.uniform(least, most)), float(rng.uniform(0.01, 0.05))
    springs = []
    for hinge, rest in top.items():
        at = model.joint(hinge).id
        link = int(model.jnt_bodyid[at])
        height = float(data.subtree_com[link][2] - data.xanchor[at][2])
        stiffness = factor * float(model.body_subtreemass[link]) * 9.81 * height
        springs.append(
            Stiffen(joint=hinge, stiffness=stiffness, damping=lag * stiffness, rest=rest)
        )
    return vary(robot, *springs)


def _rewired(robot: Robot, rng: np.random.Generator) -> Robot:
    """Return a body some of whose axes point the other way and whose motors are others."""
    spec = bare_spec(robot)
    spec.modelname = robot.name
    marks = []
    for joint in spec.joints:
        # A linear model knows no stops: what leans on one is a body of another kind.
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        if rng.random() < 0.2:
            joint.axis = -np.asarray(joint.axis)
            marks.append(joint.name)
    for actuator in spec.actuators:
        factor = float(np.exp(rng.normal(0.0, 0.35)))
        gear = np.array(actuator.gear)
        gear[0] *= factor
        actuator.gear = gear
        marks.append(f"{actuator.name} {factor:.6g}")
    name = f"{robot.name}+rewired"
    return edited(robot, spec, name, sha256(robot.sha256, *marks))


def _fair(name: str, family: str, robot: Robot, rng: np.random.Generator) -> Kin | None:
    """Return the body under the strongest push that its oracle bears, if there is one."""
    task = balance(robot)
    noise = task.noise * float(rng.uniform(0.5, 1.5))
    first = int(rng.integers(4))
    last = robot.links[-1]
    for speed in PUSHES[first:]:
        push = Push(link=last.name, impulse=(speed * last.mass, 0.0, 0.0), offset=last.com)
        found = body(replace(task, noise=noise, start=replace(task.start, push=push)))
        gain, own = oracle(found)
        if own >= HELD:
            still = found.score(still_law(len(found.bounds[0])), rows=10)
            return Kin(name=name, family=family, body=found, gain=gain, own=own, still=still)
    return None


def oracle(found: Body, *, rows: int = 10) -> tuple[Array, float]:
    """Return the best of a few regulators of the true model, and what it scores."""
    A, B = found.linear
    best, most = np.zeros((B.shape[1], len(A))), 0.0
    for effort in EFFORTS:
        try:
            gain = regulator(A, B, found.outcome, found.bounds, effort)
        except SearchError:
            continue
        score = found.score(linear_law(gain), rows=rows)
        if score > most + 0.003:
            best, most = gain, score
    return best, most


def regulator(
    A: Array, B: Array, outcome: Array, bounds: tuple[Array, Array], effort: float
) -> Array:
    """Return the gain of the regulator of a linear model, with an effort that costs so much."""
    half = 0.5 * np.minimum(bounds[1] - bounds[0], 2.0 * np.pi)
    # The task sees only the whole body's lean; a little of every number keeps links from folding.
    cost = outcome.T @ outcome + 0.05 * np.eye(len(A))
    return lqr(A, B, cost, np.diag(effort / half**2), where="a linear model").gain
