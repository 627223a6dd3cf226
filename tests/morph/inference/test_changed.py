"""Which changes are told, by what diagnoses of either side of them find."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.errors import DiagnosisError
from morph.inference.changed import confirmed, decided, differs, renamed
from morph.model.deadline import NEVER
from morph.model.finding import Change, Estimate
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.payload import Payload
from morph.physics.effect import Effect
from morph.physics.joint.joint_stiffness import JointStiffness
from morph.physics.joint.viscous_friction import ViscousFriction


def ranking_of(found: str, share: float, vibration: float = 0.1) -> Any:
    """Return a ranking that named one law and leaves a share of the inertial force, and vibration.

    Args:
        found: Label of the law.
        share: Missing force over the inertial force.
        vibration: In units of the noise.
    """
    disturbance = SimpleNamespace(scale=np.array([share]), vibration=np.array([vibration]))
    about = SimpleNamespace(disturbance=disturbance, inertial=np.ones(1), sensed=np.ones(1))
    refit = SimpleNamespace(runs=[SimpleNamespace(about=about)])
    best = SimpleNamespace(effects=[SimpleNamespace(label=found)], refit=refit)
    return SimpleNamespace(best=best)


@pytest.mark.parametrize(("found", "share", "told"), [
    ("viscous_friction@axle", 0.01, True), ("coulomb_friction@axle", 0.01, True),
    ("viscous_friction@wrist", 0.01, False), ("payload@disc", 0.01, False),
    # Other physics is missing, of which a change of any law may explain some.
    ("viscous_friction@axle", 0.1, False),
])  # fmt: skip
def test_a_change_is_told_where_its_law_or_a_twin_is_found_again(
    found: str, share: float, told: bool
) -> None:
    law, idle = ViscousFriction(joint="axle", b=0.1), ViscousFriction(joint="axle", b=0.0)
    for before, after in ((idle, law), (law, idle)):
        change = Change(
            before=before, after=after, episode="run", time=1.0, gain=50.0, since=True
        )  # fmt: skip
        assert confirmed(change, ranking_of(found, share)) == told
        assert change.stays == (after is law)


@pytest.mark.parametrize(("whole", "vibration", "side", "told"), [
    (0.001, 0.1, 0.01, True), (0.01, 0.1, 0.01, False), (0.001, 2.0, 0.01, False),
    (0.001, 0.1, 0.1, False),
])  # fmt: skip
def test_evidence_decides_on_a_change_only_where_all_else_is_explained(
    whole: float, vibration: float, side: float, told: bool
) -> None:
    assert decided(ranking_of("", whole, vibration), ranking_of("", side)) == told


@pytest.mark.parametrize(("spans", "told"), [
    (((0.9, 1.1), (1.2, 1.4)), True), (((0.9, 1.3), (1.2, 1.4)), False),
    (((0.9, 1.1), None), False), ((None, (1.2, 1.4)), False),
    # Beside another law: that one made up for it.
    (((0.9, 1.1), (1.2, 1.4), "beside"), False),
])  # fmt: skip
def test_a_law_alters_only_where_intervals_of_both_sides_are_disjoint(
    spans: tuple[Any, ...], told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    law = ViscousFriction(joint="axle", b=1.0)

    def side(span: tuple[float, float] | None) -> Any:
        own, there = Estimate(value=1.0, low90=0.9, high90=1.1, unit="-"), []
        if span is not None:
            there = [Estimate(value=1.0, low90=span[0], high90=span[1], unit="-")]
        refit = SimpleNamespace(removal=lambda gone: ([1], None))
        effects = [law] if span else []
        best = SimpleNamespace(effects=effects, refit=refit, about=([own, *there], None))
        return SimpleNamespace(best=best)

    monkeypatch.setattr("morph.inference.changed.estimates", lambda about: about)
    change = Change(
        before=law, after=replace(law, b=1.3), episode="run", time=1.0, gain=50.0, since=True
    )
    assert (change.alters, change.stays) == (True, True)
    sides = [side(span) for span in spans[:2]]
    sides[1].best.effects += [SimpleNamespace(label="payload@disc")] * len(spans[2:])
    assert differs(change, sides) == told


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """What explains some runs, in the place of a ranking."""

    of: tuple[str, ...]
    stopped: bool = False


@pytest.mark.parametrize(("named", "evidence", "since", "told"), [
    (("after",), False, True, ("after",)),
    # Too weak to be found in the runs since then: the others follow.
    ((), True, False, ("before",)),
    ((), False, None, ("before", "after")),
    # It acts in those as well, so that it did not begin then.
    (("before",), True, None, ("before", "after")),
])  # fmt: skip
def test_what_is_said_follows_the_side_that_explains_a_change(
    named: tuple[str, ...], evidence: bool, since: bool | None, told: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    law, idle = ViscousFriction(joint="axle", b=0.1), ViscousFriction(joint="axle", b=0.0)
    begun = Change(before=idle, after=law, episode="run", time=1.0, gain=50.0, since=True)
    module = importlib.import_module("morph.inference.diagnose")
    answers = iter([(begun, ("after",), ("before",)), (None, (), ())])

    def rank(recordings: Any, **_: Any) -> Any:
        ready = SimpleNamespace(train=(), aside=(), of=tuple(recordings))
        return ready, Ranked(of=tuple(recordings))

    def changed(_: Any, recordings: Any, *rest: Any) -> Any:
        change, kept, others = next(answers)
        return (change, kept, others) if change else (None, recordings, ())

    monkeypatch.setattr(module, "changed", changed)
    monkeypatch.setattr(module, "confirmed", lambda _, side: side.of in {(each,) for each in named})
    monkeypatch.setattr(module, "decided", lambda whole, side: evidence)
    monkeypatch.setattr(module, "explained", lambda side: False)
    runs: Any = ("before", "after")
    (ready, _), changes = module._since_changes(rank, runs, (), (), 0.0, NEVER, lambda *_: None)
    assert ready.of == told
    assert [each.since for each in changes] == ([] if since is None else [since])


def test_a_side_that_cannot_be_diagnosed_alone_tells_of_no_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    law = ViscousFriction(joint="axle", b=0.1)
    change = Change(before=law.neutral(), after=law, episode="run", time=1.0, gain=50.0, since=True)
    module = importlib.import_module("morph.inference.diagnose")
    monkeypatch.setattr(module, "changed", lambda *_: (change, ("after",), ("before",)))

    def rank(recordings: Any, **_: Any) -> Any:
        if recordings == ("after",):
            raise DiagnosisError("nothing moves", where="run", fix="record motion")
        return SimpleNamespace(train=(), aside=(), of=recordings), Ranked(of=recordings)

    runs: Any = ("before", "after")
    (ready, _), changes = module._since_changes(rank, runs, (), (), 0.0, NEVER, lambda *_: None)
    assert (ready.of, changes) == (runs, [])


SPRING = JointStiffness(joint="axle", k=0.2, q0=0.1)
PUSH = ExternalPush(body="disc", run="run", start=1.0, end=1.1, x=1.0, y=0.0, z=0.0)


@pytest.mark.parametrize(("acting", "idle", "share", "told"), [
    ([SPRING], [], 0.01, True), ([], [], 0.01, False), ([SPRING], [SPRING], 0.01, False),
    # One law stands for another on the other side, two for one, or for a push.
    ([SPRING], [ViscousFriction(joint="axle", b=0.1)], 0.01, False),
    ([SPRING, ViscousFriction(joint="axle", b=0.1)], [], 0.01, False), ([PUSH], [], 0.01, False),
    ([SPRING], [], 0.1, False),
])  # fmt: skip
@pytest.mark.parametrize("ceases", [True, False])
def test_a_change_takes_the_name_of_the_one_law_found_on_one_side_alone(
    acting: list[Effect], idle: list[Effect], share: float, told: bool, ceases: bool
) -> None:
    payload = Payload(body="disc", m=0.1, x=0.0, y=0.0, z=0.0)
    law = (payload, payload.neutral())
    before, after = law if ceases else law[::-1]
    change = Change(before=before, after=after, episode="run", time=1.0, gain=50.0, since=True)
    sides = [ranking_of("", share), ranking_of("", 0.01)]
    for side, effects in zip(sides, (acting, idle), strict=True):
        side.best.effects = effects
    result = renamed(change, *sides)
    assert (result is not None) == told
    if result is not None:
        there, neutral = (result.before, result.after) if ceases else (result.after, result.before)
        assert (there, neutral) == (SPRING, SPRING.neutral())
        assert (result.time, result.ceases) == (1.0, ceases)


@pytest.mark.parametrize("stays", [True, False])
def test_another_law_is_looked_for_on_both_sides_of_a_change(
    stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    law, idle = ViscousFriction(joint="axle", b=0.1), ViscousFriction(joint="axle", b=0.0)
    change = Change(before=idle, after=law, episode="run", time=1.0, gain=50.0, since=stays)
    module = importlib.import_module("morph.inference.diagnose")
    monkeypatch.setattr(module, "confirmed", lambda *_: False)
    monkeypatch.setattr(module, "decided", lambda *_: False)
    monkeypatch.setattr(module, "explained", lambda side: side == "after")
    monkeypatch.setattr(module, "renamed", lambda change, *sides: sides)
    kept, rest = (["after"], ["before"]) if stays else (["before"], ["after"])
    found = module._proven(change, kept, rest, None, lambda runs, of="": (None, runs[0]))
    assert found == (("after", "before"), kept, (None, kept[0]))
    monkeypatch.setattr(module, "explained", lambda side: False)
    assert module._proven(change, kept, rest, None, lambda runs, of="": (None, runs[0])) is None


@pytest.mark.parametrize(("everywhere", "alone", "beside", "explains"), [
    (0.25, 0.3, 0.3, False), (0.25, 0.3, 0.01, True), (0.25, 0.01, 12.0, True),
    (0.25, 0.12, 0.24, False), (0.25, 0.09, 0.2, True),
    # As much is missing in all runs: what causes it has not changed.
    (0.11, 0.09, 0.085, False), (0.11, 0.3, 0.05, True), (0.02, 0.3, 0.025, True),
])  # fmt: skip
@pytest.mark.parametrize("ceases", [True, False])
def test_a_side_is_searched_where_the_law_that_changed_leaves_little(
    everywhere: float, alone: float, beside: float, explains: bool, ceases: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    @dataclass(frozen=True)
    class Described:
        effects: tuple[Effect, ...] = ()
        step: float = 0.002
        robot: Any = None

        @property
        def start(self) -> Any:
            return np.array([0.0, *(0.7 for _ in self.effects)])

    starts = []

    def refitted(hypothesis: Any, point: Any, episodes: Any, origin: Any = None) -> Any:
        starts.append((episodes, hypothesis.effects, point.tolist()))
        runs = ranking_of("", beside if hypothesis.effects else alone).best.refit.runs
        return SimpleNamespace(runs=runs, point=point)

    module = importlib.import_module("morph.inference.changed")
    monkeypatch.setattr(module, "pieces", lambda recording, robot, step: [recording])
    monkeypatch.setattr(module, "stretches", lambda episodes, most: episodes)
    monkeypatch.setattr(module, "refitted", refitted)
    law, idle = ViscousFriction(joint="axle", b=0.1), ViscousFriction(joint="axle", b=0.0)
    before, after = (law, idle) if ceases else (idle, law)
    change = Change(before=before, after=after, episode="run", time=1.0, gain=50.0, since=True)
    runs = ranking_of("", everywhere).best.refit.runs
    whole: Any = SimpleNamespace(
        hypothesis=Described(), point=np.array([0.2]), effects=(), runs=runs
    )
    assert module._explains(change, whole, ["side"]) == explains
    assert starts == [(["side"], (), [0.2]), (["side"], (law,), [0.2, 0.7])]
    # Of a log with gaps no piece may be long enough.
    monkeypatch.setattr(module, "pieces", lambda recording, robot, step: [])
    assert not module._explains(change, whole, ["side"])


@pytest.mark.parametrize("there", [True, False])
def test_a_law_that_alters_is_told_where_both_sides_differ(
    there: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    law = ViscousFriction(joint="axle", b=0.1)
    change = Change(
        before=law, after=replace(law, b=0.3), episode="run", time=1.0, gain=50.0, since=True
    )
    module = importlib.import_module("morph.inference.diagnose")
    monkeypatch.setattr(
        module, "differs", lambda change, sides: sides == ("after", "before") and there
    )
    kept, rest = ["after"], ["before"]
    found = module._proven(change, kept, rest, None, lambda runs, of="": (None, runs[0]))
    assert found == ((change, kept, (None, "after")) if there else None)
    assert module._proven(change, kept, [], None, lambda runs, of="": (None, runs[0])) is None


@pytest.mark.parametrize(("share", "looked"), [(0.1, True), (0.5, False)])
def test_changes_are_looked_for_where_one_leaves_much_force_missing(
    share: float, looked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    @dataclass(frozen=True)
    class Best:
        runs: Any
        hypothesis: Any
        point: Any = None
        effects: tuple[str, ...] = ("a law",)

    asked = []
    module = importlib.import_module("morph.inference.changed")
    monkeypatch.setattr(module, "stretches", lambda *_: [])
    monkeypatch.setattr(module, "seen", lambda *_: [])
    monkeypatch.setattr(module, "likeliest_change", lambda *_: asked.append(True))
    ranking: Any = SimpleNamespace(
        best=SimpleNamespace(
            refit=Best(
                runs=ranking_of("", share).best.refit.runs, hypothesis=SimpleNamespace(robot=None)
            )
        ),
        validation=SimpleNamespace(constrained=False),
        search=SimpleNamespace(prior=None),
    )
    assert module.changed(ranking, [], [], [], []) == (None, [], ())
    assert bool(asked) == looked
