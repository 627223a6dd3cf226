"""Sets of effects refitted to runs, reduced and compared."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.inference.dictionary import search_beside
from morph.inference.explained import certain, evidence_decides
from morph.inference.finalist import Finalist, better, gains, labels, under
from morph.inference.floor import likeliest_contact
from morph.inference.inverse_dynamics import force_error
from morph.inference.observed import Observed, missing, settled
from morph.inference.output_error import output_error
from morph.inference.quadratic import quadratic
from morph.inference.refit import Refit, refitted, seen
from morph.inference.refit import under as refit_under
from morph.inference.search import BeamSearch, Explanation, Prior
from morph.inference.simulated import likeliest_limit, simulated
from morph.inference.validate import FAR, FARTHEST, Validation, needed
from morph.model.deadline import Deadline
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.physics.effect import Effect
from morph.sim.threads import each

SEARCHED = 20.0
"""Seconds of runs in which effects are searched where only rollouts decide."""
SIMULATED, SPARSE = 6, 3
"""How many of the likeliest sets, and of the likeliest single effects, are simulated; and every how
many stretches of them where rollouts decide."""
FINALISTS = 2
"""How many of those with the least error are refitted, beside the likeliest."""
DRY = {"coulomb_friction", "stribeck_friction", "load_dependent_friction"}
SPRINGS = {"series_elasticity"}
"""Laws refitted to rollouts at all driven joints: dry friction until one is found, and springs."""
GROUP = -5.0
"""Least gain of a law of friction at all driven joints that is simulated, nats."""
DIVERGED = 0.5
"""Most rise of the mean loss by a set before it is refitted, nats a stretch and channel."""
RIVAL, TWIN = 10.0, 60.0
"""Least nats that another law in the place of one gains in Gram space to be tried there; and most
that a twin may lose: where readings are precise its second order shows."""
REPLACED, LOST, TWIN_LOST = 3, 200.0, 1000.0
"""Most laws that are tried in the place of others; and nats that an effect which is left out may
cost in Gram space, also beside a twin: a refit may make up for it."""
ROUNDS = 2
"""Most Gauss-Newton steps of a refit under one estimate of the disturbances."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EffectSelection:
    """What is ranked, and how sets of effects are refitted and compared."""

    nominal: Hypothesis
    """The description, with its figures that may be wrong, and no effect."""
    episodes: Sequence[Episode]
    """Its runs."""
    known: Sequence[Effect]
    """Effects whose fixed parameters are known."""
    validation: Validation
    """The stretches on which sets are compared."""
    prior: Prior
    """How probable sets are beforehand."""
    deadline: Deadline
    """After which no refit begins."""
    by_rollouts: bool = False
    """Whether sets are refitted to rollouts, since runs are not explained to their noise."""
    by_forces: bool = False
    """Whether forces while joints slip propose these sets, and start their refits."""

    def late(self) -> bool:
        """Return whether no refit may begin any more."""
        return self.deadline.passed

    @property
    def believed(self) -> bool:
        """Whether linearised strengths are."""
        return self.by_forces or not self.by_rollouts

    def search(self, base: Finalist) -> BeamSearch:
        """Return a search for effects to add to a set.

        Where the linearisation is not believed it only proposes: a part of the runs will do.
        """
        prior = self.prior if self.prior.alone else None
        refit, blocks = base.refit, self.validation.blocks
        if not self.believed:
            lasted = sum(run.motion.time[-1] for run in refit.runs)
            refit = replace(refit, runs=refit.runs[:: max(1, int(lasted / SEARCHED))])
        return search_beside(refit, self.known, prior, blocks, by_forces=self.by_forces)

    def refitted(
        self,
        hypothesis: Hypothesis,
        point: Array,
        runs: Sequence[Observed] | None = None,
        origin: Refit | None = None,
    ) -> Finalist:
        """Return a hypothesis refitted to the runs.

        Args:
            hypothesis: Own parameters and effects.
            point: Where the refit begins, (entries,).
            runs: Smoothed by a similar hypothesis.
            origin: A refit of the same hypothesis less its last effects.
        """
        if self.by_rollouts:
            least = functools.partial(force_error, runs=runs) if self.by_forces else output_error
            about = least(hypothesis, point, self.validation, self.deadline)
            smoothed = each(settled, seen(hypothesis, about.point, self.episodes, runs))
            refit = Refit(
                hypothesis=hypothesis, point=about.point, runs=smoothed,
                evidence=0.0, rank=about.step()[1],
            )  # fmt: skip
        else:
            refit = refitted(
                hypothesis, point, self.episodes, origin=origin, before=runs, rounds=ROUNDS,
                deadline=self.deadline,
            )  # fmt: skip
            refit = refit_under(refit, origin) if origin else refit
            blocks = self.validation.blocks
            about = quadratic(hypothesis, refit.point, refit.runs, blocks=blocks)
        (losses,) = self.validation.losses_of(about, refit.runs, [range(len(refit.effects))])
        fitted = losses
        if not self.by_rollouts and evidence_decides(refit.runs):
            points = [about.point] * self.validation.folds
            (fitted,) = self.validation.losses(hypothesis, [points], refit.runs)
        if self.by_rollouts:
            # A stretch's errors are correlated: it counts as one reading.
            extra = 0.5 * max(0, refit.rank - hypothesis.free_knobs)
            evidence = -float(losses.sum()) - extra * math.log(len(losses))
            refit = replace(refit, evidence=evidence)
        price = self.prior.price({effect.label for effect in refit.effects})
        return Finalist(refit=refit, price=price, losses=losses, fitted=fitted, about=about)

    def added(self, base: Finalist, beam: BeamSearch, most: int) -> tuple[list[Finalist], Finalist]:
        """Return larger sets, refitted, and the best; none where all leave too much force.

        Sets that are proposed later are refitted only where none of those before is better.

        Args:
            base: A set.
            beam: What might be added to it.
            most: Most effects, or laws at every joint, that are added.
        """
        tried, gained = list[Finalist](), list[Finalist]()
        done = {labels(base.effects)}
        for proposed in self.proposals(beam, beam.sets(most), base):
            wholes = []
            for result in proposed:
                start = replace(self.nominal, effects=(*base.effects, *result.effects))
                if not self.late() and labels(start.effects) not in done:
                    own = base.refit.point + (result.own if self.believed else 0.0)
                    point = np.concatenate([own, start.start[len(own) :]])
                    wholes.append(self.refitted(start, point, base.refit.runs, base.refit))
                    done.add(labels(start.effects))
            if not self.by_rollouts and all(missing(e.refit.runs) > FAR for e in wholes):
                return [], base
            for whole in wholes:
                new = self.reduced(whole)
                tried.append(new)
                if not self.by_rollouts:
                    base, *gained = (under(one, new) for one in (base, *gained))
                if gains(base, new, self.validation):
                    gained.append(new)
                elif labels(new.effects) == labels(base.effects) and new.evidence > base.evidence:
                    base = new
            if gained:
                break
        pick = functools.partial(better, validation=self.validation)
        return tried, functools.reduce(pick, gained or [base])

    def proposals(
        self, search: BeamSearch, sets: Sequence[Explanation], base: Finalist
    ) -> list[list[Explanation]]:
        """Return the sets to refit: the likeliest, and those with the least error in rollouts.

        Where the model of the missing force is not believed, laws of real drives at all joints are
        first, as stiction mimics lost torque; where forces tell it, with the likeliest set.
        """
        some = [one for one in sets if one.effects and one.gain > 0.0]
        alone = [one for one in some if search.single(one)]
        groups = [one for one in search.together() if self.by_rollouts or one.gain > GROUP]
        by_labels = {labels(one.effects): one for one in groups[::-1]}
        listed = {
            one.members: one for one in [*some[:SIMULATED], *alone[:SIMULATED], *by_labels.values()]
        }
        rows = np.arange(0, len(base.losses), SPARSE if self.by_rollouts else 1)
        segments = self.validation.segments.only(rows)
        validation, now = replace(self.validation, segments=segments), base.losses[rows].mean()
        losses: dict[tuple[int, ...], float] = {}
        for members, result in listed.items():
            if self.late():
                return []
            losses[members], listed[members] = simulated(
                result, search, base, validation, believed=self.believed,
                enough=now if self.by_forces else math.inf,
            )  # fmt: skip
        by_rollouts = sorted(listed.values(), key=lambda one: losses[one.members])
        # A stiff spring diverges in long steps. So may the likeliest set, far from the base.
        most = now + DIVERGED * base.refit.runs[0].about.velocity.shape[1]
        stable = [one for one in by_rollouts if losses[one.members] < most]
        likeliest = sorted(by_rollouts, key=lambda one: -one.gain)[: int(self.believed)]
        if not self.by_rollouts:
            # Sets that share effects often end as the same one.
            taken = frozenset().union(*(labels(one.effects) for one in [*likeliest, *stable[:1]]))
            others = [one for one in stable[1:] if not taken & labels(one.effects)]
            chosen = [*likeliest, *stable[:1], *(others or stable[1:])[: FINALISTS - 1]]
            return [list({one.members: one for one in chosen}.values())]
        stable = stable[:FINALISTS]
        dry, drives = bool(DRY & {effect.name for effect in base.effects}), []
        for name, one in by_labels.items():
            inside = any(name <= labels(whole.effects) for whole in likeliest)
            laws = {effect.name for effect in one.effects}
            bends = laws == SPRINGS and losses[one.members] < now
            if not inside and (bends or (len(laws) == 1 and laws <= DRY and not dry)):
                drives.append(one)
        other = likeliest_contact(base, validation, now)
        if other is None and missing(base.refit.runs) > FARTHEST:
            other = likeliest_limit(base, validation, now, self.known)
        drives += [other[1]] if other and other[0] < min(losses.values(), default=now) else []
        return [[*likeliest, *drives], stable]

    def reduced(self, whole: Finalist) -> Finalist:
        """Return a set without the effects that rollouts do not need, if that is not worse."""
        refit, validation = whole.refit, self.validation
        if self.late():
            return whole
        kept, losses = needed(whole.about, validation, refit.runs)
        idle = any(validation.idle(effect) for effect in whole.effects)
        if len(kept) == len(whole.effects) or (validation.worse(whole.losses, losses) and not idle):
            return whole
        fewer = self.refitted(*whole.about.reduced(kept), refit.runs)
        fewer = fewer if self.by_rollouts else under(fewer, whole)
        likelier = certain(whole.evidence - fewer.evidence, refit.runs)
        if (likelier or validation.worse(whole.losses, fewer.losses)) and not idle:
            return whole
        # A time that the refit has shortened is no more to be claimed than one found short.
        return self.reduced(fewer) if any(map(validation.idle, fewer.effects)) else fewer

    def replaced(self, best: Finalist, search: BeamSearch, gone: Set[str]) -> Finalist | None:
        """Return a set with another law in the place of one, a likelier or a simpler, or none.

        What was found first was found beside all that had not been found yet. A simpler law is
        taken where rollouts are not surely worse, none where the others explain what it did.

        Args:
            best: The set.
            search: Beside it.
            gone: Labels of effects that were replaced before.
        """
        rivals: list[tuple[float, int, Effect | None]] = []
        for at, effect in enumerate(best.effects):
            none, every = search.instead(effect.label, *best.refit.removal([at]))
            lost = TWIN_LOST if any(o.name in effect.twins for o in best.effects) else LOST
            rivals += [(none, at, None)] if none > -lost and len(best.effects) > 1 else []
            others = [one for one in every if one[0].label not in gone]
            rivals += [(gain, at, other) for other, gain in others[:1] if gain > RIVAL]
            # The linearisation says little of a time's twins, and nothing of a push's.
            least = -math.inf if effect.of_a_run else -TWIN
            twins = [(gain, at, o) for o, gain in others if o.name in effect.twins]
            rivals += [one for one in twins[:1] if least < one[0] <= RIVAL]
            simple = [o for o, _ in others if o.label == f"{effect.simpler}@{effect.where}"]
            rivals += [(math.inf, at, effect.simplified(o)) for o in simple]
        most = REPLACED + sum(gain == math.inf for gain, _, _ in rivals)
        for _, at, other in sorted(rivals, key=lambda one: -one[0])[:most]:
            new = self.exchanged(best, at, other)
            if self.prefers(best, new, best.effects[at], other):
                return self.reduced(new)
        return None

    def exchanged(self, best: Finalist, at: int, other: Effect | None) -> Finalist:
        """Return a set with another effect in the place of one, or none there, refitted."""
        effects = (*best.effects[:at], *([other] if other else []), *best.effects[at + 1 :])
        start = replace(best.refit.hypothesis, effects=effects)
        own = len(start.knobs)
        point = np.concatenate([best.refit.point[:own], start.start[own:]])
        return self.refitted(start, point, best.refit.runs)

    def prefers(self, best: Finalist, new: Finalist, effect: Effect, other: Effect | None) -> bool:
        """Return whether a set is better with another law in the place of an effect, or none.

        Parameters that a law has more than its simpler one must show in rollouts.
        """
        if other is None:
            lost, simpler = best.evidence - new.evidence, f"{effect.simpler}@{effect.where}"
            sure = certain(lost, best.refit.runs, event=effect.passing)
            sure = sure and simpler not in labels(new.effects)
            return not (sure or self.validation.sure(new.losses, best.losses))
        if other.name == effect.simpler:
            return not self.validation.worse(best.losses, new.losses)
        if other.simpler == effect.name and not self.validation.sure(best.losses, new.losses):
            return False
        return gains(best, new, self.validation)
