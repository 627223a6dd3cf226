"""The errors that morph raises on purpose, each in three parts."""

from __future__ import annotations

from typing import Any


class MorphError(Exception):
    """Base of every error that morph raises on purpose.

    Args:
        what: What was found, with the value and the values allowed.
        where: The file and line, link, channel or sample concerned.
        fix: How to put it right.
    """

    def __init__(self, what: str, *, where: str, fix: str) -> None:
        super().__init__(f"{where}: {what}\n  fix: {fix}")
        self.what, self.where, self.fix = what, where, fix


class RobotError(MorphError):
    """A description or a card cannot be used."""


class DescriptionRefused(RobotError):
    """A description holds no robot that can be simulated.

    Args:
        findings: Everything found in it, `morph.body.finding.DescriptionFinding` each.
    """

    def __init__(self, what: str, *, where: str, fix: str, findings: tuple[Any, ...]) -> None:
        super().__init__(what, where=where, fix=fix)
        self.findings = findings


class MeshError(RobotError):
    """A mesh file cannot be used.

    Args:
        code: Why: `mesh-lfs-stub`, `mesh-empty`, `mesh-unreadable` or `mesh-too-large`.
    """

    def __init__(self, what: str, *, where: str, fix: str, code: str) -> None:
        super().__init__(what, where=where, fix=fix)
        self.code = code


class RecordingError(MorphError):
    """A recording or its binding cannot be used."""


class EffectError(MorphError):
    """An effect is unknown, misplaced, or has a parameter out of bounds."""


class KernelError(MorphError):
    """Compiled code cannot be built, loaded or installed."""


class SimulationFailed(MorphError):
    """A simulation cannot be set up, or became unstable."""


class PolicyError(MorphError):
    """A policy cannot be used, or not on this body."""


class TaskError(MorphError):
    """A task cannot be asked of a body, or its cost is no number."""


class SearchError(MorphError):
    """A search cannot be made on this task, or from this data."""


class StateError(SearchError):
    """What a search is to go on from is not what such a search kept."""


class DiagnosisError(MorphError):
    """A diagnosis cannot be made from what was given."""


class EvidenceError(MorphError):
    """Models cannot be chosen among by what was given."""


class TransferError(MorphError):
    """A policy cannot be carried to a target, or the target cannot be used."""


class TrialStopped(TransferError):
    """A trial on a live target ended before its time; the target was told to stop.

    Args:
        shown: What it showed until then, a `morph.search.target.Experience`; None if nothing.
        pressed: Whether somebody asked for the stop.
        beyond: Whether the body went beyond a limit, which is the policy's doing.
    """

    def __init__(
        self,
        what: str,
        *,
        where: str,
        fix: str,
        shown: Any = None,
        pressed: bool = False,
        beyond: bool = False,
    ) -> None:
        super().__init__(what, where=where, fix=fix)
        self.shown, self.pressed, self.beyond = shown, pressed, beyond


class LinkDropped(TransferError):
    """A link is down: what was to be sent is not sent, and may be sent later."""


class MakeError(MorphError):
    """A body cannot be made, or what was made of it cannot be used."""


class StudyError(MorphError):
    """A study cannot be run, resumed or compared."""


class OutputError(MorphError):
    """A result cannot be written."""


class ViewError(MorphError):
    """What is to be viewed cannot be used, or does not fit what it is viewed with."""


class MissingPackage(MorphError):
    """An optional dependency is not installed."""
