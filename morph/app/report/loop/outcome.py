"""All that `morph loop` found out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from morph.arrays import JSON
from morph.model.kwik.certify import ModelVerdict
from morph.model.latent.parameter_attribution import Difference
from morph.policy.policy import Policy
from morph.policy_transfer.loop import LoopRound, Transferred
from morph.policy_transfer.repair import Repair
from morph.policy_transfer.score import UNMEASURED, PolicyScores
from morph.policy_transfer.transfer_record import GuardRecord, Hop, Record, guard
from morph.search.target import Experience
from morph.tabular import Tabular
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopOutcome(Tabular):
    """What was tried on a target, what was found to differ, and how good the policy is there."""

    task: Task
    """The source's task."""
    target: str
    """What the target is called."""
    runs: tuple[Experience, ...]
    """What it showed, in order."""
    transferred: Transferred | None
    """What the loop gave back; None if the target was recorded."""
    repair: Repair | None
    """The last repaired model; None if there is none."""
    judged: PolicyScores | None = None
    """How policies do on a simulated target; None for another."""
    own: float | None = None
    """What the source's policy costs in its own simulation."""
    concealed: Mapping[str, float] | None = None
    """What a simulated target differs in; None if nobody knows."""
    sealed: int | None = None
    """The seed from which that was drawn; None if it was told."""
    asked: ModelVerdict | None = None
    """Whether the model as described is good enough for what was recorded."""
    searched: bool = True
    """Whether a policy might have been searched: after the only trial none is."""
    stopped: str = ""
    """Why it ended before its time; empty if it did not."""
    seed: int
    """Random seed."""
    command: str
    """The command that led to it."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    axes: ClassVar[tuple[str, ...]] = ("trial", "loss")

    def __repr__(self) -> str:
        did = "succeeded" if self.succeeded else "did not succeed"
        return f"LoopOutcome({self.task.name} on {self.target}: {did}, {len(self.runs)} trials)"

    def rows(self) -> list[JSON]:
        """Return one row a trial on the target."""
        return [
            {
                "trial": at,
                "policy": each.tried.origin,
                "loss": each.tried.experience.loss,
                "success": each.tried.experience.success,
            }
            for at, each in enumerate(self.rounds, 1)
        ]

    @property
    def rounds(self) -> tuple[LoopRound, ...]:
        """The trials."""
        return () if self.transferred is None else self.transferred.rounds

    @property
    def policy(self) -> Policy | None:
        """The policy to keep."""
        return None if self.transferred is None else self.transferred.policy

    @property
    def kept(self) -> int:
        """The number of the trial in which the policy to keep was tried, counted from 1."""
        tries = [each.tried.policy for each in self.rounds]
        return next(at for at, each in enumerate(tries, 1) if each is self.policy)

    @property
    def succeeded(self) -> bool:
        """Whether the policy to keep did its task in its trial, and may be relied on."""
        done = self.transferred
        return done is not None and done.succeeded and not self.why

    @property
    def why(self) -> str:
        """Why not; empty if it did, or if nothing was to be tried."""
        if self.stopped or self.transferred is None:
            return self.stopped
        if self.transferred.succeeded and self.guard.verdict == "unsafe":
            return (
                f"its trial reached every goal, but the repaired model promises that in "
                f"{self.guard.probability:.0%} of runs alone"
            )
        if self.transferred.why and not self.searched:
            return (
                "its trial did not reach every goal, and with one trial no policy is searched: "
                "give more by --trials"
            )
        return self.transferred.why

    @property
    def guard(self) -> GuardRecord:
        """What is thought of the policy to keep."""
        return guard(None if self.transferred is None else self.transferred.foreseen)

    @property
    def gate(self) -> ModelVerdict | None:
        """Whether the model as described is good enough; None if that was not asked."""
        first = self.rounds[0].advice if self.rounds else None
        return self.asked if first is None else first.verdict

    @property
    def differences(self) -> tuple[Difference, ...]:
        """What the last model says that differs."""
        return () if self.repair is None else self.repair.explained.differences

    @property
    def experience(self) -> float:
        """Time on the target, s."""
        return sum(run.seconds for run in self.runs)

    def record(self) -> Record:
        """Return what transfer.json tells."""
        hop = Hop(
            task=self.task,
            target=self.target,
            runs=self.runs,
            rounds=self.rounds,
            explained=None if self.repair is None else self.repair.explained,
            guard=self.guard,
            gate=self.gate,
            scores=UNMEASURED if self.judged is None else self.judged.scores(),
            shares={} if self.judged is None else self.judged.shares(),
            succeeded=self.succeeded,
            why=self.why,
        )
        return Record(
            hops=(hop,),
            policy=self.policy is not None,
            seed=self.seed,
            seconds=0.0 if self.transferred is None else self.transferred.seconds,
            command=self.command,
            sealed=self.opened(),
            notes=self.notes,
        )

    def opened(self) -> JSON | None:
        """Return what was concealed, beside what was found of it; None if nothing was."""
        if not self.concealed:
            return None
        results = {each.name: each for each in self.differences}
        rows = []
        for name, value in self.concealed.items():
            one = results.pop(name, None)
            rows.append(
                {
                    "name": name,
                    "value": value,
                    "found": None if one is None else one.value,
                    "low90": None if one is None else one.low90,
                    "high90": None if one is None else one.high90,
                }
            )
        return {"seed": self.sealed, "concealed": rows, "more": list(results)}
