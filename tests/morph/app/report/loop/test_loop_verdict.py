from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.app.report.loop.files import UNNAMED, write_loop
from morph.app.report.loop.outcome import LoopOutcome
from morph.app.report.loop.verdict import beyond, sealed_rows, summary
from morph.body.load import load
from morph.model.latent.parameter_attribution import Difference, Explained
from morph.model.latent.unknowns import turned
from morph.model.missing_force.force import MissingForce
from morph.model.missing_force.fourier_features import FourierFeatures
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.joint.stribeck_friction import StribeckFriction
from morph.physics.store import load_effects
from morph.policy_transfer.repair import Repair, TaskModel
from morph.policy_transfer.retask import task_for
from morph.policy_transfer.score import KEPT, SEARCHED, PolicyScores
from morph.search.evaluate import Score
from morph.task.tasks import task

SWING = task("swing-up", load("cartpole"))


def differs(name: str, value: float, low: float, high: float) -> Difference:
    return Difference(name=name, value=value, low90=low, high90=high)


def outcome_of(
    concealed: dict[str, float], *found: Difference, effects: tuple[Any, ...] = (), **more: Any
) -> LoopOutcome:
    robot = turned(SWING.robot, {"weight:cart": 3.0})
    explained = Explained(
        inferred=SimpleNamespace(robot=robot, effects=effects, unsaid=0.1, states=()),  # type: ignore[arg-type]
        differences=found,
        rivals=(),
        evidence=9.0,
    )
    model = TaskModel(task=task_for(SWING, robot), effects=effects)
    return LoopOutcome(
        task=SWING,
        target="a target",
        runs=(),
        transferred=None,
        repair=Repair(model=model, explained=explained, task=SWING),
        concealed=concealed,
        seed=0,
        command="morph loop",
        **more,
    )


STRIBECK = "stribeck_friction@hinge"


@pytest.mark.parametrize(
    ("value", "low", "high", "verdict"),
    [
        (0.12, 0.11, 0.13, "found"),
        (0.10, 0.09, 0.11, "found, outside the interval"),
        (0.0, -0.01, 0.01, "not found"),
        (-0.1, -0.3, 0.2, "not found"),
        # A tenth of 0.124 is 0.0124: an interval that holds the truth holds nothing as well.
        (0.012, -0.2, 0.2, "not found"),
        (0.013, -0.2, 0.2, "found"),
    ],
)
def test_an_effect_of_next_to_nothing_was_not_found(
    value: float, low: float, high: float, verdict: str
) -> None:
    (row,) = sealed_rows(
        outcome_of({f"{STRIBECK}:c": 0.124}, differs(f"{STRIBECK}:c", value, low, high))
    )
    assert row["verdict"] == verdict
    # Of three parameters the sentence says which is meant.
    assert row["truth"] == "hinge: Stribeck friction c = 0.124 N m acts"


def test_a_figure_that_shrank_to_a_tenth_is_found() -> None:
    concealed = {"weight:cart": 0.95}
    (row,) = sealed_rows(outcome_of(concealed, differs("weight:cart", 0.09, 0.05, 0.99)))
    assert row["verdict"] == "found"


def test_coulomb_friction_is_found_as_stribeck_friction_whose_fast_part_is_right() -> None:
    found = (
        differs(f"{STRIBECK}:c", 0.12, 0.1, 0.14),
        differs(f"{STRIBECK}:s", 0.2, 0.1, 0.3),
        differs("weight:pole", 1.2, 1.1, 1.3),
    )
    outcome = outcome_of({"coulomb_friction@hinge:c": 0.124}, *found)
    (row,) = sealed_rows(outcome)
    assert (row["verdict"], row["found"]) == ("found as Stribeck friction", "0.12")
    assert row["truth"] == "hinge: Coulomb friction 0.124 N m acts"
    assert beyond(outcome) == ("weight:pole",)
    # Elsewhere, or with another size, it is another thing.
    (row,) = sealed_rows(outcome_of({"coulomb_friction@slide:c": 0.124}, *found))
    assert row["verdict"] == "not named"
    other = outcome_of({"coulomb_friction@hinge:c": 0.3}, *found)
    assert "not named" in sealed_rows(other)[0]["verdict"]
    assert f"{STRIBECK}:c" in beyond(other)


def test_a_learned_force_is_left_out_of_the_corrected_files_and_that_is_said(
    tmp_path: Path,
) -> None:
    waves = FourierFeatures(
        hinges=np.array([1]), slides=np.array([], dtype=int), joints=2, size=np.ones(2),
        own_length=1.0, length=1.0, farthest=np.array([[-1.0, -1.0], [1.0, 1.0]]),
    )  # fmt: skip
    force = MissingForce(joints=("slide", "hinge"), waves=waves, weight=np.zeros((2, waves.count)))
    named: tuple[Any, ...] = (
        CoulombFriction(joint="slide", c=0.5),
        StribeckFriction(joint="hinge", c=0.1, s=0.2),
    )
    before = outcome_of({}, effects=named)
    assert before.repair is not None
    # The force was fitted with figures of its own.
    model = TaskModel(task=SWING, effects=(*named, force))
    repair = replace(before.repair, model=model, learned=SimpleNamespace())  # type: ignore[arg-type]
    written = write_loop(replace(before, repair=repair), tmp_path)
    (effect,) = load_effects(tmp_path / "corrected.toml")
    assert effect.label == STRIBECK
    cart = load(tmp_path / "corrected.xml"), load("cartpole")
    mass = [task("swing-up", each).simulator().model.body("cart").mass[0] for each in cart]
    # The figures are those of the names: the cart is three times as heavy.
    assert mass[0] == pytest.approx(3.0 * mass[1])
    assert written.notes == (UNNAMED,)
    assert "a learned force stands for it" in (tmp_path / "report.html").read_text()
    assert write_loop(before, tmp_path).notes == ()


def test_the_summary_says_which_policy_the_oracle_is() -> None:
    def costs(loss: float) -> Score:
        return Score(loss=np.full(4, loss), success=np.ones(4, dtype=bool))

    run: Any = SimpleNamespace(loss=9.0, seconds=3.0)
    done: Any = SimpleNamespace(foreseen=None, seconds=1.0, policy=None, rounds=())
    for best, said in ((SEARCHED, "parameters 5 (100"), (KEPT, "better than the policy to keep")):
        judged = PolicyScores(
            still=costs(60.0), source=costs(9.0), final=costs(5.0), oracle=costs(5.0), best=best
        )
        kept: Any = SimpleNamespace(tried=SimpleNamespace(policy=None))
        done.rounds = (kept,)
        there = replace(outcome_of({}), runs=(run,), transferred=done, judged=judged)
        assert said in summary(there)[-1].replace("\N{NO-BREAK SPACE}", " ")
