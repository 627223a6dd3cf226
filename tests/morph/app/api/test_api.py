"""Each function gives what the command of its name writes."""

from __future__ import annotations

import json
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import morph
from morph.app.cli.main import main
from morph.errors import MorphError
from morph.physics import ViscousFriction


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("api")


@pytest.fixture(scope="module")
def policy(folder: Path) -> Path:
    outcome = morph.learn("balance", "cartpole")
    assert outcome.succeeded
    outcome.save(folder / "learned")
    return folder / "learned" / "policy"


def test_a_policy_is_that_of_the_command(policy: Path, folder: Path) -> None:
    words = ["learn", "balance", "--robot", "cartpole", "--out", str(folder / "command")]
    assert main([*words, "--quiet"]) == 0
    name = "weights.safetensors"
    assert (policy / name).read_bytes() == (folder / "command/policy" / name).read_bytes()


def test_effects_act_on_what_is_learned_and_each_trial_is_shown() -> None:
    seen = []
    law = ViscousFriction(joint="slide", b=0.3)
    outcome = morph.learn("balance", "cartpole", effects=[law], progress=seen.append)
    assert outcome.task.effects == (law,)
    assert [trial.number for trial in seen] == [row["number"] for row in outcome.rows()]


def test_a_task_that_there_is_not_is_refused() -> None:
    with pytest.raises(MorphError, match="balanse"):
        morph.learn("balanse", "cartpole")


@pytest.mark.parametrize(("trials", "seed", "what"), [(0, 0, "0 trials"), (None, -1, "-1 is no")])
def test_numbers_that_no_search_takes_are_refused(trials: int | None, seed: int, what: str) -> None:
    with pytest.raises(MorphError, match=what):
        morph.learn("balance", "cartpole", trials=trials, seed=seed)


def test_a_map_between_files_or_bodies_is_that_of_the_command(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    aligned = morph.align("cartpole", "rider_rigid_driven", samples=40, seed=3)
    words = ["align", "cartpole", "rider_rigid_driven", "--samples", "40", "--seed", "3", "--json"]
    main([*words, "--quiet"])
    assert {row["measure"]: row["value"] for row in aligned.rows()} == pytest.approx(
        json.loads(capsys.readouterr().out)["quality"]
    )
    rng = np.random.default_rng(0)
    state, command = rng.normal(size=(100, 1)), rng.normal(size=(100, 1))
    for name, sign in (("a.npz", 1.0), ("b.npz", -1.0)):
        after = 0.5 * state + sign * command
        np.savez(folder / name, state=state, command=command, after=after)
    # The states are alike, and the command is turned round.
    found = morph.align(folder / "a.npz", folder / "b.npz")
    (arrow,) = found.parts.commands
    assert arrow.weight == pytest.approx(-1.0, abs=1e-6)


def test_a_transfer_is_the_record_that_it_wrote(policy: Path, folder: Path) -> None:
    out = folder / "carried"
    chain = ["cartpole", "rider_rigid_driven"]
    record = morph.transfer(policy, chain, out, trials=4, repeats=0, scratch=0)
    wrote = json.loads((out / "transfer.json").read_text())
    assert wrote["hops"][0]["relay"]["measured"] == dict(record.hops[0].measured)
    assert [row["target"] for row in record.rows()] == ["rider_rigid_driven"]


def test_what_fails_without_a_hop_leaves_nothing(policy: Path, folder: Path) -> None:
    with pytest.raises(MorphError):
        morph.transfer(policy, ["cartpole", "pendulum"], folder / "nothing")
    assert not (folder / "nothing" / "transfer.json").exists()


def test_a_loop_is_the_record_that_it_wrote(policy: Path, folder: Path) -> None:
    out = folder / "looped"
    outcome = morph.loop("balance", "cartpole", out, policy=policy, change=["weight:pole=1.1"])
    wrote = json.loads((out / "transfer.json").read_text())
    assert outcome.succeeded
    assert [row["success"] for row in outcome.rows()] == [
        trial["success"] for trial in wrote["hops"][0]["trials"]
    ]


def test_a_package_has_the_masses_that_it_wrote(folder: Path) -> None:
    out = folder / "package"
    package = morph.print_package("quadruped_printed", "mk4", "pla", out, slicer="none")
    wrote = json.loads((out / "package.json").read_text())
    masses = {row["part"]: row["grams"] for row in package.rows()}
    assert masses
    assert sum(row["copies"] * row["grams"] for row in package.rows()) == pytest.approx(
        package.job.grams
    )
    assert set(masses) <= {part["name"] for part in wrote["parts"]}


def test_a_view_is_served_until_it_is_closed() -> None:
    viewer = morph.view("pendulum", port=18080)
    try:
        with urllib.request.urlopen(viewer.address, timeout=60) as page:
            assert page.status == 200
    finally:
        viewer.close()
