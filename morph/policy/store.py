"""A policy as a folder of `policy.json` and `weights.safetensors`, checked when it is read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.files import sha256, write_whole
from morph.policy.fields import most_of, number_of, table_of, tables_of, text_of
from morph.policy.files import FILES, read_json, read_tensors
from morph.policy.pattern import Pattern
from morph.policy.policy import Action, Observation, Policy, actions_of

SCHEMA = "morph.policy/1"
"""The only schema of policies so far."""

KINDS: tuple[type[Policy], ...] = (Pattern,)
"""Every kind of policy that can be read."""

MOST_PARTS = 1000
"""Most actions, and most observations."""

REPLAYED = 64
"""How many actions are stored, to be replayed when the policy is read."""

MOST_REPLAYED = 10_000
"""Most that are replayed."""

TOLERANCE = 1e-6
"""How near a replayed action must come to the stored one, in its unit or, above 1, relative."""


def write_policy(
    policy: Policy,
    folder: Path,
    robot: Robot,
    *,
    task: str = "",
    learned: JSON | None = None,
    seconds: float = 10.0,
) -> Path:
    """Return the folder that a policy was written to, with actions to check it by.

    Args:
        policy: What to write.
        folder: A new folder, an empty one, or one that holds an earlier policy.
        robot: The body that it commands.
        task: What it is for, in a word.
        learned: How it was found; None for one written by hand.
        seconds: How much of it is stored to be replayed.

    Raises:
        PolicyError: It does not command this robot.
        OutputError: The folder cannot be written to.
    """
    _check_body(policy, robot, where=str(folder))
    if folder.is_dir() and any(folder.iterdir()) and not (folder / FILES[-1]).is_file():
        raise PolicyError(
            "the folder is not empty and holds no earlier policy",
            where=str(folder),
            fix="name a new or an empty folder",
        )
    said = json.dumps(_said(policy, robot, task, learned), indent=1, allow_nan=False) + "\n"
    # `policy.json` comes last: it makes the folder a policy.
    write_whole(folder / FILES[0], _bytes(_tensors(policy, seconds)))
    write_whole(folder / FILES[1], said)
    return folder


def load_policy(path: str | Path, robot: Robot) -> Policy:
    """Return the policy of a folder, once it has proved to be this robot's and unspoilt.

    Raises:
        PolicyError: A file is missing, too large or not what it should be; the policy
            belongs to another body; or its numbers do not give the actions stored with them.
    """
    folder = Path(path)
    said = read_json(folder / "policy.json")
    where = str(folder / "policy.json")
    if said.get("schema") != SCHEMA:
        raise PolicyError(
            f"its schema is {most_of(said.get('schema'))}",
            where=where,
            fix=f"give a policy of schema {SCHEMA}",
        )
    kinds = {kind.kind: kind for kind in KINDS}
    kind = text_of(said, "kind", where)
    if kind not in kinds:
        raise PolicyError(
            f"its kind is {most_of(kind)}", where=where, fix=f"use one of {', '.join(kinds)}"
        )
    body = table_of(said, "robot", where)
    hashed = _hash(robot)
    if text_of(body, "sha256", where) != hashed:
        raise PolicyError(
            f"it was made for {most_of(text_of(body, 'name', where))}, whose description and card "
            f"have the hash {most_of(body['sha256'])}; those of {robot.name} have {hashed}",
            where=where,
            fix="give the robot it was made for, or make it again for this one",
        )
    if text_of(said, "hold", where) != "zero-order":
        raise PolicyError(
            f"hold is {most_of(said['hold'])}", where=where, fix='write "hold": "zero-order"'
        )
    tensors = read_tensors(folder / "weights.safetensors")
    weights = {name: value for name, value in tensors.items() if not name.startswith("replay.")}
    policy = kinds[kind].of(
        weights,
        action=tuple(_action(each, where) for each in tables_of(said, "action", MOST_PARTS, where)),
        observation=tuple(
            _observation(each, where) for each in tables_of(said, "observation", MOST_PARTS, where)
        ),
        period=number_of(said, "control_period_s", where),
    )
    _check_body(policy, robot, where=where)
    _replay(policy, tensors, folder / "weights.safetensors")
    return policy


def _said(policy: Policy, robot: Robot, task: str, learned: JSON | None) -> JSON:
    return {
        "schema": SCHEMA,
        "kind": policy.kind,
        "robot": {"name": robot.name, "sha256": _hash(robot)},
        "task": {"name": task, "sha256": ""},
        "observation": [vars(each) for each in policy.observation],
        "action": [vars(each) for each in policy.action],
        "control_period_s": policy.period,
        "hold": "zero-order",
        "parts": {},
        "learned": learned,
        "provenance": {"morph": version("morph"), "mujoco": version("mujoco")},
    }


def _hash(robot: Robot) -> str:
    return robot.sha256 or sha256(robot.mjcf)


def _tensors(policy: Policy, seconds: float) -> dict[str, Array]:
    # Fixed seed: the same policy is written as the same bytes.
    rng = np.random.default_rng(0)
    time = np.sort(rng.uniform(0.0, seconds, REPLAYED))
    observation = rng.normal(size=(REPLAYED, len(policy.observation)))
    stored = {
        "replay.time": time,
        "replay.observation": observation,
        "replay.action": policy.act(observation, time),
    }
    return {**policy.weights(), **stored}


def _bytes(tensors: Mapping[str, Array]) -> bytes:
    from safetensors.numpy import save

    return bytes(save({name: np.ascontiguousarray(value) for name, value in tensors.items()}))


def _action(said: JSON, where: str) -> Action:
    return Action(
        actuator=text_of(said, "actuator", where),
        unit=text_of(said, "unit", where),
        low=number_of(said, "low", where),
        high=number_of(said, "high", where),
    )


def _observation(said: JSON, where: str) -> Observation:
    return Observation(
        channel=text_of(said, "channel", where),
        unit=text_of(said, "unit", where),
        offset=number_of(said, "offset", where),
        scale=number_of(said, "scale", where),
        history=int(number_of(said, "history", where)),
        delay_s=number_of(said, "delay_s", where),
    )


def _check_body(policy: Policy, robot: Robot, *, where: str) -> None:
    """Check that the actions are the robot's actuators, in its order and units."""
    found = [(each.actuator, each.unit) for each in policy.action]
    wanted = [(each.actuator, each.unit) for each in actions_of(robot)]
    if found != wanted:
        raise PolicyError(
            f"it commands {most_of(_listed(found))}, "
            f"and the actuators of {robot.name} are {_listed(wanted)}",
            where=where,
            fix="give the robot it was made for",
        )
    parts = {each.name for each in robot.joints} | {each.name for each in robot.links}
    for seen in policy.observation:
        if seen.channel.partition(".")[0] not in parts:
            raise PolicyError(
                f"it observes {most_of(seen.channel)}, and {robot.name} has no such part",
                where=where,
                fix="give the robot it was made for",
            )


def _listed(parts: list[tuple[str, str]]) -> str:
    return ", ".join(f"{name} ({unit})" for name, unit in parts) or "none"


def _replay(policy: Policy, tensors: Mapping[str, Array], path: Path) -> None:
    """Check the policy against the actions that were stored with it."""
    time, seen, stored = (
        tensors.get(f"replay.{name}", np.empty(0)) for name in ("time", "observation", "action")
    )
    rows = len(time) if time.ndim == 1 else 0
    shapes = (seen.shape, stored.shape)
    if not 0 < rows <= MOST_REPLAYED or shapes != (
        (rows, len(policy.observation)),
        (rows, len(policy.action)),
    ):
        raise PolicyError(
            "it lacks observations and actions to replay, or holds too many",
            where=str(path),
            fix="write it again",
        )
    again = policy.act(seen, time)
    worst = float(np.max(np.abs(again - stored) / np.maximum(1.0, np.abs(stored)), initial=0.0))
    if not worst <= TOLERANCE:
        raise PolicyError(
            f"replayed, its actions differ from the stored ones by {worst:.2g}",
            where=str(path),
            fix="write it again; its numbers have changed since",
        )
