"""The study of environments finds what is wrong, and compares like with like."""

from __future__ import annotations

import gymnasium
import pytest
from gymnasium.envs.registration import EnvSpec

from experiments.environments import DEFECTS, batch_seconds, checked, main, spoiled


def test_the_cart_poles_environments_are_clean(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--only", "CartPole-"]) == 0
    assert capsys.readouterr().out.endswith("0 not clean\n")


def test_an_environment_that_cannot_be_made_is_told_with_the_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lost = EnvSpec(
        id="morph/Nobody-SwingUp-v0",
        entry_point="morph.task.gym.env:Environment",
        kwargs={"task": "swing-up", "robot": "nobody"},
    )
    monkeypatch.setitem(gymnasium.registry, lost.id, lost)
    assert "no robot is called 'nobody'" in checked(lost.id).found


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_planted_in_a_clean_environment_is_named(defect: str) -> None:
    assert spoiled(defect).found != ""


def test_an_environment_spoiled_by_nothing_is_clean() -> None:
    assert spoiled("").found == ""


def test_a_batch_is_measured_over_the_same_steps_as_a_bare_one() -> None:
    ours, theirs, steps = batch_seconds("cartpole", "swing-up", 8, 1)
    # A control period of 0.05 s in steps of 0.01 s.
    assert steps == 5
    assert min(ours, theirs) > 0.0
