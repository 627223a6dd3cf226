"""A policy for the body that came off the printer: whether it holds, and if not, one that does."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal

from morph.arrays import JSON
from morph.body.robot import Robot
from morph.errors import MakeError, MorphError
from morph.fabrication.match.case import FIRST, Case
from morph.fabrication.match.comparison import ALLOWED, Comparison
from morph.fabrication.match.matcher import Matcher
from morph.fabrication.match.matchers import MATCHERS
from morph.policy.pattern import pattern
from morph.policy.policy import Policy
from morph.policy.policy_json import check_body
from morph.policy_transfer.retask import task_for
from morph.search.evaluate import Score
from morph.search.plan.plan_selection import FAILURE
from morph.sim.threads import one_thread
from morph.task.task import Task

SECONDS = 60.0
"""How long matching may take if nothing else is said, s."""

UNCHANGED = "unchanged"
"""The policy as it was learned."""


@dataclass(frozen=True, kw_only=True)
class MatchTrial:
    """What one way of matching came to, in the runs by which a policy is chosen."""

    by: str
    """The way's name; `unchanged` is the policy as it was learned."""
    loss: float
    """Mean loss of its best policy; inf if it has none."""
    success: float
    """Share of the runs in which that reached every goal."""
    seconds: float
    """How long it took, s."""
    note: str = ""
    """Why it has none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Matched:
    """A policy for a printed body, and how it compares."""

    policy: Policy
    """The policy to keep."""
    task: Task
    """The task of the printed body."""
    verdict: Literal["holds", "matched", "lost"]
    """`holds`: as it was learned. `matched`: another that does. `lost`: none was found in time."""
    by: str
    """The way by which it was found; `unchanged` if it is the policy as it was learned."""
    unchanged: Comparison
    """The policy as it was learned, on the printed body."""
    kept: Comparison
    """The policy to keep there, over the same runs."""
    seconds: float
    """How long judging and matching took, s."""
    seed: int
    """Random seed."""
    tried: tuple[MatchTrial, ...] = field(default=())
    """Every way that was tried, in order."""

    @property
    def what(self) -> str:
        """What was measured, in a sentence or two."""
        before, now = self.unchanged, self.kept
        runs = len(now.printed.loss)
        text = (
            f"{self.task.name}: loss {before.designed.mean:.3g} as designed, "
            f"{before.printed.mean:.3g} as printed with the policy unchanged "
            f"({_percent(before.growth)} of the task's span)"
        )
        if self.by != UNCHANGED:
            text += f", {now.printed.mean:.3g} matched by {self.by} ({_percent(now.growth)})"
        return (
            f"{text}; {now.printed.share:.0%} of {runs} runs succeed, "
            f"{before.designed.share:.0%} as designed; doing nothing costs {before.still.mean:.3g}"
        )

    def said(self) -> JSON:
        """Return all of it as plain data."""
        return {
            "task": self.task.name,
            "verdict": self.verdict,
            "by": self.by,
            "what": self.what,
            "runs": len(self.kept.printed.loss),
            "loss": {
                "designed": _finite(self.kept.designed.mean),
                "unchanged": _finite(self.unchanged.printed.mean),
                "kept": _finite(self.kept.printed.mean),
                "still": _finite(self.kept.still.mean),
            },
            "success": {
                "designed": self.kept.designed.share,
                "unchanged": self.unchanged.printed.share,
                "kept": self.kept.printed.share,
            },
            "growth": {
                "unchanged": _finite(self.unchanged.growth),
                "kept": _finite(self.kept.growth),
                "allowed": ALLOWED,
            },
            "seconds": self.seconds,
            "seed": self.seed,
            "tried": [
                {name: _finite(value) for name, value in vars(each).items()} for each in self.tried
            ],
        }


def rematch(
    policy: Policy,
    task: Task,
    printed: Robot,
    *,
    learned: Policy | None = None,
    seconds: float = SECONDS,
    seed: int = 0,
    matchers: Sequence[Matcher] = MATCHERS,
    progress: Callable[[str], None] = lambda _: None,
) -> Matched:
    """Return the policy that a printed body is to have.

    The policy holds if its mean loss grows by at most `ALLOWED` of the task's span and it
    succeeds as often. If it does not, matchers are tried in their order, what they propose is
    compared in noisy runs of their own, and the best is judged in the runs in which the policy
    was. One that holds, but costs clearly more than it did, is matched too as long as that is
    cheap.

    Args:
        policy: As it was learned, or what commands the printed body until now.
        task: What it was learned for, of the body as it was designed.
        printed: The body as it was printed: parts and joints of the same names.
        learned: What was learned on the designed body, if `policy` was matched already.
        seconds: How long all of it may take, s; judging alone takes about a fifth of it.
        seed: Chance begins from it.
        matchers: The ways that are tried.
        progress: Is told what is going on.

    Raises:
        MakeError: The time is no number of seconds.
        PolicyError: The policy does not command this body.
        SimulationFailed: One of the bodies cannot be simulated.
    """
    if not 0.0 <= seconds < math.inf:
        raise MakeError(
            f"{seconds:g} s is no time", where="matching the policy", fix="give 0 or more"
        )
    check_body(policy, printed, where="matching the policy")
    case = Case(
        policy=policy,
        learned=learned or policy,
        designed=task,
        printed=task_for(task, printed),
        seconds=seconds,
        seed=seed,
        told=progress,
    )
    with one_thread():
        return _found(case, matchers)


def _found(case: Case, matchers: Sequence[Matcher]) -> Matched:
    case.told("judging the policy on the body as designed and as printed")
    rest = pattern(case.designed.robot, {}, period=case.designed.period)
    unchanged = Comparison(
        designed=case.judged(case.learned, on=case.designed),
        printed=case.judged(case.policy),
        still=case.judged(rest, on=case.designed, rows=FIRST),
    )
    policy, by, kept = case.policy, UNCHANGED, unchanged
    record: list[MatchTrial] = []
    if not unchanged.close and case.left > 0.0:
        requested = [each for each in matchers if each.suits(case)]
        if unchanged.holds:
            requested = [each for each in requested if not each.dear]
        best, way = _best(case, unchanged, requested, record) if requested else (policy, by)
        if best is not policy:
            result = _with(unchanged, case.judged(best))
            if (result.steady, -result.growth) > (unchanged.steady, -unchanged.growth):
                policy, by, kept = best, way, result
    return Matched(
        policy=policy,
        task=case.printed,
        verdict=("holds" if by == UNCHANGED else "matched") if kept.holds else "lost",
        by=by,
        unchanged=unchanged,
        kept=kept,
        seconds=time.monotonic() - case.began,
        seed=case.seed,
        tried=tuple(record),
    )


def _best(
    case: Case, unchanged: Comparison, matchers: Sequence[Matcher], record: list[MatchTrial]
) -> tuple[Policy, str]:
    """Return the policy that does best in the runs that choose, and by which way it came."""
    begun = time.monotonic()
    best, way, score = case.policy, UNCHANGED, case.chosen(case.policy)
    record.append(_line(UNCHANGED, score, begun))
    for matcher in matchers:
        if case.left <= 0.0 or _done(matcher, _with(unchanged, score)):
            continue
        begun, own, note = time.monotonic(), None, ""
        try:
            for policy in matcher.proposals(case):
                result = case.chosen(policy)
                if own is None or worth(result) < worth(own):
                    own = result
                if worth(result) < worth(score):
                    best, way, score = policy, matcher.name, result
                if case.left <= 0.0 or _done(matcher, _with(unchanged, result)):
                    break
        except MorphError as error:
            note = error.what
        record.append(_line(matcher.name, own, begun, note or ("" if own else "no time")))
        case.told(f"{matcher.name}: loss {record[-1].loss:.3g}")
    return best, way


def _done(matcher: Matcher, result: Comparison) -> bool:
    """Return whether a policy does so well that a way need not be asked for another."""
    return result.sure if matcher.dear else result.close


def worth(score: Score) -> float:
    """Return what policies are compared by: the loss, and failures on top."""
    return score.mean * (1.0 + FAILURE * (1.0 - score.share))


def _with(unchanged: Comparison, printed: Score) -> Comparison:
    return Comparison(designed=unchanged.designed, printed=printed, still=unchanged.still)


def _line(by: str, score: Score | None, begun: float, note: str = "") -> MatchTrial:
    return MatchTrial(
        by=by,
        loss=math.inf if score is None else score.mean,
        success=0.0 if score is None else score.share,
        seconds=time.monotonic() - begun,
        note=note,
    )


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _percent(share: float) -> str:
    return f"{100.0 * share:+.2g} %"
