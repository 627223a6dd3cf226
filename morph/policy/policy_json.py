"""Write and read policy.json."""

from __future__ import annotations

from functools import cache
from importlib import metadata

import morph
from morph.arrays import JSON
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.files import sha256
from morph.policy.adjusted import Adjusted
from morph.policy.fields import most_of, number_of, table_of, tables_of, text_of
from morph.policy.kinds import KINDS
from morph.policy.observing import check_channels
from morph.policy.policy import Action, Observation, Policy, actions_of

SCHEMA = "morph.policy/1"
"""The only schema of policies so far."""

MOST_PARTS = 1000
"""Most actions, and most observations."""

version = cache(metadata.version)
"""The version of an installed package, read once: a loop writes a policy for each trial."""


def said_of(
    policy: Policy, robot: Robot, *, task: str, task_sha256: str, learned: JSON | None
) -> JSON:
    """Return what a policy's file says of it, but for its numbers."""
    return {
        "schema": SCHEMA,
        "kind": policy.kind,
        "robot": {"name": robot.name, "sha256": hash_of(robot)},
        "task": {"name": task, "sha256": task_sha256},
        "observation": [vars(each) for each in policy.observation],
        "action": [vars(each) for each in policy.action],
        "control_period_s": policy.period,
        "hold": "zero-order",
        "parts": _parts(policy),
        "learned": learned,
        "provenance": {"morph": morph.__version__, "mujoco": version("mujoco")},
    }


def _parts(policy: Policy) -> JSON:
    """Return what a policy consists of beside numbers; its weights hold the parts themselves."""
    return {policy.kind: {"source": policy.source.kind}} if isinstance(policy, Adjusted) else {}


def hash_of(robot: Robot) -> str:
    """Return the hash of a robot's description and card."""
    return robot.sha256 or sha256(robot.mjcf)


def kind_of(document: JSON, where: str) -> type[Policy]:
    """Return the kind of policy that a file speaks of.

    Raises:
        PolicyError: The schema or the kind is unknown.
    """
    if document.get("schema") != SCHEMA:
        raise PolicyError(
            f"its schema is {most_of(document.get('schema'))}",
            where=where,
            fix=f"give a policy of schema {SCHEMA}",
        )
    kinds = {kind.kind: kind for kind in KINDS}
    kind = text_of(document, "kind", where)
    if kind not in kinds:
        raise PolicyError(
            f"its kind is {most_of(kind)}", where=where, fix=f"use one of {', '.join(kinds)}"
        )
    return kinds[kind]


def check_robot(document: JSON, robot: Robot, where: str) -> None:
    """Check that a file speaks of a policy for this very robot, held as we hold commands.

    Raises:
        PolicyError: It was made for another, or holds its commands otherwise.
    """
    body = table_of(document, "robot", where)
    hashed = hash_of(robot)
    if text_of(body, "sha256", where) != hashed:
        raise PolicyError(
            f"it was made for {most_of(text_of(body, 'name', where))}, whose description and card "
            f"have the hash {most_of(body['sha256'])}; those of {robot.name} have {hashed}",
            where=where,
            fix="give the robot it was made for, or make it again for this one",
        )
    if text_of(document, "hold", where) != "zero-order":
        raise PolicyError(
            f"hold is {most_of(document['hold'])}", where=where, fix='write "hold": "zero-order"'
        )


def actions_said(document: JSON, where: str) -> tuple[Action, ...]:
    """Return the actions that a file speaks of."""
    return tuple(
        Action(
            actuator=text_of(each, "actuator", where),
            unit=text_of(each, "unit", where),
            low=number_of(each, "low", where),
            high=number_of(each, "high", where),
        )
        for each in tables_of(document, "action", MOST_PARTS, where)
    )


def observations_said(document: JSON, where: str) -> tuple[Observation, ...]:
    """Return the observations that a file speaks of."""
    return tuple(
        Observation(
            channel=text_of(each, "channel", where),
            unit=text_of(each, "unit", where),
            offset=number_of(each, "offset", where),
            scale=number_of(each, "scale", where),
            history=_count(each, "history", where),
            delay_s=number_of(each, "delay_s", where),
        )
        for each in tables_of(document, "observation", MOST_PARTS, where)
    )


def _count(document: JSON, key: str, where: str) -> int:
    number = number_of(document, key, where)
    if not number.is_integer():
        raise PolicyError(
            f"{key} is {number:g}, not a whole number", where=where, fix=f'write "{key}": 1'
        )
    return int(number)


def check_body(policy: Policy, robot: Robot, *, where: str) -> None:
    """Check that actions are the robot's actuators in its order, and that it can be observed.

    Raises:
        PolicyError: An actuator or a channel is not the robot's, or not in that unit.
    """
    results = [(each.actuator, each.unit) for each in policy.action]
    wanted = [(each.actuator, each.unit) for each in actions_of(robot)]
    if results != wanted:
        raise PolicyError(
            f"it commands {most_of(_listed(results))}, "
            f"and the actuators of {robot.name} are {_listed(wanted)}",
            where=where,
            fix="give the robot it was made for",
        )
    check_channels(policy, robot, where=where)


def _listed(parts: list[tuple[str, str]]) -> str:
    return ", ".join(f"{name} ({unit})" for name, unit in parts) or "none"
