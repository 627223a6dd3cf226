"""Simulated targets: as described, a little off, ten percent off, far off, or concealed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from experiments.transfer.changed import cartpole
from morph.arrays import Array
from morph.model.hypothesis import Hypothesis
from morph.model.latent.run import Run
from morph.model.latent.unknowns import unknowns
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.actuator.torque_scale import TorqueScale
from morph.physics.effect import Effect
from morph.physics.joint.armature import Armature
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.quadratic_damping import QuadraticDamping
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.sim.rollout import Variant, rollout
from morph.sim.simulator import Simulator
from morph.task.run import run
from morph.task.swing_up import swing_up
from morph.task.task import Task

FAMILIES: Mapping[str, float] = {
    "unchanged": 0.15,
    "small": 0.25,
    "ten": 0.20,
    "friction": 0.08,
    "large": 0.12,
    "concealed": 0.20,
}
"""Shares of the kinds of target."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A target, one run of a policy on it, and what is true of it."""

    seed: int
    """Of the case."""
    family: str
    """The kind of target."""
    label: str
    """What differs."""
    policy: int
    """Number of the policy that ran."""
    task: Task
    """The task on the target's robot."""
    effects: tuple[Effect, ...]
    """What acts on the target beyond its description."""
    run: Run
    """What was observed."""
    state: Array = field(repr=False)
    """What truly happened, shape (periods + 1, n)."""
    error: Array = field(repr=False)
    """The nominal model's true error at each transition, shape (periods, n)."""
    loss: float
    """What the run cost."""


def drawn(seed: int, policies: Sequence[Policy]) -> Case:
    """Return the case of a seed: its family, its figures, its policy and its noise."""
    rng = np.random.default_rng(seed)
    names = list(FAMILIES)
    family = names[int(rng.choice(len(names), p=list(FAMILIES.values())))]
    factors, effects = differing(family, rng)
    return case(seed, family, factors, effects, policies, rng)


def case(
    seed: int,
    family: str,
    factors: Mapping[str, float],
    effects: tuple[Effect, ...],
    policies: Sequence[Policy],
    rng: np.random.Generator,
) -> Case:
    """Return the case of a target that is told."""
    at = int(rng.integers(len(policies)))
    task = swing_up(cartpole(factors))
    simulator = task.simulator(effects)
    seen, true, command, loss = recorded(task, simulator, policies[at], rng)
    half = true.shape[1] // 2
    label = " ".join([f"{k} x{v:.3g}" for k, v in factors.items()] + [e.label for e in effects])
    return Case(
        seed=seed,
        family=family,
        label=label or "as described",
        policy=at,
        task=task,
        effects=effects,
        run=Run(
            position=seen[:, :half], velocity=seen[:, half:], command=command, period=task.period
        ),
        state=true,
        error=true[1:] - ahead(model(), true[:-1], command, task.period),
        loss=loss,
    )


def differing(
    family: str, rng: np.random.Generator
) -> tuple[Mapping[str, float], tuple[Effect, ...]]:
    """Return factors on the thesis' parameters and effects, drawn for a family."""
    sign = 1.0 if rng.random() < 0.5 else -1.0
    if family == "unchanged":
        return {}, ()
    if family == "small":
        name = str(rng.choice(["g", "l", "m", "M", "b"]))
        most = math.log(2.5) if name == "b" else 0.04
        return {name: math.exp(sign * rng.uniform(0.0, most))}, ()
    if family == "ten":
        return {str(rng.choice(["l", "m", "M"])): 1.0 + 0.1 * sign}, ()
    if family == "friction":
        return {"b": 3.0}, ()
    if family == "large":
        name = str(rng.choice(["g", "l", "m", "M", "b"]))
        most = 11.0 if name == "b" else 2.5
        return {name: math.exp(sign * rng.uniform(math.log(1.2), math.log(most)))}, ()
    return {}, (concealed(rng),)


def concealed(rng: np.random.Generator) -> Effect:
    """Return an effect of the library that nobody is told of, from faint to strong."""
    strength = math.exp(rng.uniform(math.log(0.03), 0.0))
    joint = str(rng.choice(["slide", "hinge"]))
    full = 1.5 if joint == "slide" else 0.1
    kind = int(rng.integers(9))
    if kind == 0:
        return CoulombFriction(joint=joint, c=full * strength)
    if kind == 1:
        return StribeckFriction(joint=joint, c=0.5 * full * strength, s=full * strength)
    if kind == 2:
        return ViscousFriction(joint=joint, b=full * strength)
    if kind == 3:
        return QuadraticDamping(joint=joint, b2=full * strength)
    if kind == 4:
        return Armature(joint=joint, J=(0.3 if joint == "slide" else 0.01) * strength)
    if kind == 5:
        return JointStiffness(joint=joint, k=(6.0 if joint == "slide" else 0.5) * strength)
    if kind == 6:
        return TorqueScale(actuator="slide", gain=1.0 - 0.5 * strength)
    if kind == 7:
        return ActuatorDelay(actuator="slide", T=0.03 * strength)
    return ActuatorLag(actuator="slide", T=0.03 * strength)


def recorded(
    task: Task, simulator: Simulator, policy: Policy, rng: np.random.Generator
) -> tuple[Array, Array, Array, float]:
    """Return observed states, true states, commands and the loss of one run."""
    body = simulator.model
    position, velocity = task.start.sample(task.robot, body, 1, rng)
    away = rng.normal(scale=task.noise, size=(task.samples, body.nq + body.nv))
    observer = Observer(policy, task.robot, body, 1)

    def act(q: Array, v: Array, time: float) -> Array:
        off = away[round(time / task.period)]
        return policy.act(observer.see(q + off[: body.nq], v + off[body.nq :]), np.full(1, time))

    moved = run(task, simulator, act, position, velocity)
    true = np.concatenate([moved.position[0], moved.velocity[0]], axis=1)
    return true + away, true, moved.command[0, :-1], float(task.loss(moved)[0])


def ahead(simulator: Simulator, state: Array, command: Array, period: float) -> Array:
    """Return where states lead in one control period of a simulator, shape (rows, n)."""
    half, steps = state.shape[1] // 2, round(period / simulator.step)
    held = np.repeat(command[:, None], steps, axis=1)
    only = Variant(model=simulator.model, effects=simulator.effects)
    q, v = rollout([only], np.zeros(len(state), dtype=int), state[:, :half], state[:, half:], held)
    return np.concatenate([q[:, -1], v[:, -1]], axis=1)


@cache
def nominal() -> Task:
    """Return the task on the robot as it is described."""
    return swing_up(cartpole())


@cache
def model() -> Simulator:
    """Return the robot as it is described, simulated."""
    return nominal().simulator()


@cache
def hypothesis() -> Hypothesis:
    """Return the model that is judged, with every figure that may be wrong in it."""
    task = nominal()
    return Hypothesis(robot=task.robot, step=task.step, knobs=unknowns(task.robot))


def noise() -> Array:
    """Return the standard deviation of each observation, shape (n,)."""
    return np.full(model().model.nq + model().model.nv, nominal().noise)
