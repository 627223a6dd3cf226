"""The policy in use, the one before it, and the one that waits to be taken into use."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from morph.body.robot import Robot
from morph.errors import MorphError, PolicyError
from morph.files import sha256, write_whole
from morph.policy.files import FILES, MOST_BYTES
from morph.policy.policy import Policy, actions_of
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.link.offer import files_of, refused
from morph.regular_file import read_regular

STATE = "policies.json"
"""The file that says which policy is which; each change of it is whole or not at all."""

MOST_STATE = 2**20
"""Longest `policies.json`, bytes; a number each of a hundred thousand policies."""

SCHEMA = "morph.policies/1"
"""Its schema."""

MOST_VERSIONS = 10**9
"""Greatest version of a policy."""

Verify = Callable[[Policy], str | None]
"""Says why a policy is not safe, in words; None if it is."""


class Policies:
    """The safe policies of one robot, on the disk.

    A policy that is offered is checked whole before it is kept: its hash, its body, the actions
    stored with it, its period, its bounds, and what `verify` says, such as runs in simulation. It
    waits until `between_trials`, and the one in use stays beside it, to go back to.

    Args:
        folder: Where they are kept.
        robot: The body that they command.
        first: The policy that is safe to begin with, version 0; a folder that has one keeps it.
        verify: A check of one's own.

    Raises:
        PolicyError: The first policy is not this robot's.
    """

    def __init__(
        self, folder: Path, robot: Robot, first: Policy, *, verify: Verify | None = None
    ) -> None:
        self._folder, self._robot, self._verify = folder, robot, verify
        self._first, self._period = first, first.period
        self.notes: list[str] = []
        """Which policies were left, and why, in words."""
        if not (folder / "0" / FILES[-1]).is_file():
            write_policy(first, folder / "0", robot)
        state = _state(folder / STATE)
        self._safe: list[int] = state["safe"]
        self._newest: int = state["newest"]
        self._staged: int | None = state["staged"]
        self.policy = self._restored()

    @property
    def version(self) -> int:
        """The version of the policy in use."""
        return self._safe[-1]

    def offer(self, message: Mapping[str, Any]) -> None:
        """Keep an offered policy for the time between trials, if it is newer and safe.

        Raises:
            TransferError: It is not; the message says why.
        """
        version = message.get("version")
        if type(version) is not int or not 1 <= version <= MOST_VERSIONS:
            raise refused(f"its version is no number from 1 to {MOST_VERSIONS}")
        folder = self._folder / str(version)
        files = files_of(message, self._robot)
        if version == self._newest and _holds(folder, files):
            # The very same, said again after a kill: it was taken then.
            return
        if version <= self._newest:
            raise refused(f"its version is {version}, and {self._newest} was offered already")
        for name in FILES:
            write_whole(folder / name, files[name])
        self._check(folder)
        self._staged = self._newest = version
        self._write()

    def between_trials(self) -> Policy:
        """Return the policy for the next trial: the newest that proved to be safe."""
        if self._staged is not None:
            staged, self._staged = self._staged, None
            try:
                self.policy = self._check(self._folder / str(staged))
                self._safe.append(staged)
            except MorphError as error:
                # It was sound when it came; the policy in use stays.
                self.notes.append(f"version {staged} is not taken into use: {error.what}")
            self._write()
        return self.policy

    def withdraw(self) -> int:
        """Go back to the policy that was in use before; return its version.

        The first stays, whatever it does: there is none before it.
        """
        if len(self._safe) > 1:
            self._safe.pop()
            self.policy = self._restored()
            self._write()
        return self.version

    def _check(self, folder: Path) -> Policy:
        """Return the policy of a folder, once it is known to be safe.

        Raises:
            TransferError: It commands otherwise than the body or the policies before it allow.
        """
        try:
            policy = load_policy(folder, self._robot)
        except PolicyError as error:
            raise refused(error.what) from error
        if abs(policy.period - self._period) > 1e-9:
            raise refused(f"its period is {policy.period:g} s, not {self._period:g} s")
        for mine, its in zip(actions_of(self._robot), policy.action, strict=True):
            if its.low < mine.low or its.high > mine.high:
                raise refused(
                    f"it may command {its.actuator} from {its.low:g} to {its.high:g} {its.unit}, "
                    f"and the body takes {mine.low:g} to {mine.high:g}"
                )
        why = self._verify(policy) if self._verify is not None else None
        if why is not None:
            raise refused(why)
        return policy

    def _restored(self) -> Policy:
        """Return the newest safe policy that can still be read; versions that cannot are left."""
        while True:
            try:
                return load_policy(self._folder / str(self._safe[-1]), self._robot)
            except PolicyError as error:
                self.notes.append(f"version {self._safe[-1]} is left: {error.what}")
                if len(self._safe) == 1:
                    return self._first
                self._safe.pop()

    def _write(self) -> None:
        document = {"safe": self._safe, "newest": self._newest, "staged": self._staged}
        body = json.dumps(document)
        write_whole(
            self._folder / STATE,
            json.dumps({"schema": SCHEMA, "sha256": sha256(body), "state": document}) + "\n",
        )


def _holds(folder: Path, files: Mapping[str, bytes]) -> bool:
    try:
        return all(read_regular(folder / name, MOST_BYTES[name]) == files[name] for name in FILES)
    except OSError:
        return False


def _state(path: Path) -> dict[str, Any]:
    """Return what a file says of the policies; that there is the first alone if it is spoilt."""
    try:
        document = json.loads(read_regular(path, MOST_STATE))
        state = document["state"]
        if document["sha256"] == sha256(json.dumps(state)) and document["schema"] == SCHEMA:
            return dict(state)
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        pass
    return {"safe": [0], "newest": 0, "staged": None}
