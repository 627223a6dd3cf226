"""Which changes are told, by what diagnoses of either side of them find."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.inference.changed import confirmed, decided, differs
from morph.model.finding import Change, Estimate
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

    def rank(recordings: Any) -> Any:
        ready = SimpleNamespace(train=(), aside=(), of=tuple(recordings))
        return ready, SimpleNamespace(stopped=False, of=tuple(recordings))

    def changed(_: Any, recordings: Any, *rest: Any) -> Any:
        change, kept, others = next(answers)
        return (change, kept, others) if change else (None, recordings, ())

    monkeypatch.setattr(module, "changed", changed)
    monkeypatch.setattr(module, "confirmed", lambda _, side: side.of in {(each,) for each in named})
    monkeypatch.setattr(module, "decided", lambda whole, side: evidence)
    runs: Any = ("before", "after")
    (ready, _), changes = module._since_changes(rank, runs, (), (), np.inf, lambda *_: None)
    assert ready.of == told
    assert [each.since for each in changes] == ([] if since is None else [since])


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
    found = module._proven(change, kept, rest, None, lambda runs: (None, runs[0]))
    assert found == ((change, kept, (None, "after")) if there else None)
    assert module._proven(change, kept, [], None, lambda runs: (None, runs[0])) is None


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
