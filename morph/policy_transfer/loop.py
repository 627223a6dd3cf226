"""The loop: try, see where the model errs, repair it, search again, and try again."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from morph.errors import DiagnosisError, EffectError, SimulationFailed, TransferError
from morph.policy.policy import Policy
from morph.policy_transfer.loop_checkpoint import Keep
from morph.policy_transfer.next_action import NextAction, advise
from morph.policy_transfer.predicted_return import PredictedReturn
from morph.policy_transfer.trial_record import TrialRecord
from morph.search.target import Target
from morph.task.task import Task

UNSURE = 0.02
"""What a repaired model may leave out, as a share of a typical change of speed in a period, for its
foresight to be believed against what trials showed."""


LIKELY = 0.5
"""Share of runs that a policy must promise to succeed in to be tried once more after it failed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoopRound:
    """One trial, and what was learned from it."""

    tried: TrialRecord
    """What was tried, and what it showed."""
    advice: NextAction | None
    """What to try next; None if nothing more was asked."""
    seconds: float
    """Time that it took to compute the advice, s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Transferred:
    """What a loop gives back."""

    rounds: tuple[LoopRound, ...]
    """Every trial, in order; the first is the source's policy."""
    policy: Policy
    """The best policy for the target, as far as is known."""
    origin: str
    """Where it comes from."""
    foreseen: PredictedReturn | None
    """What it promises; None if no model could be repaired."""
    succeeded: bool
    """Whether its own trial reached every goal."""
    why: str
    """If not: why, in one sentence."""

    @property
    def seconds(self) -> float:
        """Time that was spent computing, s."""
        return sum(each.seconds for each in self.rounds)

    @property
    def experience(self) -> float:
        """Time on the target, s."""
        return sum(each.tried.experience.seconds for each in self.rounds)


Told = Callable[[LoopRound], None]


@dataclass(frozen=True, kw_only=True)
class TransferLoop:
    """Trials of a policy on a target, each followed by a better model and a better policy.

    Source: Gamboa Higuera 2015, section 3.3, six steps, and section 3.4, the choice between
    adjusting a policy and updating the model.
    """

    trials: int = 5
    """Most trials on the target, that of the source's policy included."""
    seed: int = 0
    """Chance begins from it."""

    def __post_init__(self) -> None:
        """Check the number of trials."""
        if self.trials < 1:
            raise TransferError(
                f"it is given {self.trials} trials",
                where="a loop of transfer",
                fix="give one trial or more; two for a repaired policy to be tried",
            )

    def run(
        self,
        task: Task,
        policy: Policy,
        target: Target,
        *,
        keep: Keep | None = None,
        progress: Told = lambda _: None,
        say: Callable[[str], None] = lambda _: None,
    ) -> Transferred:
        """Return the best policy for a target, found in a few trials on it.

        Args:
            task: The source's task: its body as described.
            policy: The source's policy.
            target: What to make trials on.
            keep: Where trials are kept, so that a killed loop goes on at the trial it was in.
            progress: Is called after each round.
            say: Is told what is going on.

        Raises:
            TransferError: The target stopped answering, or refuses the policy.
            SearchError: The policy does not fit the task.
        """
        rounds: list[LoopRound] = []
        upcoming, origin = policy, "source"
        for number in range(self.trials):
            say(f"trial {number + 1}: {origin}")
            tried = self._tried(upcoming, origin, target, number, keep)
            tries = [*(each.tried for each in rounds), tried]
            began = time.perf_counter()
            before = rounds[-1].advice.repair.model if rounds and rounds[-1].advice else None
            more = number + 1 < self.trials
            try:
                advice = advise(
                    task, tries, before=before, seed=self.seed + number, more=more, statement=say
                )
            except (DiagnosisError, EffectError, SimulationFailed) as error:
                # The trial was made, and what it showed must not be lost.
                seconds = time.perf_counter() - began
                rounds.append(LoopRound(tried=tried, advice=None, seconds=seconds))
                return concluded(rounds, hindered=error.what)
            seconds = time.perf_counter() - began
            rounds.append(LoopRound(tried=tried, advice=advice, seconds=seconds))
            progress(rounds[-1])
            if not worth_trying(advice, tries):
                break
            upcoming, origin = advice.policy, advice.origin
        return concluded(rounds)

    def _tried(
        self, policy: Policy, origin: str, target: Target, number: int, keep: Keep | None
    ) -> TrialRecord:
        before = None if keep is None else keep.trial(number)
        if before is not None:
            return before
        if keep is not None:
            keep.begin(number, policy, origin)
        experience = target.trial(policy, np.random.default_rng([self.seed, number]))
        tried = TrialRecord(policy=policy, experience=experience, origin=origin)
        if keep is not None:
            keep.end(number, experience)
        return tried


def worth_trying(advice: NextAction, tries: Sequence[TrialRecord]) -> bool:
    """Return whether the advised policy is to be tried: a new one, or one that failed by chance."""
    before = [each for each in tries if each.policy is advice.policy]
    if not before:
        return True
    failed = not any(each.experience.success for each in before)
    return failed and len(before) == 1 and advice.foreseen.success >= LIKELY


def concluded(rounds: Sequence[LoopRound], *, hindered: str = "") -> Transferred:
    """Return what a loop gives back: of all policies tried, the one to keep.

    With `hindered`, why no model could be made of the last trial.

    A model that explains the trials foresees better than single noisy trials tell; one that
    leaves something out does not, and then what trials showed counts.
    """
    last = rounds[-1].advice
    believed = last is not None and last.repair.explained.unsaid <= UNSURE
    tries = [each.tried for each in rounds]
    if last is not None and believed:
        best = _best_of([each for each in tries if each.policy is last.policy] or tries[-1:])
        foreseen: PredictedReturn | None = (
            last.known if last.policy is not best.policy else last.foreseen
        )
    else:
        best = _best_of(tries)
        foreseen = None
    fine = best.experience.success
    return Transferred(
        rounds=tuple(rounds),
        policy=best.policy,
        origin=best.origin,
        foreseen=foreseen,
        succeeded=fine,
        why="" if fine else hindered or _why(rounds, foreseen),
    )


def _best_of(tries: Sequence[TrialRecord]) -> TrialRecord:
    """Return the trial that did best: one that succeeded, of the least loss."""
    return min(tries, key=lambda each: (not each.experience.success, each.experience.loss))


def _why(rounds: Sequence[LoopRound], foreseen: PredictedReturn | None) -> str:
    advice = rounds[-1].advice
    if advice is None or foreseen is None:
        return f"no trial of {len(rounds)} reached every goal, and the model is not good enough"
    if not any(each.advice is not None and each.advice.searched for each in rounds):
        return "its trial did not reach every goal, and nothing was searched; give it more trials"
    if foreseen.success < 0.5:
        return (
            f"in the repaired model the best policy found reaches every goal in "
            f"{foreseen.success:.0%} of runs: the target may be beyond its motors, or the search"
        )
    return (
        f"the repaired model promises success in {foreseen.success:.0%} of runs, "
        f"and {len(rounds)} trials did not show it"
    )
