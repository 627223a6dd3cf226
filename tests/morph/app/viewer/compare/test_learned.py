"""Policies that are searched for once, and found again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import morph.app.viewer.compare.learned as module
from morph.app.viewer.compare.learned import kept, kept_in, learned
from morph.body.load import load
from morph.errors import ViewError
from morph.task.task import Task
from morph.task.tasks import task


@pytest.fixture
def balance(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Task:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))
    return task("balance", load("pendulum"))


def test_what_was_learned_is_kept_by_body_task_search_and_seed(balance: Task) -> None:
    assert kept(balance, 0) is None
    told: list[str] = []
    found = learned(balance, 0, told.append)
    assert found.succeeded
    assert found.search == "lqr"
    again = kept(balance, 0)
    assert again is not None
    assert again.policy == found.policy
    assert (again.search, again.succeeded) == ("lqr", True)
    assert kept(balance, 1) is None
    assert kept_in(balance, 0) != kept_in(task("swing-up", balance.robot), 0)
    # What holds no record of a search is no policy that was learned.
    file = kept_in(balance, 0) / "policy.json"
    file.write_text(file.read_text().replace('"learned": {', '"learned": 1, "forgotten": {'))
    assert kept(balance, 0) is None


def test_a_spoilt_policy_is_searched_for_again(balance: Task) -> None:
    learned(balance, 0, lambda text: None)
    weights = kept_in(balance, 0) / "weights.safetensors"
    weights.write_bytes(weights.read_bytes()[:-9])
    assert kept(balance, 0) is None
    assert learned(balance, 0, lambda text: None).succeeded
    assert kept(balance, 0) is not None


def test_a_cache_that_cannot_be_written_to_costs_nothing_but_time(
    balance: Task, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "file"))
    assert learned(balance, 0, lambda text: None).succeeded


def test_a_search_ends_when_who_is_told_says_so(
    balance: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A search of many rounds, which a regulator is not.
    monkeypatch.setattr(module, "default", lambda name, robot: "cmaes")
    rounds: list[str] = []

    def told(text: str) -> None:
        rounds.append(text)
        raise ViewError("enough", where="here", fix="nothing")

    with pytest.raises(ViewError, match=r"enough"):
        learned(balance, 0, told)
    assert len(rounds) == 1
    assert np.char.startswith(rounds, "cmaes, round").all()
