"""A card may say more than a diagnosis needs; what it measures counts."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.body import shelf
from morph.body.load import load
from morph.record.write import write
from morph.sim.simulator import Simulator

MORE = """
[[measured]]
link = "rod"
mass_kg = 1.25

[[parameter]]
name = "length"
link = "rod"
operation = "scale"
low = 0.8
high = 1.2

[print]
printed = ["rod"]

[[print.bought]]
part = "a screw"
count = 4
mass_kg = 0.002
link = "rod"
"""


@pytest.fixture
def body(tmp_path: Path) -> Path:
    """A copy of the pendulum, whose card has everything that a card may have."""
    folder = shutil.copytree(shelf.find("pendulum"), tmp_path / "pendulum")
    text = (folder / "card.toml").read_text().replace("mass_kg = 1.0", "mass_kg = 1.25", 1)
    (folder / "card.toml").write_text(text + MORE)
    return folder


def test_a_diagnosis_takes_a_card_that_says_more(
    body: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = load(body)
    assert robot.mass == pytest.approx(1.25)
    run = Simulator(robot, step=0.01).run(
        seconds=5.0,
        start={"hinge": 0.4},
        command={"hinge": lambda times: 0.5 * np.sin(7.0 * times)},
    )
    path, out = write(run, tmp_path / "run.npz"), tmp_path / "out"
    # Half a microsecond is spent before anything is looked for.
    asked = [str(body), str(path), "--out", str(out), "--quiet", "--budget", "5e-7"]
    assert main(["diagnose", *asked]) == 3
    assert capsys.readouterr().err == ""
    assert json.loads((out / "diagnosis.json").read_text())["robot"] == "pendulum"
