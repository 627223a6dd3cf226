"""What a relay along a chain of bodies found as `transfer.json` tells it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import ClassVar

import morph
from morph.arrays import JSON
from morph.files import sha256
from morph.policy_transfer.hop_result import Crossing
from morph.policy_transfer.transfer_record import SCHEMA, text_of
from morph.tabular import Tabular
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class RelayRecord(Tabular):
    """A policy carried along a chain, one hop after another."""

    task: Task
    """The first body's task; its body is the source of all."""
    hops: tuple[Crossing, ...]
    """In order; the target of one is the source of the next."""
    policy: bool
    """Whether a policy of the last body is kept beside it."""
    seed: int
    """Random seed."""
    seconds: float
    """Time that was spent, s."""
    command: str
    """The command that led to it."""
    inputs: Mapping[str, str]
    """Hashes of the bodies and of the policy that were given."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    axes: ClassVar[tuple[str, ...]] = ("target", "final", "no_source")

    def __repr__(self) -> str:
        return f"RelayRecord({' > '.join([self.hops[0].source, *(h.target for h in self.hops)])})"

    def rows(self) -> list[JSON]:
        """Return one row a hop: transitions, the guard's verdict, scores relative to the oracle."""
        return [
            {
                "source": hop.source,
                "target": hop.target,
                "samples": hop.samples,
                "guard": hop.guard.verdict,
                **hop.scores,
            }
            for hop in self.hops
        ]

    @property
    def samples(self) -> int:
        """Transitions of all targets together."""
        return sum(hop.samples for hop in self.hops)

    def said(self) -> JSON:
        """Return all of it by the schema morph.transfer/1."""
        robot = self.task.robot
        return {
            "schema": SCHEMA,
            "chain": [self.hops[0].source, *(hop.target for hop in self.hops)],
            "hops": [hop.said() for hop in self.hops],
            "samples_total": self.samples,
            "policy": "policy/" if self.policy else None,
            "task": {"name": self.task.name, "sha256": self.task.sha256},
            "robot": {"name": robot.name, "sha256": robot.sha256 or sha256(robot.mjcf)},
            "sealed": None,
            "seed": self.seed,
            "seconds": self.seconds,
            "notes": list(self.notes),
            "provenance": {
                "morph": morph.__version__,
                "mujoco": version("mujoco"),
                "command": self.command,
                "inputs": dict(self.inputs),
            },
        }

    def text(self) -> str:
        """Return the text of `transfer.json`; a number that is not finite is null.

        Raises:
            OutputError: It holds what JSON cannot.
        """
        return text_of(self.said())


def hashes(inputs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return the hash of each input by its name; those that share a name are numbered.

    Args:
        inputs: Names and hashes in order; what is given twice stands there once.
    """
    results: dict[str, str] = {}
    for name, value in inputs:
        numbered, at = name, 1
        while results.get(numbered, value) != value:
            at += 1
            numbered = f"{name} {at}"
        results[numbered] = value
    return results
