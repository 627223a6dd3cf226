from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import morph.policy_transfer
from morph.body.load import load
from morph.policy_transfer.predicted_return import PredictedReturn
from morph.policy_transfer.transfer_record import GuardRecord, Hop, Record, Verdict, guard
from morph.search.target import Experience
from morph.task.tasks import task

SCHEMA = json.loads(
    (Path(morph.policy_transfer.__file__).parent / "transfer.schema.json").read_text()
)


@pytest.fixture(scope="module")
def record() -> Record:
    run = Experience(
        position=np.zeros((4, 2)),
        velocity=np.zeros((4, 2)),
        command=np.zeros((3, 1)),
        period=0.05,
        loss=math.nan,
        success=False,
    )
    hop = Hop(
        task=task("swing-up", load("cartpole")),
        target="the rig",
        runs=(run, run),
        rounds=(),
        explained=None,
        guard=GuardRecord(verdict="unsure", probability=None),
        succeeded=False,
        why="nobody tried",
    )
    return Record(hops=(hop,), policy=False, seed=4, seconds=0.0, command="morph loop")


def test_the_record_is_what_the_schema_says(record: Record) -> None:
    said: dict[str, Any] = json.loads(record.text())
    jsonschema.validate(said, SCHEMA)
    assert said["chain"] == ["cartpole", "the rig"]
    # Two runs of three control periods each.
    assert (said["samples_total"], said["hops"][0]["samples"]) == (6, 6)
    assert set(said["hops"][0]["score"].values()) == {None}
    assert said["policy"] is None


def test_a_loss_that_is_no_number_is_null(record: Record) -> None:
    assert [each["loss"] for each in json.loads(record.text())["hops"][0]["trials"]] == [None, None]


@pytest.mark.parametrize("lost", ["schema", "chain", "hops", "provenance"])
def test_the_schema_misses_what_is_left_out(record: Record, lost: str) -> None:
    said = json.loads(record.text())
    del said[lost]
    with pytest.raises(jsonschema.ValidationError, match=rf"'{lost}' is a required property"):
        jsonschema.validate(said, SCHEMA)


@pytest.mark.parametrize(
    ("success", "verdict"),
    [(1.0, "safe"), (0.9, "safe"), (0.89, "unsure"), (0.5, "unsure"), (0.49, "unsafe")],
)
def test_a_policy_is_safe_by_what_is_foreseen_of_it(success: float, verdict: Verdict) -> None:
    assert guard(PredictedReturn(loss=1.0, success=success)) == GuardRecord(
        verdict=verdict, probability=success
    )


def test_without_a_model_that_is_believed_nothing_is_promised() -> None:
    assert guard(None) == GuardRecord(verdict="unsure", probability=None)
