from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from morph.alignment.errors import SamplesError
from morph.alignment.maps.files import read
from morph.app.cli.main import main
from morph.body.load import load
from morph.policy.store import load_policy, write_policy
from morph.policy_transfer.balancers import balancer
from morph.policy_transfer.mapped.feedback import holding
from morph.policy_transfer.policy_conversion import gain_of, stored

CHAIN = ("--chain", "cartpole", "rider_rigid_driven", "rider_two_links_driven")


def test_a_chain_leaves_a_policy_maps_a_record_and_a_report(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.transfer(*CHAIN)
    told = capsys.readouterr()
    assert told.out.startswith("rider_two_links_driven does balance, by way of two hops\n")
    assert re.search(r"ankle +-+> +hinge +-100 %", told.out)
    assert "hop 1: cartpole to rider_rigid_driven: 20 transitions, " in told.err
    assert {path.name for path in Path("out").iterdir()} == {
        ".morph.files",
        *("policy", "maps", "hops", "relay.json", "transfer.json", "report.html"),
    }
    said = bench.record()
    assert said["chain"] == ["cartpole", "rider_rigid_driven", "rider_two_links_driven"]
    assert (said["samples_total"], [hop["samples"] for hop in said["hops"]]) == (40, [20, 20])
    for hop in said["hops"]:
        assert (hop["score"]["hold_still"], hop["score"]["oracle"]) == (0.0, 1.0)
        assert hop["score"]["final"] > 0.95
        assert hop["relay"]["measured"]["flipped"] < 0.5
        assert read(Path("out") / hop["map"]).kind == "affine"
    assert {"cartpole", "rider_rigid_driven", "rider_two_links_driven", "policy"} == set(
        said["provenance"]["inputs"]
    )


def test_the_policy_that_is_kept_is_the_last_bodys(bench: Any) -> None:
    bench.transfer("--quiet")
    there = balancer("rider_rigid_driven")
    kept = load_policy("out/policy", there.task.robot)
    assert gain_of(there, kept)[0] == pytest.approx(holding(there), rel=1e-6)
    said = json.loads(Path("out/policy/policy.json").read_text())["learned"]
    assert (said["search"], said["succeeded"]) == ("relay", True)


def test_a_given_policy_is_as_good_as_the_one_that_is_learned(bench: Any) -> None:
    here = balancer("cartpole")
    gain = holding(here)
    write_policy(stored(here, gain, 0.0 * gain[:, 0]), Path("mine"), load("cartpole"))
    bench.transfer("--quiet", "--from", "mine")
    assert bench.record()["hops"][0]["score"]["zero_shot"] > 0.95


def test_json_is_the_record_and_nothing_else(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.transfer("--json", "--quiet")
    told = capsys.readouterr()
    assert (told.out, told.err) == (Path("out/transfer.json").read_text(), "")


def test_learning_curves_have_a_row_for_each_repeat(bench: Any) -> None:
    bench.transfer("--quiet", "--repeats", "2", "--scratch", "1")
    curves = {each["name"]: each for each in bench.record()["hops"][0]["relay"]["curves"]}
    assert set(curves) == {"transfer", "no_source", "shuffled", "flipped", "scratch"}
    # One round of 4 directions both ways, 2 s of 20 ms each.
    assert curves["scratch"]["samples"] == [2 * 4 * 100]
    # A sixth and a third of 20 are below the least count, and are drawn as that.
    assert curves["transfer"]["samples"] == [10, 13, 20]
    assert curves["transfer"]["repeats"] == 2


def test_a_hop_that_was_made_is_not_made_again(bench: Any) -> None:
    bench.transfer("--quiet")
    before = bench.record()
    bench.transfer("--quiet")
    assert bench.knowing.calls == 1
    assert bench.record()["hops"] == before["hops"]
    bench.transfer("--quiet", "--fresh")
    assert bench.knowing.calls == 2


def test_an_interrupted_chain_goes_on_at_its_hop(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.knowing.failing = {2: KeyboardInterrupt()}
    bench.transfer(*CHAIN, status=130)
    assert "interrupted after 1 hop; the same command goes on" in capsys.readouterr().err
    assert not Path("out/transfer.json").exists()
    bench.transfer(*CHAIN, "--quiet")
    # The first hop once, the second twice.
    assert bench.knowing.calls == 3
    assert len(bench.record()["hops"]) == 2


def test_interrupted_before_a_hop_it_leaves_nothing(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.knowing.failing = {1: KeyboardInterrupt()}
    bench.transfer(status=130)
    assert capsys.readouterr().err.endswith("interrupted; nothing was written\n")
    assert not Path("out").exists()


def test_a_chain_that_breaks_keeps_what_it_reached_and_says_so(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.knowing.failing = {2: SamplesError("they excite nothing", where="hop", fix="more")}
    bench.transfer(*CHAIN, "--quiet", status=3)
    said = bench.record()
    assert said["chain"] == ["cartpole", "rider_rigid_driven"]
    assert said["notes"][-1] == "hop 2 could not be made: hop: they excite nothing; more"
    assert "hop 2 could not be made" in " ".join(capsys.readouterr().out.split())
    load_policy("out/policy", load("rider_rigid_driven"))


def test_a_law_of_the_wrong_sign_is_unsafe_and_ends_with_3(
    bench: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    bench.knowing.sign = -1.0
    bench.transfer("--samples", "60", "--quiet", status=3)
    hop = bench.record()["hops"][0]
    assert hop["guard"]["verdict"] == "unsafe"
    assert hop["guard"]["probability"] < 0.5
    assert not hop["succeeded"]
    assert capsys.readouterr().out.startswith("The guard warns of rider_rigid_driven\n")
    assert json.loads(Path("out/policy/policy.json").read_text())["learned"]["guard"] == "unsafe"


def test_a_body_of_ones_own_is_told_to_have_no_push(bench: Any) -> None:
    from morph.body import shelf

    own = Path("mine.xml")
    assert "pendulum" in shelf.names()
    own.write_text(load("cartpole").mjcf)
    status = main(bench.words("--chain", "cartpole", str(own), "--quiet"))
    assert status in {0, 3}
    assert any("no push was fixed for mine.xml" in note for note in bench.record()["notes"])
