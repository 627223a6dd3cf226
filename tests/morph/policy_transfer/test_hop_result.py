from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import morph.policy_transfer
from morph.alignment.maps.affine_map import AffineMap
from morph.body.load import load
from morph.errors import OutputError, TransferError
from morph.policy_transfer.hop_checkpoint import HopsKept, Kept
from morph.policy_transfer.hop_result import Crossing, Curve
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.relay_record import RelayRecord, hashes
from morph.policy_transfer.transfer_record import GuardRecord
from morph.task.tasks import task

SCHEMA = json.loads(
    (Path(morph.policy_transfer.__file__).parent / "transfer.schema.json").read_text()
)


def curve(name: str, *rows: list[float]) -> Curve:
    return Curve(name=name, samples=(10, 20, 40), scores=np.array(rows))


def crossing(**changed: Any) -> Crossing:
    known: dict[str, Any] = {
        "source": "cartpole",
        "target": "rider_rigid_driven",
        "map": "maps/01_body_map.npz",
        "kind": "affine",
        "parts": Parts(
            states=(Arrow(begin="board", end="slide", weight=-0.8),), commands=(), lost=("ankle",)
        ),
        "quality": {"round_trip": 0.9},
        "guard": GuardRecord(verdict="safe", probability=0.98),
        "samples": 40,
        "measured": {"hold_still": 0.2, "oracle": 1.0, "final": 0.96, "zero_shot": 0.6},
        "curves": (curve("transfer", [0.3, 0.97, 1.0], [0.5, 0.99, 1.0]),),
    }
    return Crossing(**known | changed)


def test_scores_are_0_for_holding_still_and_1_for_the_oracle() -> None:
    scores = crossing().scores
    assert (scores["hold_still"], scores["oracle"]) == (0.0, 1.0)
    # (0.6 - 0.2) / (1 - 0.2) and (0.96 - 0.2) / 0.8.
    assert scores["zero_shot"] == pytest.approx(0.5)
    assert scores["final"] == pytest.approx(0.95)
    assert (scores["no_source"], scores["scratch"]) == (None, None)


def test_where_the_oracle_gains_nothing_there_is_no_score_and_no_success() -> None:
    nothing = crossing(measured={"hold_still": 0.99, "oracle": 0.99, "final": 0.99})
    assert set(nothing.scores.values()) == {None}
    assert not nothing.good
    assert nothing.said()["why"] == "the oracle is no better than holding still"


def test_a_curve_has_reached_what_it_does_not_fall_below_again() -> None:
    assert curve("transfer", [0.96, 0.5, 0.97]).reached(0.95) == 40
    assert curve("transfer", [0.96, 0.96, 0.97]).reached(0.95) == 10
    assert curve("transfer", [0.96, 0.96, 0.9]).reached(0.95) is None


def test_the_interval_of_a_mean_holds_it_and_is_nothing_without_a_spread() -> None:
    low, high = curve("transfer", [0.0, 0.3, 1.0], [1.0, 0.3, 1.0]).interval
    # Of two rows a quarter of the draws takes the first twice, and a quarter the second.
    assert low.tolist() == [0.0, 0.3, 1.0]
    assert high.tolist() == [1.0, 0.3, 1.0]


def test_a_curve_of_another_length_is_refused() -> None:
    with pytest.raises(TransferError, match=r"3 counts have scores of the shape \(1, 2\)"):
        curve("transfer", [0.1, 0.2])


def record(*hops: Crossing) -> RelayRecord:
    return RelayRecord(
        task=task("balance", load("cartpole")),
        hops=hops,
        policy=True,
        seed=0,
        seconds=1.5,
        command="morph transfer",
        inputs={"cartpole": "0" * 64},
    )


def test_the_record_keeps_to_its_schema_and_counts_every_sample() -> None:
    second = crossing(source="rider_rigid_driven", target="rider_two_links_driven", samples=25)
    said = json.loads(record(crossing(), second).text())
    jsonschema.validate(said, SCHEMA)
    assert said["chain"] == ["cartpole", "rider_rigid_driven", "rider_two_links_driven"]
    assert said["samples_total"] == 65
    assert said["hops"][0]["relay"]["reached"] == {"transfer": 20}


