"""A task follows the body that is asked to do it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from morph.body.load import load
from morph.model.latent.unknowns import turned
from morph.policy_transfer.retask import task_for
from morph.task.swing_up import swing_up


def test_a_named_task_reaches_as_high_as_the_new_pole() -> None:
    task = swing_up(load("cartpole"))
    longer = turned(task.robot, {"length:pole": 2.0})
    found = task_for(task, longer)
    # The thesis' pole is 0.5 m, and the width of the cost half of that.
    assert found.terms[0].target[2] == pytest.approx(1.0)
    assert found.terms[0].width == pytest.approx(0.5)
    assert found.robot is longer


def test_a_wider_start_goes_along() -> None:
    task = swing_up(load("cartpole"))
    wide = replace(task, start=replace(task.start, spread=0.3))
    found = task_for(wide, turned(task.robot, {"length:pole": 2.0}))
    assert found.terms[0].target[2] == pytest.approx(1.0)
    assert found.start.spread == 0.3


def test_a_task_of_ones_own_keeps_its_numbers() -> None:
    task = swing_up(load("cartpole"))
    own = replace(task, terms=(replace(task.terms[0], width=0.1),))
    found = task_for(own, turned(task.robot, {"length:pole": 2.0}))
    assert found.terms == own.terms


def test_the_same_body_has_the_same_task() -> None:
    task = swing_up(load("cartpole"))
    assert task_for(task, task.robot) is task
