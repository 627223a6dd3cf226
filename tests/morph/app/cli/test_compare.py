from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from morph.app.cli import compare
from morph.app.cli.main import main
from morph.body.load import load
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.physics.store import effects_text
from morph.record.write import write
from morph.sim.simulator import Simulator

SCHEMA = json.loads(Path(compare.__file__).with_name("comparison.schema.json").read_text())

Out = pytest.CaptureFixture[str]


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A pendulum's swing of 5 s with friction that the description lacks."""
    found = Simulator(load("pendulum"), (CoulombFriction(joint="hinge", c=0.2),)).run(
        seconds=5.0,
        start={"hinge": 0.6},
        command={"hinge": lambda times: 0.5 * np.sin(7.0 * times)},
    )
    write(found, tmp_path / "swing.csv")
    return tmp_path / "swing.csv"


def test_what_parts_is_told_with_the_commands_that_show_and_name_it(run: Path, capsys: Out) -> None:
    assert main(["compare", "pendulum", str(run), "--quiet"]) == 0
    said = capsys.readouterr().out
    assert "pendulum as described, beside 1 recording of 5 s (4 rollouts of 1 s" in said
    assert "1 of 1 channels differ by more than noise and the rollouts' starts make" in said
    assert "hinge.position:" in said
    assert "most in swing from" in said
    assert f"morph view pendulum --recording {run} --first mismatch" in said
    assert f"morph diagnose pendulum {run} --out DIR" in said


def test_effects_of_a_file_act(tmp_path: Path, run: Path, capsys: Out) -> None:
    effects = tmp_path / "effects.toml"
    effects.write_text(effects_text((CoulombFriction(joint="hinge", c=0.2),)))
    errors = []
    for more in ([], ["--effects", str(effects)]):
        assert main(["compare", "pendulum", str(run), "--json", *more]) == 0
        errors.append(json.loads(capsys.readouterr().out)["channels"][0]["error"])
    # It is the law of the run.
    assert errors[1] < 0.1 * errors[0]


def test_json_follows_its_schema(run: Path, capsys: Out) -> None:
    assert main(["compare", "pendulum", str(run), "--json", "--horizon", "full"]) == 0
    said = json.loads(capsys.readouterr().out)
    jsonschema.validate(said, SCHEMA)
    assert said["horizon"] is None
    assert [each["channel"] for each in said["channels"]] == ["hinge.position"]


def test_the_worst_moment_is_seen_again_in_the_viewer(
    run: Path, tmp_path: Path, capsys: Out
) -> None:
    state, page = tmp_path / "view.json", tmp_path / "page.html"
    words = ["compare", "pendulum", str(run), "--quiet", "--json"]
    assert main([*words, "--state", str(state), "--html", str(page)]) == 0
    worst = json.loads(capsys.readouterr().out)["channels"][0]["worst"]
    saved = json.loads(state.read_text())
    assert saved["clock"]["time"] == pytest.approx(worst["start"], abs=1e-9)
    assert saved["views"]["mismatch"]["recording"] == "swing"
    assert "hinge.position" in page.read_text(encoding="utf-8")
    # What the words say to type is what opens it.
    again = tmp_path / "again.html"
    assert main(["view", "--state", str(state), "--html", str(again), "--quiet"]) == 0
    assert again.stat().st_size > 1e5


@pytest.mark.parametrize(("words", "what"), [
    ("--horizon soon", "'soon' is no horizon"),
    ("--html .", "--html .: it is a folder"),
    ("--state /proc/none/view.json", "nothing can be written there"),
    ("--world nowhere", "nowhere"),
])  # fmt: skip
def test_what_cannot_be_done_is_one_message(run: Path, capsys: Out, words: str, what: str) -> None:
    assert main(["compare", "pendulum", str(run), *words.split(), "--quiet"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert what in said.err
    assert "fix: " in said.err
    assert "Traceback" not in said.err


def test_what_floats_is_compared_as_it_floats(tmp_path: Path, capsys: Out) -> None:
    box, run = tmp_path / "box.urdf", tmp_path / "run.csv"
    box.write_text(
        '<robot name="box"><link name="hull"><inertial><mass value="2"/>'
        '<inertia ixx="0.01" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        "</robot>"
    )
    floats = ["--base", "floating"]
    simulate = ["simulate", str(box), *floats, "--seconds", "1", "--out", str(run), "--quiet"]
    assert main(simulate) == 0
    capsys.readouterr()
    assert main(["compare", str(box), str(run), *floats, "--quiet"]) == 0
    told = capsys.readouterr().out
    assert "hull.position.z" in told
    # The commands that go on say so too.
    assert told.count("--base floating") == 2
    assert main(["compare", str(box), str(run), "--quiet"]) == 2
