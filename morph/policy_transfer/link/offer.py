"""A policy and an experience as the content of messages, read with distrust."""

from __future__ import annotations

import base64
import binascii
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.files import sha256
from morph.policy.files import FILES, MOST_BYTES
from morph.policy.policy import Policy
from morph.policy.policy_json import hash_of
from morph.policy.store import write_policy
from morph.regular_file import read_regular
from morph.search.target import Experience

MOST_SAMPLES = 100_000
"""Most samples of an experience."""


def offer_of(policy: Policy, robot: Robot, *, version: int) -> JSON:
    """Return a policy as a message: its files, their hash, the body's hash and a version.

    Raises:
        PolicyError: It does not command this robot.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = write_policy(policy, Path(folder) / "policy", robot)
        files = {name: read_regular(path / name, MOST_BYTES[name]) for name in FILES}
    return {
        "version": version,
        "robot_sha256": hash_of(robot),
        "sha256": sha256(*(files[name] for name in FILES)),
        "files": {name: base64.b64encode(data).decode() for name, data in files.items()},
    }


def files_of(offer: Mapping[str, Any], robot: Robot) -> dict[str, bytes]:
    """Return the files of an offered policy, once they have proved to be whole and this body's.

    Raises:
        TransferError: They are not.
    """
    if offer.get("robot_sha256") != hash_of(robot):
        raise refused(f"it is for another body than {robot.name}")
    statement = offer.get("files")
    files: dict[str, bytes] = {}
    for name in FILES:
        text = statement.get(name) if isinstance(statement, dict) else None
        # Base64 has four characters for three bytes.
        if not isinstance(text, str) or len(text) > 2 * MOST_BYTES[name]:
            raise refused(f"it has no {name}, or one that is too large")
        try:
            files[name] = base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError) as error:
            raise refused(f"its {name} is no base64: {error}") from error
    if sha256(*(files[name] for name in FILES)) != offer.get("sha256"):
        raise refused("its files do not have its hash")
    return files


def refused(what: str) -> TransferError:
    """Return the error of a policy that is not taken into use."""
    return TransferError(
        what, where="an offered policy", fix="the policy in use stays; offer another"
    )


def experience_said(shown: Experience, *, version: int, stopped: str = "") -> JSON:
    """Return an experience as a message.

    Args:
        shown: What a trial showed.
        version: The version of the policy that was tried.
        stopped: Why the trial ended early; empty if it did not.
    """
    return {
        "position": shown.position.tolist(),
        "velocity": shown.velocity.tolist(),
        "command": shown.command.tolist(),
        "period_s": shown.period,
        "loss": shown.loss,
        "success": shown.success,
        "version": version,
        "stopped": stopped,
    }


def experience_of(message: Mapping[str, Any]) -> Experience:
    """Return the experience that a message speaks of.

    Raises:
        TransferError: It is none.
    """
    try:
        position, velocity, command = (
            _table(message[name]) for name in ("position", "velocity", "command")
        )
        period, loss = float(message["period_s"]), float(message["loss"])
    except (KeyError, TypeError, ValueError) as error:
        raise _no_experience(f"it lacks a part, or has one that is none: {error!r}") from error
    samples = len(position)
    fits = len(velocity) == samples == len(command) + 1 and 1 < samples <= MOST_SAMPLES
    if not fits or not period > 0.0:
        raise _no_experience(
            f"it has {samples} positions, {len(velocity)} velocities and {len(command)} commands"
        )
    return Experience(
        position=position,
        velocity=velocity,
        command=command,
        period=period,
        loss=loss,
        success=message.get("success") is True,
    )


def _table(rows: object) -> Array:
    table = np.array(rows, dtype=float)
    if table.ndim != 2 or not np.isfinite(table).all():
        raise ValueError("not a table of finite numbers")
    return table


def _no_experience(what: str) -> TransferError:
    return TransferError(what, where="an experience", fix="send what `experience_said` makes")