def test_a_figure_that_is_none_is_null() -> None:
    odd = crossing(quality={"round_trip": float("nan")})
    said = json.loads(record(odd).text())
    jsonschema.validate(said, SCHEMA)
    assert said["hops"][0]["quality"] == {"round_trip": None}


def affine() -> AffineMap:
    one, none = np.eye(2), np.zeros(2)
    return AffineMap(
        **dict.fromkeys(("state_law", "lift_law", "action_law", "action_state"), one),
        **dict.fromkeys(("read_law", "read_state"), one),
        **{f"{name}_shift": none for name in ("state", "lift", "action", "read")},
    )


@pytest.fixture
def kept(tmp_path: Path) -> HopsKept:
    keeper = HopsKept(tmp_path, {"seed": "0"})
    gain, shift = np.array([[1.0, -2.0]]), np.array([0.5])
    step = np.arange(6.0).reshape(2, 3)
    done = Kept(crossing=crossing(), map=affine(), gain=gain, shift=shift, step=step)
    keeper.write(1, done)
    return keeper


def test_a_hop_that_was_kept_is_read_as_it_was(kept: HopsKept) -> None:
    again = kept.read(1)
    assert again is not None
    assert again.crossing.said() == crossing().said()
    assert (again.gain.tolist(), again.shift.tolist()) == ([[1.0, -2.0]], [0.5])
    assert again.step.tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
    assert again.map.state(np.array([[3.0, 4.0]])).tolist() == [[3.0, 4.0]]
    assert kept.read(2) is None


@pytest.mark.parametrize("name", ["hops/01/hop.json", "hops/01/law.npz", "maps/01_body_map.npz"])
@pytest.mark.parametrize("spoil", [b"", b"{}", b"PK\x03\x04", None])
def test_a_spoilt_hop_is_made_anew(kept: HopsKept, name: str, spoil: bytes | None) -> None:
    if spoil is None:
        (kept.out / name).unlink()
    else:
        (kept.out / name).write_bytes(spoil)
    assert kept.read(1) is None


def test_a_law_that_was_changed_is_no_longer_the_hops(kept: HopsKept) -> None:
    law = {"gain": np.array([[1.0, 2.0]]), "shift": np.array([0.5]), "step": np.zeros((2, 3))}
    np.savez(kept.out / "hops/01/law.npz", **law)
    assert kept.read(1) is None


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"quality": {', '"quality": [], "more": {'),
        ('"samples": 40', '"samples": Infinity'),
        ('"hold_still": 0.2, ', ""),
        ('"parts": {', '"parts": null, "more": {'),
    ],
)
def test_a_hop_told_by_what_it_cannot_be_is_made_anew(
    kept: HopsKept, before: str, after: str
) -> None:
    path = kept.out / "hops/01/hop.json"
    assert before in path.read_text()
    path.write_text(path.read_text().replace(before, after, 1))
    assert kept.read(1) is None


def test_inputs_of_one_name_are_numbered_and_none_is_lost() -> None:
    given = [("policy", "a"), ("rig", "b"), ("rig", "b"), ("rig", "c"), ("policy", "d")]
    assert hashes(given) == {"policy": "a", "rig": "b", "rig 2": "c", "policy 2": "d"}


def test_a_hop_reads_no_map_but_its_own(kept: HopsKept) -> None:
    path = kept.out / "hops/01/hop.json"
    path.write_text(path.read_text().replace("maps/01_body_map.npz", "../stranger.npz"))
    assert kept.read(1) is None


def test_the_folder_of_another_transfer_is_refused(kept: HopsKept) -> None:
    with pytest.raises(OutputError, match=r"holds a transfer with other seed"):
        HopsKept(kept.out, {"seed": "1"})


def test_curves_and_notes_change_nothing_that_is_scored() -> None:
    assert replace(crossing(), curves=(), notes=("a",)).scores == crossing().scores
